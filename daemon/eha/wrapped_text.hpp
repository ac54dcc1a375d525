// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace eha::cli {

inline constexpr std::size_t kPrintedWidth = 80;  ///< of the lines of an answer [columns]
inline constexpr std::size_t kLabelWidth = 16;  ///< columns before the text of a line, "because         The plant ..."

/// Breaks words into lines of at most 80 columns. @param indent  blanks before every line but the first
[[nodiscard]] std::string wrapped(const std::string& text, std::size_t indent);

/// Breaks the lines of a printed text that completed commands have made too long, under the text that they begin with.
/// @param text       as it was laid out
/// @param completed  the same lines
[[nodiscard]] std::string wrapped_where_longer(std::string_view text, const std::string& completed);

}  // namespace eha::cli
