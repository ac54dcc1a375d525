// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/table_excitation.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace eha::ident {
namespace {

/// Relative tolerance, because times in a file are rounded to decimals.
constexpr double kStepTolerance = 1e-6;

}  // namespace

std::vector<OptionIssue> Table::check_timing(double step_s, double duration_s) const {
  if (file.step_s && std::abs(*file.step_s - step_s) > kStepTolerance * step_s) {
    return {{"file", fmt::format("expected rows spaced by the rig's tick of {} s, got {:.6g} s in {}", step_s,
                                 *file.step_s, file.name)}};
  }
  const auto ticks = static_cast<std::size_t>(std::llround(duration_s / step_s));
  if (file.volts_V.size() != ticks) {
    return {{"file", fmt::format("expected {} rows, one for each tick of {} s in duration_s = {}, got {} in {}", ticks,
                                 step_s, duration_s, file.volts_V.size(), file.name)}};
  }
  return {};
}

Eigen::VectorXd Table::volts(double step_s, std::size_t samples) const {
  const auto issues = check_timing(step_s, step_s * static_cast<double>(samples));
  if (!issues.empty()) throw ConfigError(to_lines(issues, "excitation"));
  return Eigen::Map<const Eigen::VectorXd>(file.volts_V.data(), static_cast<Eigen::Index>(samples));
}

}  // namespace eha::ident
