// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/limit_checks.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "config/needs_following.hpp"
#include "daemon/rig/arming.hpp"
#include "hal/backends/backend.hpp"

namespace eha::doctor {
namespace {

// No standard defines these. They are far beyond the motions of a cylinder of this kind, so a good rig file never
// reaches them.
constexpr double kLongestFrozen_s = 2.0;
constexpr double kLongestLate_s = 0.1;

/// What is watched less closely than a machine needs.
std::vector<std::string> loose_limits(const config::RigConfig& rig) {
  const config::RigLimits& limits = rig.limits;
  const config::RealtimeOptions& realtime = rig.realtime;
  std::vector<std::string> loose;
  if (limits.frozen_sensor_s <= 0.0) {
    loose.emplace_back("limits.frozen_sensor_s is off: a stuck sensor is not detected");
  } else if (limits.frozen_sensor_s > kLongestFrozen_s) {
    loose.push_back(fmt::format("limits.frozen_sensor_s = {:g} s: a stuck sensor stays undetected for that long",
                                limits.frozen_sensor_s));
  }
  const double late_s = realtime.abort_consecutive_late * realtime.sample_period_s;
  if (late_s > kLongestLate_s) {
    loose.push_back(fmt::format("realtime.abort_consecutive_late = {}: the loop may be late for {:.2g} s in a row",
                                realtime.abort_consecutive_late, late_s));
  }
  return loose;
}

}  // namespace

Check check_limits(const config::RigConfig& rig) {
  std::vector<std::string> loose;
  if (hal::moves_machine(rig.backend)) {
    loose = loose_limits(rig);
  } else if (!rig.limits.following) {
    loose.emplace_back(config::kNotFollowed);
  }
  const ArmingFindings findings = arming_findings(rig);
  if (!findings.refusals.empty()) {
    return fail("limits", fmt::format("the rig cannot be armed\n{}", fmt::join(findings.refusals, "\n")),
                "set what is named in the rig file, see eha-rig(5)", ExitCode::configuration);
  }
  loose.insert(loose.end(), findings.warnings.begin(), findings.warnings.end());
  if (loose.empty()) return ok("limits", "travel, speed, following, dead sensor and late loop are watched");
  return warn("limits", fmt::format("{}", fmt::join(loose, "\n")),
              "set what the rig needs; rigs/pci1716.toml gives a start, eha-rig(5) the meaning");
}

}  // namespace eha::doctor
