// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/error.hpp"
#include "hal/sim/cylinder.hpp"

namespace eha::replay {
namespace {

constexpr double kMetrePerInch = 0.0254;
constexpr double kMillimetrePerInch = 25.4;

}  // namespace

Eigen::VectorXd displacement_in(const hal::SimOptions& options, const Eigen::Ref<const Eigen::VectorXd>& volts,
                                double step_s) {
  const auto issues = hal::check(options);
  if (!issues.empty()) throw ConfigError(to_lines(issues, "sim"));
  hal::Cylinder cylinder(options);
  Eigen::VectorXd displacement(volts.size());
  for (Eigen::Index k = 0; k < volts.size(); ++k) {
    displacement[k] = cylinder.state().displacement_m / kMetrePerInch;
    cylinder.advance(volts[k], hal::Ports::open, step_s);
  }
  return displacement;
}

Eigen::VectorXd measured_in(const ident::Record& record) {
  const std::string& unit = record.output_channel.unit;
  if (record.input_channel.unit != "V" || (unit != "in" && unit != "mm")) {
    throw DataError(fmt::format("the record is in \"{}\" and \"{}\"; the simulated rig takes V and gives in or mm",
                                record.input_channel.unit, unit));
  }
  return unit == "in" ? record.output : Eigen::VectorXd(record.output / kMillimetrePerInch);
}

hal::SimOptions starting_at(hal::SimOptions options, double displacement_in) {
  options.initial_displacement_in = std::clamp(displacement_in, 0.0, options.stroke_mm / kMillimetrePerInch);
  return options;
}

}  // namespace eha::replay
