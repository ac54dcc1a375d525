// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "core/inch.hpp"
#include "core/millimetre_key.hpp"
#include "hal/sim/cylinder.hpp"

namespace eha::replay {
namespace {

constexpr double kNanoseconds = 1e9;

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

ident::Record recorded(const hal::SimOptions& options, const Eigen::Ref<const Eigen::VectorXd>& volts, double step_s,
                       std::uint64_t seed, hal::Integration integration) {
  hal::SimOptions seeded = options;
  seeded.seed = seed;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(seeded, 0.0, integration);
  static_cast<void>(rig->set_enable(true));
  ident::Record record;
  record.step_s = step_s;
  record.input.resize(volts.size());
  record.output.resize(volts.size());
  for (Eigen::Index k = 0; k < volts.size(); ++k) {
    hal::RigReading reading;
    static_cast<void>(rig->read(std::llround(kNanoseconds * step_s * static_cast<double>(k)), reading));
    record.output[k] = reading.displacement_in;
    hal::AppliedCommand applied;
    static_cast<void>(rig->command(volts[k], applied));
    record.input[k] = applied.applied_V;
  }
  return record;
}

Eigen::VectorXd measured_in(const ident::Record& record) {
  const std::string& unit = record.output_channel.unit;
  if (record.input_channel.unit != "V" || (unit != "in" && unit != "mm")) {
    throw DataError(fmt::format("the record is in \"{}\" and \"{}\"; the simulated rig takes V and gives in or mm",
                                record.input_channel.unit, unit));
  }
  return unit == "in" ? record.output : Eigen::VectorXd(record.output / kMillimetresPerInch);
}

hal::SimOptions starting_at(hal::SimOptions options, double displacement_in) {
  options.initial_displacement_in = std::clamp(displacement_in, 0.0, options.stroke_mm / kMillimetresPerInch);
  return options;
}

}  // namespace eha::replay
