// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/rod_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/display_unit.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string line_text(const Json& rod) {
  std::string text = fmt::format("inputs 0x{:08x}", rod.at("digital_inputs").get<std::uint32_t>());
  const auto add = [&](const char* key, const char* name, const char* when_true, const char* when_false) {
    const Json& value = rod.at(key);
    text += fmt::format(", {} {}", name, value.is_null() ? "none" : value.get<bool>() ? when_true : when_false);
  };
  add("emergency_stop_open", "emergency stop", "OPEN", "closed");
  add("enable_contact_closed", "enable contact", "closed", "open");
  return text;
}

Travel travel_of(const Json& rod) { return {rod.at("travel_min_in"), rod.at("travel_max_in")}; }

}  // namespace

std::string beyond_limit(double place_in, const Travel& travel, const DisplayUnit& unit) {
  if (place_in >= travel.lowest_in && place_in <= travel.highest_in) return {};
  const bool is_low = place_in < travel.lowest_in;
  const double limit_in = is_low ? travel.lowest_in : travel.highest_in;
  const double factor = unit.factor("in");
  return fmt::format("{0:.3f} {1} beyond the {2} travel limit of {3:.3f} {1}", factor * std::abs(place_in - limit_in),
                     unit.of("in"), is_low ? "lower" : "upper", factor * limit_in);
}

std::string goto_middle(const Travel& travel, const DisplayUnit& unit) {
  const double middle = 0.5 * unit.factor("in") * (travel.lowest_in + travel.highest_in);
  return fmt::format("eha goto {:.3g}{}", middle, unit.of("in"));
}

std::string way_to_middle(const Json& rod, const DisplayUnit& unit) {
  if (!rod.is_object() || rod.at("error").is_string()) return {};
  const double place_in = rod.at("displacement_in");
  const bool is_far = rod.value("near_limit", false) || !beyond_limit(place_in, travel_of(rod), unit).empty();
  return is_far ? goto_middle(travel_of(rod), unit) : std::string();
}

std::string short_bar(double displacement, double lowest, double highest, int width) {
  std::string bar(static_cast<std::size_t>(width), '-');
  for (int i = 0; i < width; ++i) {
    const double share = std::abs(2.0 * i / (width - 1) - 1.0);
    if (share > acquisition::kWarningShare) bar[static_cast<std::size_t>(i)] = '=';
  }
  if (!std::isfinite(displacement)) return "[" + bar + "]";
  const double place = std::clamp((displacement - lowest) / (highest - lowest), 0.0, 1.0);
  bar[static_cast<std::size_t>(std::lround(place * (width - 1)))] = '#';
  return "[" + bar + "]";
}

std::string travel_bar(double displacement, double lowest, double highest) {
  constexpr int kWidth = 41;
  return fmt::format("{:.3f} {} {:.3f}", lowest, short_bar(displacement, lowest, highest, kWidth), highest);
}

std::vector<NamedText> rod_lines(const Json& rod, const DisplayUnit& unit) {
  if (rod.is_null()) return {{"rod", "not read yet"}};
  if (rod.at("error").is_string()) return {{"rod", rod.at("error").get<std::string>()}};
  const double factor = unit.factor("in");
  const auto length = [&](const char* key) { return factor * rod.at(key).get<double>(); };
  std::vector<NamedText> lines;
  lines.push_back(
      {"rod", fmt::format("{:.3f} {}  {}", length("displacement_in"), unit.of("in"),
                          travel_bar(length("displacement_in"), length("travel_min_in"), length("travel_max_in")))});
  const Json& noise = rod.at("noise_in");
  lines.push_back({"sensor", fmt::format("{:+.4f} V, code {}{}{}", rod.at("feedback_V").get<double>(),
                                         rod.at("feedback_code").get<std::uint32_t>(),
                                         noise.is_null() ? ", noise not known yet (at rest only)"
                                                         : fmt::format(", noise {:.2g} {} RMS",
                                                                       factor * noise.get<double>(), unit.of("in")),
                                         rod.value("at_rail", false) ? ", AT THE END OF THE CONVERTER" : "")});
  lines.push_back({"lines", line_text(rod)});
  const std::string beyond = beyond_limit(rod.at("displacement_in"), travel_of(rod), unit);
  if (!beyond.empty()) {
    lines.push_back({"WARNING", beyond + ": look at the rod; if it does not stand there, the sensor is wrong"});
  } else if (rod.value("near_limit", false)) {
    const double middle = 0.5 * (length("travel_min_in") + length("travel_max_in"));
    lines.push_back({"WARNING", fmt::format("{:.0f} % of the way to the {} travel limit, 100 % trips",
                                            rod.at("travel_percent").get<double>(),
                                            length("displacement_in") > middle ? "upper" : "lower")});
  }
  return lines;
}

std::string aligned(const std::vector<NamedText>& lines) {
  std::string text;
  for (const NamedText& line : lines) text += fmt::format("{:<8} {}\n", line.name, line.text);
  return text;
}

}  // namespace eha::cli
