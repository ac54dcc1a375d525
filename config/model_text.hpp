// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// Writes the `[[model]]` table of an experiment file from which read_models() reads these options. A structure that no
/// keys of its family describe is written term by term.
[[nodiscard]] std::string model_table(const ident::StructureOptions& asked);

}  // namespace eha::config
