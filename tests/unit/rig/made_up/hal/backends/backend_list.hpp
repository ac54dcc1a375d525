// SPDX-License-Identifier: GPL-3.0-or-later
// Found instead of the project's own list: the same with a backend that drives a machine.
#pragma once

#include <variant>

#include "hal/comedi/comedi_rig.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::hal {

/// A driving backend that is in this list only.
struct MadeUpOptions {
  static constexpr std::string_view kName = "made_up";
  static constexpr bool kMovesMachine = true;
  static constexpr bool kHasVirtualClock = false;

  std::string port = "/dev/made-up";
  double gain_V = 0.0;

  static void visit_keys(auto& self, auto& keys) {
    keys.text("port", self.port);
    keys.number("gain_V", self.gain_V, Range::above(0.0), Need::optional);
  }
  [[nodiscard]] std::string describe() const { return port + " (made up)"; }
  [[nodiscard]] Conversion conversion() const {
    return {.command_min_V = -10.0,
            .command_max_V = 10.0,
            .feedback_min_V = -10.0,
            .feedback_max_V = 10.0,
            .scale_in_per_V = 1.0,
            .offset_in = 0.0,
            .calibration_date = {}};
  }
  [[nodiscard]] static SafeAction safe_action(std::string_view snapshot, std::string_view file_name);
};

[[nodiscard]] std::vector<OptionIssue> check(const MadeUpOptions& options);
[[nodiscard]] std::unique_ptr<Rig> open_rig(const MadeUpOptions& options, double safe_V);

using Backend = std::variant<SimOptions, ComediOptions, MadeUpOptions>;

}  // namespace eha::hal
