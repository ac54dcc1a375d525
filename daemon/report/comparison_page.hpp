// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "daemon/report/page.hpp"
#include "ident/model/model.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::report {

/// One of the runs or models that are compared.
struct ComparedSubject {
  std::string label;  ///< "runs/before"
  ident::Model model;
  std::optional<ident::PlantChange> change = {};  ///< from the first one to this one; none for the first
  // The record and the model on it, of one length; empty for a model alone.
  Eigen::VectorXd time_s = {};
  Eigen::VectorXd measured = {};
  Eigen::VectorXd simulated = {};
};

/// What a comparison found.
struct ComparisonFindings {
  std::string title;    ///< "Comparison of before and after"
  std::string heading;  ///< "The plant has changed"
  bool is_alike = false;
  std::vector<std::string> sentences = {};
};

/// Short names of runs, records and model files that are told apart: a run's folder, a file's name without its ending,
/// with the folder above it where two are alike. A link is followed.
[[nodiscard]] std::vector<std::string> titles_of(const std::vector<std::string>& paths);

/// The before/after report: findings, parameters with joint intervals, valves, steps, records and Bode plots over one
/// another.
/// @param subjects  at least one; values in the unit that is to be read. Cost as assembled()
[[nodiscard]] Page comparison_page(const ComparisonFindings& findings, const std::vector<ComparedSubject>& subjects);

}  // namespace eha::report
