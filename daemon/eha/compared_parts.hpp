// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/eha/change_text.hpp"
#include "daemon/eha/comparison_answer.hpp"
#include "daemon/report/change_causes.hpp"
#include "daemon/report/comparison_page.hpp"
#include "ident/model/model.hpp"
#include "ident/validation/parameter_change.hpp"

// What the answers of a comparison have in common, whatever was compared.

namespace eha::cli {

/// The parameters of two fits with their differences and joint intervals, and what each leaves over.
[[nodiscard]] std::string table_of(const report::ComparedSubject& first, const report::ComparedSubject& subject,
                                   Shows shows = Shows::change);

/// Adds what changed, beginning with the name of the run.
void add_changes(std::vector<std::string>& sentences, const std::string& name, const ident::PlantChange& change,
                 const ident::Model& model, Shows shows = Shows::change);

/// Least and greatest input of a record; none of an empty one.
[[nodiscard]] std::optional<std::pair<double, double>> input_range(const ident::Record& record);

/// Says what to look at on the bench, where a parameter is shown to have changed.
/// @param source  the last one with a change   @param found  what explains another map
/// @param complete  makes the commands of the advice whole; none: for the rig of the console
void add_to_do(Compared& out, const std::vector<const ident::PlantChange*>& changes, std::size_t source,
               std::string_view then, report::MapCause found = report::MapCause::unknown,
               const std::function<std::string(const std::string&)>& complete = {});

inline constexpr std::string_view kRejected = "rejected";
inline constexpr std::string_view kNoGrade = "-";

/// The verdict of the fit that made a model, as its file has it; kNoGrade without one.
[[nodiscard]] std::string grade_of(const ident::Model& model);

}  // namespace eha::cli
