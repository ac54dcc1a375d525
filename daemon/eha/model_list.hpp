// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "daemon/eha/console.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::cli {

/// Prints the models of a run: a table, then the reasons for each verdict. A missing figure shows as "-".
void print_model_list(const std::vector<record::ModelEntry>& models, const Console& console);

}  // namespace eha::cli
