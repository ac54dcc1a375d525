// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "daemon/sheet/run_sheet.hpp"

namespace eha::sheet {
namespace {

using ident::Measured;

std::string line(std::string_view name, const std::string& value) { return fmt::format("  {:<26} {}\n", name, value); }

std::string with_interval(const Measured& measured, double factor, int digits, const std::string& unit) {
  return fmt::format("{:.{}f} +- {:.{}f} {}", factor * measured.value, digits, factor * measured.half_width, digits,
                     unit);
}

std::string crossing(const char* name, const std::optional<Measured>& at_Hz) {
  if (!at_Hz) return fmt::format("{} not observed", name);
  return fmt::format("{} {:.2f} +- {:.2f} Hz", name, at_Hz->value, at_Hz->half_width);
}

/// One or two lines.
std::string response_lines(const ident::AmplitudeResponse& response) {
  if (!response.is_played) {
    return line(fmt::format("response to {:g} %", response.percent), "not played: limited by slew, range or travel");
  }
  const std::string name = fmt::format("response to {:g} % ({:g} V)", response.percent, response.amplitude_V);
  if (response.points.empty()) return line(name, "not observed: the sines entered the dead band");
  return line(name, fmt::format("measured from {:.2f} to {:.2f} Hz", response.points.front().frequency_Hz,
                                response.points.back().frequency_Hz)) +
         line("", fmt::format("{}, {}", crossing("-3 dB", response.minus_3dB_Hz),
                              crossing("-90 deg", response.minus_90deg_Hz)));
}

}  // namespace

std::string sheet_text(const RunSheet& run, const DisplayUnit& unit) {
  const ident::ValveSheet& sheet = run.sheet;
  const double factor = unit.factor("in");
  const std::string length = unit.of("in");
  const std::string gain_unit = length + "/(V s)";
  std::string text = fmt::format("valve sheet of \"{}\"; +- is half a 95 % interval\n", run.rig.name);
  text += line("null", with_interval(sheet.null_V, 1.0, 4, "V"));
  text += line("dead band, half width", with_interval(sheet.dead_band_V, 1.0, 4, "V"));
  text += line("velocity gain extending", with_interval(sheet.gain_positive_in_per_V_s, factor, 5, gain_unit));
  text += line("velocity gain retracting", with_interval(sheet.gain_negative_in_per_V_s, factor, 5, gain_unit));
  text += line("retracting / extending",
               fmt::format("{:.3f}", sheet.gain_negative_in_per_V_s.value / sheet.gain_positive_in_per_V_s.value));
  text += line("hysteresis", sheet.has_hysteresis ? with_interval(sheet.hysteresis_V, 1.0, 4, "V")
                                                  : fmt::format("none found above {:.4f} V",
                                                                std::max(0.01, sheet.hysteresis_V.half_width)));
  text += line("drift inside the dead band", sheet.creep_in_per_s
                                                 ? with_interval(*sheet.creep_in_per_s, factor, 5, length + "/s")
                                                 : "not observed: the dead band is too narrow");
  text += line("sensor noise, rms", fmt::format("{:.5f} {}", factor * sheet.noise_in, length));
  for (const ident::AmplitudeResponse& response : sheet.responses) text += response_lines(response);
  const std::string unseen = fmt::format("not observed up to {:.2f} Hz", sheet.highest_Hz);
  text += line("natural frequency",
               sheet.natural_frequency_Hz ? with_interval(*sheet.natural_frequency_Hz, 1.0, 2, "Hz") : unseen);
  text += line("damping ratio", sheet.damping_ratio ? with_interval(*sheet.damping_ratio, 1.0, 2, "") : unseen);
  text += line("delay of the velocity", fmt::format("{:.1f} ms", 1e3 * sheet.lag_s));
  return text;
}

std::string warning_of(const RunSheet& run) {
  constexpr double kWantedNull_V = 0.03;  // of the following check, see FOLLOWING in eha-rig(5)
  if (!(run.sheet.null_V.half_width > kWantedNull_V)) return {};
  return fmt::format(
      "the null is known to +-{:.3f} V only, the following check needs {:g} V: with so much leakage or noise the "
      "check may stop a sound rig; repair the seal or the sensor, or widen dead_band_V by as much",
      run.sheet.null_V.half_width, kWantedNull_V);
}

}  // namespace eha::sheet
