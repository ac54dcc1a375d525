// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/limit_checks.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "config/needs_following.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/limit_remarks.hpp"
#include "hal/backends/backend.hpp"

namespace eha::doctor {

Check check_limits(const config::RigConfig& rig, std::chrono::sys_days today) {
  std::vector<std::string> loose = limit_remarks(rig, today);
  if (!hal::moves_machine(rig.backend) && !rig.limits.following) loose.emplace_back(config::kNotFollowed);
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

Check check_limits(const config::RigConfig& rig) {
  return check_limits(rig, std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
}

}  // namespace eha::doctor
