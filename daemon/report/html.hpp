// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ident/model/model.hpp"

// Text as HTML. Every function escapes its arguments, unless it says that it takes HTML.

namespace eha::report {

/// Escapes text: &, <, > and quotes become entities, control characters but line ends spaces, and bytes that are no
/// UTF-8 '?'.
[[nodiscard]] std::string escaped(std::string_view text);

/// "2026-01-31 14:05:00 UTC" of the "2026-01-31T14:05:00Z" of a manifest; another text stays.
[[nodiscard]] std::string utc_text(std::string text);

/// The same, with what stands between two backticks as code: commands as the messages of the programs quote them.
[[nodiscard]] std::string with_code(std::string_view text);

[[nodiscard]] std::string paragraph(std::string_view text);

/// An unordered list. @returns nothing for no items
[[nodiscard]] std::string list(const std::vector<std::string>& items);

/// Alignment of a column, and whether it may break a word: `name` a long one, `wide_text` a sentence's.
enum class Column { text, number, name, id, wide_text };  // an id breaks behind its hyphens

struct TableColumn {
  std::string heading;
  Column kind = Column::text;
};

/// Writes a table that scrolls separately if the page is narrower. Cells are text.
[[nodiscard]] std::string table(const std::vector<TableColumn>& columns,
                                const std::vector<std::vector<std::string>>& rows);

/// Whether the level at which the model's output ends is known better than thirty times its rms error where it was
/// estimated. Of a plant that does not settle within the record it lies far from where the output can be.
[[nodiscard]] bool reaches_its_offset(const ident::Model& model);

/// The model's equation as HTML: G(s), delay, valve map or bias, initial output.
[[nodiscard]] std::string equation(const ident::Model& model);

}  // namespace eha::report
