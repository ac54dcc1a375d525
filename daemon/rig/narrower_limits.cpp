// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/narrower_limits.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <system_error>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

enum class Side { lowest, highest };

/// A limit of the rig; narrower is the greater value at the lowest side, the smaller one at the highest side.
struct Limit {
  const char* name;
  double config::RigLimits::*value;
  Side side;
  const char* unit;
};

constexpr Limit kLimits[] = {{"travel_min", &config::RigLimits::travel_min_in, Side::lowest, "in"},
                             {"travel_max", &config::RigLimits::travel_max_in, Side::highest, "in"},
                             {"command_min", &config::RigLimits::command_min_V, Side::lowest, "V"},
                             {"command_max", &config::RigLimits::command_max_V, Side::highest, "V"},
                             {"velocity_limit", &config::RigLimits::velocity_limit_in_per_s, Side::highest, "in/s"},
                             {"slew", &config::RigLimits::slew_V_per_s, Side::highest, "V/s"}};

/// The same length in a file in inches and in one in millimetres.
constexpr double kSame = 1e-9;

}  // namespace

std::vector<std::string> narrower_limits(const config::RigConfig& in_force, const config::RigConfig& edited) {
  const DisplayUnit unit(in_force.units);
  std::vector<std::string> narrower;
  for (const Limit& limit : kLimits) {
    const double now = in_force.limits.*limit.value;
    const double then = edited.limits.*limit.value;
    if ((limit.side == Side::lowest ? then - now : now - then) <= kSame) continue;
    const double factor = unit.factor(limit.unit);
    const std::string shown = unit.of(limit.unit);
    narrower.push_back(
        fmt::format("{} {:.6g} {} ({:.6g} {} in force)", limit.name, factor * then, shown, factor * now, shown));
  }
  const double moved_in = std::abs(
      greatest_shift(in_force.limits, hal::conversion_of(in_force.backend), hal::conversion_of(edited.backend)).by_in);
  if (moved_in > kSamePlace_in) {
    narrower.push_back(fmt::format("a calibration by which the rod stands up to {:.3g} {} elsewhere",
                                   unit.factor("in") * moved_in, unit.of("in")));
  }
  return narrower;
}

void require_no_narrower_limits(const config::RigConfig& in_force, const std::filesystem::path& file,
                                std::string_view remedy) {
  std::vector<std::string> narrower;
  try {
    narrower = narrower_limits(in_force, config::load_rig(file.string()));
  } catch (const ConfigError& error) {
    throw ConfigError(
        fmt::format("{} was edited since it was read, and is not valid now, so that nobody can tell the limits that it "
                    "means; nothing moves on those of before: correct it ({}), then {}",
                    file.string(), error.what(), remedy));
  } catch (const Error& error) {
    throw ConfigError(fmt::format(
        "{} cannot be read any more, so that nobody can tell the limits that it has now ({}); nothing moves "
        "on those of before: put it back, readable for the service, then {}",
        file.string(), error.what(), remedy));
  }
  if (narrower.empty()) return;
  throw ConfigError(
      fmt::format("{} was edited since it was read, and has narrower limits: {}; nothing moves on those of before: {}",
                  file.string(), fmt::join(narrower, ", "), remedy));
}

}  // namespace eha
