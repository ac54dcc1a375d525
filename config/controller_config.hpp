// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/keys.hpp"
#include "ident/control/axis_controller.hpp"

namespace eha::config {

/// A promised figure: its value for the undrawn model or twin, and bounds that contain 95 % of the draws.
struct PromisedFigure {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("value", self.value, Range::any());
    keys.number("lower", self.lower, Range::any());
    keys.number("upper", self.upper, Range::any());
  }
};

/// [promise]: an error is the generated reference less the rod's position, in trapezoids at the reference's limits, a
/// sine and a hold of 60 s.
struct ControllerPromise {
  std::int64_t twins = 0;  ///< number of simulated rigs that the controller was tried on
  PromisedFigure following_rms_in;
  PromisedFigure following_worst_in;
  PromisedFigure sine_rms_in;
  PromisedFigure overshoot_in;
  PromisedFigure settling_s;
  PromisedFigure rest_error_in;
  PromisedFigure standing_in;  ///< peak to peak at rest
  PromisedFigure ms;
  PromisedFigure mt;
  PromisedFigure phase_margin_deg;
  PromisedFigure gain_margin;
  PromisedFigure delay_margin_s;
  std::string remarks = {};  ///< limiting factors, and improvements by other kinds of feedback; a sentence a line

  static void visit_keys(auto& self, auto& keys) {
    keys.integer("twins", self.twins, 1, 100000);
    keys.table("following_rms_in", self.following_rms_in);
    keys.table("following_worst_in", self.following_worst_in);
    keys.table("sine_rms_in", self.sine_rms_in);
    keys.table("overshoot_in", self.overshoot_in);
    keys.table("settling_s", self.settling_s);
    keys.table("rest_error_in", self.rest_error_in);
    keys.table("standing_in", self.standing_in);
    keys.table("ms", self.ms);
    keys.table("mt", self.mt);
    keys.table("phase_margin_deg", self.phase_margin_deg);
    keys.table("gain_margin", self.gain_margin);
    keys.table("delay_margin_s", self.delay_margin_s);
    keys.lines("remarks", self.remarks, Need::optional);
  }
};

/// [fault]: limits whose violation ends a run of this controller.
struct ControllerFaults {
  double following_error_in = 0.0;  ///< greatest absolute difference of reference and reading [in]
  double swing_V = 0.0;             ///< a swing goes from null + swing_V to null - swing_V or back [V]
  double swings_per_s = 0.0;        ///< most swings in one second

  static void visit_keys(auto& self, auto& keys) {
    keys.number("following_error_in", self.following_error_in, Range::above(0.0));
    keys.number("swing_V", self.swing_V, Range::above(0.0));
    keys.number("swings_per_s", self.swings_per_s, Range::above(0.0));
  }
};

/// [provenance]: inputs of the design. A controller is played on this rig only.
struct ControllerProvenance {
  std::string model;  ///< file
  std::string model_sha256;
  std::string rig;  ///< name in its file
  std::string rig_file;
  std::string rig_sha256;  ///< of the rig file's content
  std::string twin;        ///< file of the twin, or description of its origin
  std::string run;         ///< that the model is from; "unknown"
  std::string sheet = {};  ///< run of the valve sheet; empty: none
  std::string made_by;     ///< program and version

  static void visit_keys(auto& self, auto& keys) {
    keys.text("model", self.model);
    keys.text("model_sha256", self.model_sha256);
    keys.text("rig", self.rig);
    keys.text("rig_file", self.rig_file);
    keys.text("rig_sha256", self.rig_sha256);
    keys.text("twin", self.twin);
    keys.text("run", self.run);
    keys.text("sheet", self.sheet, Need::optional);
    keys.text("made_by", self.made_by);
  }
};

/// A whole controller.toml. Lengths are in inches, commands in volts.
struct ControllerConfig {
  std::string name;
  std::string purpose = "track";  ///< or "hold"
  ident::AxisSettings settings;
  ControllerPromise promise;
  ControllerFaults fault;
  ControllerProvenance provenance;
  std::string file_name;  ///< as given, for messages
};

/// Reads a controller file, eha-controller(5).
/// @throws ConfigError  missing, unreadable, not TOML, or wrong: every error at once, with line and column
/// @throws PermissionError  the caller may not read it
[[nodiscard]] ControllerConfig load_controller(const std::string& path);
[[nodiscard]] ControllerConfig parse_controller(std::string_view text, const std::string& file_name);

/// Writes the file's text. Numbers have the fewest digits that give the same number back; infinite margins are written
/// as 1e9.
[[nodiscard]] std::string controller_text(const ControllerConfig& controller);

}  // namespace eha::config
