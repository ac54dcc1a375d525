// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/model.hpp"
#include "ident/validation/explanation.hpp"

namespace eha::identify {

constexpr double kClearlyLess = 0.9;  // of an error on unseen data

/// A structure beside those of a table that holds, and what it is told by; its ratio depends on the model beside it.
struct Trial {
  ident::Model model;
  ident::Explanation explanation;
};

/// How a structure beside the table's is fitted.
struct Manner {
  ident::Search search;
  const std::vector<ident::Model>& known;
  std::optional<double> most_mse = {};  ///< as of ident::FitOptions
};

/// The structure fitted to the record as `eha fit --model` does; none where it does not hold.
/// @param prepared  the task's record
[[nodiscard]] std::optional<ident::Model> fit_that_holds(const IdentificationTask& task,
                                                         const ident::PreparedRecord& prepared,
                                                         const ident::StructureOptions& asked, const Manner& manner);

}  // namespace eha::identify
