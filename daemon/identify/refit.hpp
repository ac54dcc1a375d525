// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "ident/fit_options.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"

namespace eha::identify {

/// Rows from the first on, which tell what the others would.
constexpr Eigen::Index kMostTriedRows = 20'000;

/// Root mean square of what a model errs by on the estimating part [output unit]. @param model  has an estimation
[[nodiscard]] double rms_error_of(const ident::Model& model);

/// Whether a model leaves something over that an input column may have made.
[[nodiscard]] bool misses_something(const ident::Model& model);

/// A structure fitted to another record.
struct Refit {
  double error = 0.0;     ///< rms [output unit]
  std::string name = {};  ///< of the structure
  ident::Model model = {};
};

/// The structure that errs least of these fitted to another record, each from where it was found and, where that is at
/// the edge of what rows show, from guessed poles, too; none where the record allows none. All rows estimate.
/// Cost: a local fit of each.
[[nodiscard]] std::optional<Refit> least_error_of(const std::vector<const IdentifiedModel*>& bases,
                                                  const ident::Record& record, ident::FitOptions options,
                                                  ident::Reported reported = ident::Reported::score);

/// These rows of a record.
[[nodiscard]] ident::Record rows_from(const ident::Record& record, Eigen::Index first, Eigen::Index count);

/// The first kMostTriedRows of a record. @param parts  rows of it for each of the file's
[[nodiscard]] ident::Record tried_rows(const ident::Record& record, Eigen::Index parts);

/// Stretches of a record, first and last row of each, ascending.
using Stretches = std::vector<std::pair<Eigen::Index, Eigen::Index>>;

/// Time of a row as options take it [s].
[[nodiscard]] std::string time_at(const ident::Record& record, Eigen::Index row);

/// First row and the row behind the last of the longest part without these stretches; none below a fifth of the rows.
[[nodiscard]] std::optional<std::pair<Eigen::Index, Eigen::Index>> longest_without(const Stretches& stretches,
                                                                                   Eigen::Index rows);

/// "--from 12.5 --to 48.2". @param part  first row and the row behind the last
[[nodiscard]] std::string cut_to(const std::pair<Eigen::Index, Eigen::Index>& part, const ident::Record& record);

}  // namespace eha::identify
