// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/toml_section.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::config {

/// Reads `kind`, offset_V and the kind's own keys; refuses keys that only other kinds have.
void read_excitation(Section& section, ident::Excitation& excitation, Document& document);

}  // namespace eha::config
