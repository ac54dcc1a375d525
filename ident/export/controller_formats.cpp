// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/controller_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/code_text.hpp"

namespace eha::ident {
namespace {

constexpr std::array kControllerFormats{
    ControllerFormat{"c", "C99 source without allocation, one call a tick", ".c", &controller_c_text},
    ControllerFormat{"st", "function block in structured text, IEC 61131-3", ".st", &controller_st_text},
    ControllerFormat{"octave", "function file for Octave, one call a tick", ".m", &controller_octave_text},
    ControllerFormat{"python", "module with one class, needs no package", ".py", &controller_python_text},
    ControllerFormat{"simulink", "function for a MATLAB Function block of Simulink", ".m", &controller_simulink_text}};

}  // namespace

std::span<const ControllerFormat> controller_formats() { return kControllerFormats; }

AxisSettings in_length_unit(AxisSettings s, double factor) {
  for (double* length : {&s.rest_error, &s.most_speed, &s.inverse.gain_positive, &s.inverse.gain_negative,
                         &s.inverse.smoothing, &s.feed_forward.rest, &s.reference.lowest, &s.reference.highest,
                         &s.reference.velocity, &s.reference.acceleration, &s.reference.jerk}) {
    *length *= factor;
  }
  return s;
}

std::vector<std::string> controller_notes(const AxisCoefficients& c, std::string_view name,
                                          const std::string& length_unit) {
  const AxisSettings& s = c.settings;
  const std::string length = code_text(length_unit, 10);
  return {
      fmt::format("Controller of an axis: {}, made by eha tune.", code_text(name, 60)),
      fmt::format("Position in {}, command in V; call it every {:g} s, no more and no less.", length, s.tick_s),
      fmt::format("Feedback {}: kp {:.6g} /s, ki {:.6g} /s^2, kd {:.6g}, filter {:g} s; orders {:g} and {:g}.",
                  text(s.kind), s.feedback.kp, s.feedback.ki, s.feedback.kd, s.feedback.filter_s,
                  s.feedback.integral_order, s.feedback.derivative_order),
      fmt::format("Reference within {0:g} .. {1:g} {5}, {2:.4g} {5}/s, {3:.4g} {5}/s^2, {4:.4g} {5}/s^3.",
                  s.reference.lowest, s.reference.highest, s.reference.velocity, s.reference.acceleration,
                  s.reference.jerk, length),
      fmt::format("Command within {:g} .. {:g} V, {:g} V/s. The limits of the rig come after it.", s.command_min,
                  s.command_max, s.slew_per_s),
  };
}

std::vector<std::pair<std::string, double>> controller_numbers(const AxisCoefficients& c) {
  const AxisSettings& s = c.settings;
  return {{"tick", s.tick_s},
          {"lowest", s.reference.lowest},
          {"highest", s.reference.highest},
          {"least_reading", s.reference.least_reading()},
          {"greatest_reading", s.reference.greatest_reading()},
          {"velocity_limit", s.reference.velocity},
          {"acceleration_limit", s.reference.acceleration},
          {"taps", static_cast<double>(c.taps)},
          {"filter_b", c.filter_gain},
          {"filter_a1", c.filter_a1},
          {"filter_a2", c.filter_a2},
          {"kp", s.feedback.kp},
          {"ki_tick", s.tick_s * s.feedback.ki},
          {"kd", s.feedback.kd},
          {"integral_direct", c.integral.direct},
          {"derivative_direct", c.derivative.direct},
          {"rest_error", s.rest_error},
          {"back", s.feedback.ki > 0.0 ? s.tick_s / s.tracking_s : 0.0},
          {"most_speed", s.most_speed},
          {"position_rate", s.feed_forward.position_rate},
          {"rest", s.feed_forward.rest},
          {"velocity_share", s.feed_forward.velocity_share},
          {"acceleration_s", s.feed_forward.acceleration_s},
          {"valve_null", s.inverse.null},
          {"dead_band", s.inverse.dead_band},
          {"gain_positive", s.inverse.gain_positive},
          {"gain_negative", s.inverse.gain_negative},
          {"smoothing", s.inverse.smoothing},
          {"command_min", s.command_min},
          {"command_max", s.command_max},
          {"slew_tick", s.slew_per_s * s.tick_s}};
}

std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  // IEC 61131-3 wants a point before an exponent.
  if (const std::size_t e = text.find('e'); e != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(e, ".0");
  }
  return text;
}

std::string real_list(const std::array<double, FractionalFilter::kLags>& values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, count); ++i) {
    text += (i > 0 ? ", " : "") + real_text(count > 0 ? values.at(i) : 0.0);
  }
  return text;
}

std::string with_values(std::string text, const std::vector<std::pair<std::string, std::string>>& values) {
  for (const auto& [name, value] : values) {
    const std::string token = "@" + name + "@";
    for (std::size_t at = 0; (at = text.find(token, at)) != std::string::npos; at += value.size()) {
      text.replace(at, token.size(), value);
    }
  }
  return text;
}

}  // namespace eha::ident
