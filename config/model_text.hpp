// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/structure/structure_options.hpp"

namespace eha::config {

/// The `[[model]]` table of an experiment file from which read_models() reads these options. A form of a family that no
/// key names is written term by term.
[[nodiscard]] std::string model_table(const ident::StructureOptions& asked);

}  // namespace eha::config
