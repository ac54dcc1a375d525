// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/keys.hpp"
#include "core/option_issue.hpp"
#include "core/volts_file.hpp"

namespace eha::ident {

/// Volts from a CSV file, one a tick. Nothing is resampled: the file has one value for each tick, and its step, if
/// given, equals the rig's tick.
struct Table {
  static constexpr std::string_view kName = "table";

  VoltsFile file;

  static void visit_keys(auto& self, auto& keys) { keys.volts_file("file", self.file); }

  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<OptionIssue> check_timing(double step_s, double duration_s) const;
};

}  // namespace eha::ident
