// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/batch/batch_table.hpp"

// What a table of records says in sentences.

namespace eha::batch {

/// "0006-mm, 0009-b": those records of the table, the first ones if they are many; empty without any.
[[nodiscard]] std::string other_units_text(const Table& table);

/// Why one record's model is good and another's usable; empty where the grades do not differ so.
[[nodiscard]] std::string grade_note(const Table& table);

/// "2 of 5 records (0001-sim, 0003-b): within half a row the input moves ...".
[[nodiscard]] std::string warning_text(const Table& table, const WarningKind& kind);

/// "null is 0.4 V, more than 0.05 V from the median of all, 0.3 V".
[[nodiscard]] std::string outlier_text(const Outlier& outlier);

/// What the outliers of a row may be of although another parameter shows them, as `eha compare` says; empty without.
[[nodiscard]] std::string instead_text(const Row& row, const std::string& common_model);

/// Why no model is recommended, as `eha fit` says; empty where one is.
[[nodiscard]] std::string why_none(const Row& row);

/// The first thing that was found and makes the recommended model of a record usable, not good; empty without.
[[nodiscard]] std::string what_limits(const Row& row);

/// Figures of the recommended model of a fit; empty without one. @param fit  models as `eha fit --json` gives them
[[nodiscard]] RowFigures figures_of(const nlohmann::ordered_json& fit, const std::string& recommended);

/// "K: median 0.1305 in/(V s), furthest from it 0.1312 (run-3); a change of 0.0021 in/(V s) or more would
/// have been seen in 0001, the most precise record, and of 0.12 V in 0003".
[[nodiscard]] std::string spread_text(const Table& table, const Resolution& one);

/// "rises by 0.16 V", "falls by 0.16 V".
[[nodiscard]] std::string change_text(const Trend& trend);

}  // namespace eha::batch
