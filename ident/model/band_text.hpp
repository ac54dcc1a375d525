// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// "0.02 to 7.9 Hz"; of a single line "0.1 Hz". @param to  between the ends
[[nodiscard]] std::string frequencies_text(const FrequencyInterval& band, std::string_view to = " to ");

/// Why a judged model has no usable band, a clause.
[[nodiscard]] std::string no_band_text(const Verdict& verdict);

}  // namespace eha::ident
