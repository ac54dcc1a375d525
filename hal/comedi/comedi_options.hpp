// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/keys.hpp"
#include "core/option_issue.hpp"
#include "hal/conversion.hpp"
#include "hal/safe_action.hpp"

namespace eha::hal {

/// Reference of an analog channel.
enum class AnalogReference { ground, common, diff, other };
inline constexpr auto kAnalogReferences =
    std::to_array<std::pair<std::string_view, AnalogReference>>({{"ground", AnalogReference::ground},
                                                                 {"common", AnalogReference::common},
                                                                 {"diff", AnalogReference::diff},
                                                                 {"other", AnalogReference::other}});

/// One analog channel: `[comedi.feedback]` (input) and `[comedi.command]` (output).
struct AnalogChannel {
  unsigned subdevice = 0;
  unsigned channel = 0;
  AnalogReference reference = AnalogReference::ground;
  double range_min_V = -10.0;  ///< the card must offer exactly this range [V]
  double range_max_V = 10.0;

  static void visit_keys(auto& self, auto& keys) {
    keys.integer("subdevice", self.subdevice, 0, 255);
    keys.integer("channel", self.channel, 0, 255);
    keys.choice("reference", self.reference, kAnalogReferences);
    keys.number("range_min_V", self.range_min_V, Range::any());
    keys.number("range_max_V", self.range_max_V, Range::any());
  }
};

/// Level of a digital line that means "on".
enum class ActiveLevel { high, low };
inline constexpr auto kActiveLevels =
    std::to_array<std::pair<std::string_view, ActiveLevel>>({{"high", ActiveLevel::high}, {"low", ActiveLevel::low}});

/// One digital line: `[comedi.emergency_stop]` (input), `[comedi.enable]` and `[comedi.heartbeat]` (outputs).
struct DigitalLine {
  unsigned subdevice = 0;
  unsigned channel = 0;  ///< 0..31
  /// Emergency stop: the level of the closed, healthy circuit. Enable: the level that powers the hydraulics.
  /// Heartbeat: the level first written; either level works.
  ActiveLevel active = ActiveLevel::high;

  static void visit_keys(auto& self, auto& keys) {
    keys.integer("subdevice", self.subdevice, 0, 255);
    keys.integer("channel", self.channel, 0, 31);
    keys.choice("active", self.active, kActiveLevels);
  }
};

/// Auxiliary contact of the enable contactor on a digital input: `[comedi.enable_contact]`.
struct ContactLine {
  unsigned subdevice = 0;
  unsigned channel = 0;                    ///< 0..31
  ActiveLevel active = ActiveLevel::high;  ///< level that the input has while the contactor is closed
  double follows_within_s = 0.1;           ///< after the enable line [s]

  static void visit_keys(auto& self, auto& keys) {
    keys.integer("subdevice", self.subdevice, 0, 255);
    keys.integer("channel", self.channel, 0, 31);
    keys.choice("active", self.active, kActiveLevels);
    keys.number("follows_within_s", self.follows_within_s, Range::between(0.001, 10.0));
  }
  [[nodiscard]] DigitalLine line() const { return {.subdevice = subdevice, .channel = channel, .active = active}; }
};

/// Device and wiring of a card, `[comedi]`. open_rig() refuses a card with any difference and lists the card's
/// properties.
struct ComediOptions {
  static constexpr std::string_view kName = "comedi";
  static constexpr bool kMovesMachine = true;
  static constexpr bool kHasVirtualClock = false;

  std::string device = "/dev/comedi0";
  std::string board;                   ///< name the driver reports, "pci1716"
  std::string driver;                  ///< name of the kernel driver, "adv_pci1710"
  int resolution_bits = 16;            ///< of both analog channels, 1..31
  AnalogChannel feedback;              ///< the displacement sensor
  double feedback_settling_us = 10.0;  ///< between selecting the channel and converting, 0..99 [us]
  AnalogChannel command;               ///< the valve
  std::optional<DigitalLine>
      emergency_stop;                    ///< normally closed; none only when the file says `emergency_stop = "none"`
  std::optional<DigitalLine> enable;     ///< hydraulics on; none only when the file says so
  std::optional<DigitalLine> heartbeat;  ///< toggles with every command; none only when the file says so

  std::optional<ContactLine> enable_contact;  ///< none: the contactor's position is not checked

  // displacement_in = offset_in + scale_in_per_V * feedback_V
  double scale_in_per_V = 0.0;   ///< displacement sensor, not zero [in/V]
  double offset_in = 0.0;        ///< displacement at 0 V [in]
  std::string calibration_date;  ///< of scale and offset, YYYY-MM-DD

  static void visit_keys(auto& self, auto& keys) {
    keys.text("device", self.device);
    keys.text("board", self.board);
    keys.text("driver", self.driver);
    keys.integer("resolution_bits", self.resolution_bits, 1, 31);
    keys.table("feedback", self.feedback);
    keys.number("feedback_settling_us", self.feedback_settling_us, Range::any(), Need::optional);
    keys.table("command", self.command);
    keys.table_or_none("emergency_stop", self.emergency_stop);
    keys.table_or_none("enable", self.enable);
    keys.table_or_none("heartbeat", self.heartbeat);
    keys.optional_table("enable_contact", self.enable_contact);
    keys.number("scale_in_per_V", self.scale_in_per_V, Range::any());
    keys.number("offset_in", self.offset_in, Range::any());
    keys.text("calibration_date", self.calibration_date);
  }

  [[nodiscard]] std::string describe() const { return device + " (" + board + ")"; }
  [[nodiscard]] bool powers_when_off() const { return enable && enable->active == ActiveLevel::low && !enable_contact; }
  /// Where sensor and valve are connected.
  [[nodiscard]] std::string wiring() const;
  [[nodiscard]] Conversion conversion() const {
    return {.command_min_V = command.range_min_V,
            .command_max_V = command.range_max_V,
            .feedback_min_V = feedback.range_min_V,
            .feedback_max_V = feedback.range_max_V,
            .scale_in_per_V = scale_in_per_V,
            .offset_in = offset_in,
            .calibration_date = calibration_date};
  }
  /// @param snapshot  a SafeSnapshot as text
  [[nodiscard]] static SafeAction safe_action(std::string_view snapshot, std::string_view file_name);
};

/// Returns every option that contradicts itself or another one, as far as can be checked without the card; empty if
/// there is none.
[[nodiscard]] std::vector<OptionIssue> check(const ComediOptions& options);

}  // namespace eha::hal
