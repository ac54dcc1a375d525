// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/rig_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "config/file_kind.hpp"
#include "config/toml_section.hpp"
#include "core/millimetre_key.hpp"
#include "hal/backends/backend.hpp"

namespace eha::config {
namespace {

/// Checks limits against each other and against the converters. Skips keys that already have an issue.
class LimitChecks {
 public:
  LimitChecks(const RigConfig& rig, Document& document) : rig_(rig), document_(document) {}

  void run() {
    const RigLimits& limits = rig_.limits;
    const bool command_is_read = read("command_min_V") && read("command_max_V");
    const bool travel_is_read = read("travel_min_in") && read("travel_max_in");
    if (command_is_read && !(limits.command_min_V < limits.command_max_V)) {
      add_issue("command_max_V", fmt::format("more than command_min_V = {}", limits.command_min_V),
                limits.command_max_V);
    } else if (command_is_read && read("safe_V") &&
               !Range::between(limits.command_min_V, limits.command_max_V).contains(limits.safe_V)) {
      add_issue("safe_V",
                fmt::format("a voltage within command_min_V..command_max_V, {}..{}", limits.command_min_V,
                            limits.command_max_V),
                limits.safe_V);
    }
    if (travel_is_read && !(limits.travel_min_in < limits.travel_max_in)) {
      add_issue("travel_max_in", fmt::format("more than travel_min_in = {}", limits.travel_min_in),
                limits.travel_max_in);
    }
    if (!document_.issues.clean(hal::name_of(rig_.backend))) return;
    if (command_is_read) check_command_range();
    if (travel_is_read) check_travel_range();
    if (travel_is_read && limits.sensor && document_.issues.clean("sensor")) check_sensor(*limits.sensor);
  }

 private:
  [[nodiscard]] bool read(std::string_view key) const {
    const std::string path = fmt::format("limits.{}", key);
    return document_.positions.contains(path) && document_.issues.clean(path);
  }
  void add_issue(std::string_view key, const std::string& expected, double got) {
    const std::string path = fmt::format("limits.{}", key);
    document_.issues.add(position_of(document_.positions, path), path, expected, fmt::format("{}", got));
  }

  void check_command_range() {
    const hal::Conversion ranges = hal::conversion_of(rig_.backend);
    const Range range = Range::between(ranges.command_min_V, ranges.command_max_V);
    const std::string expected = fmt::format("a voltage within the output converter's {}..{}", range.low, range.high);
    if (!range.contains(rig_.limits.command_min_V)) add_issue("command_min_V", expected, rig_.limits.command_min_V);
    if (!range.contains(rig_.limits.command_max_V)) add_issue("command_max_V", expected, rig_.limits.command_max_V);
  }

  /// Whether the sensor holds the travel with a scale that is in inches, and so perhaps the offset.
  [[nodiscard]] bool would_hold_travel(const hal::Conversion& ranges) const {
    const double half_in =
        0.5 * kMillimetresPerInch * std::abs(ranges.scale_in_per_V * (ranges.feedback_max_V - ranges.feedback_min_V));
    const double middle_V = 0.5 * (ranges.feedback_min_V + ranges.feedback_max_V);
    const auto holds = [&](double offset_in) {
      const double middle_in = offset_in + kMillimetresPerInch * ranges.scale_in_per_V * middle_V;
      return rig_.limits.travel_min_in >= middle_in - half_in && rig_.limits.travel_max_in <= middle_in + half_in;
    };
    return holds(ranges.offset_in) || holds(kMillimetresPerInch * ranges.offset_in);
  }

  void check_travel_range() {
    const hal::Conversion ranges = hal::conversion_of(rig_.backend);
    const double at_min = ranges.offset_in + ranges.scale_in_per_V * ranges.feedback_min_V;
    const double at_max = ranges.offset_in + ranges.scale_in_per_V * ranges.feedback_max_V;
    const Range range = Range::between(std::min(at_min, at_max), std::max(at_min, at_max));
    const std::string expected =
        fmt::format("a displacement that the sensor can show, {:.6g}..{:.6g} in", range.low, range.high);
    const bool holds_travel = range.contains(rig_.limits.travel_min_in) && range.contains(rig_.limits.travel_max_in);
    const std::string scale = std::string(hal::name_of(rig_.backend)) + ".scale_mm_per_V";
    if (!holds_travel && document_.positions.contains(scale) && would_hold_travel(ranges)) {
      document_.issues.add_text(
          position_of(document_.positions, scale), scale,
          fmt::format("the sensor would show {:.6g}..{:.6g} in, which does not hold the travel "
                      "{:g}..{:g} in, and with 25.4 times this scale it does: is the number in "
                      "inches (scale_in_per_V)?",
                      range.low, range.high, rig_.limits.travel_min_in, rig_.limits.travel_max_in));
      return;
    }
    for (const auto& [end, limit_in] :
         {std::pair("min", rig_.limits.travel_min_in), std::pair("max", rig_.limits.travel_max_in)}) {
      if (range.contains(limit_in)) continue;
      const bool is_far = std::abs(limit_in) > 2.0 * std::max(std::abs(range.low), std::abs(range.high));
      const bool is_in_mm = is_far && range.contains(limit_in / kMillimetresPerInch);
      add_issue(fmt::format("travel_{}_in", end),
                expected + (is_in_mm ? fmt::format(" (millimetres? write travel_{}_mm)", end) : ""), limit_in);
    }
  }

  void check_sensor(const SensorBand& sensor) {
    const hal::Conversion ranges = hal::conversion_of(rig_.backend);
    const auto add = [&](std::string_view key, const std::string& expected, double got) {
      const std::string path = fmt::format("sensor.{}", key);
      document_.issues.add(position_of(document_.positions, path), path, expected, fmt::format("{}", got));
    };
    const auto volts_at = [&](double displacement_in) {
      return (displacement_in - ranges.offset_in) / ranges.scale_in_per_V;
    };
    const double one_V = volts_at(rig_.limits.travel_min_in);
    const double other_V = volts_at(rig_.limits.travel_max_in);
    const Range lower{.low = ranges.feedback_min_V, .high = std::min(one_V, other_V)};
    const Range upper{.low = std::max(one_V, other_V), .high = ranges.feedback_max_V};
    constexpr const char* kExpected =
        "a voltage between the {} of the converter and that of the travel, {:.6g}..{:.6g}";
    if (!lower.contains(sensor.valid_min_V)) {
      add("valid_min_V", fmt::format(kExpected, "lowest", lower.low, lower.high), sensor.valid_min_V);
    }
    if (!upper.contains(sensor.valid_max_V)) {
      add("valid_max_V", fmt::format(kExpected, "highest", upper.low, upper.high), sensor.valid_max_V);
    }
  }

  const RigConfig& rig_;
  Document& document_;
};

/// Reads `backend` and its table, and refuses the tables of the other backends. @returns whether the backend is known
bool read_backend(Section& root, RigConfig& rig, Document& document) {
  std::vector<std::pair<std::string_view, hal::Backend>> choices;
  for (const hal::Backend& backend : hal::all_backends()) choices.emplace_back(hal::name_of(backend), backend);
  root.choice("backend", rig.backend, choices);
  const bool is_known = root.has("backend") && document.issues.clean("backend");
  const std::string_view name = hal::name_of(rig.backend);
  for (const auto& [other, backend] : choices) {
    if (!is_known) {
      root.ignore(other);
    } else if (other != name) {
      root.forbid(other, fmt::format("backend = \"{}\"", name));
    }
  }
  if (!is_known) return false;
  std::visit([&](auto& options) { root.table(name, options); }, rig.backend);
  if (!root.has(name)) return true;
  std::vector<OptionIssue> issues = hal::issues_of(rig.backend);
  for (OptionIssue& issue : issues) issue.key = fmt::format("{}.{}", name, issue.key);
  root.add_issues(issues);
  return true;
}

}  // namespace

RigConfig parse_rig(std::string_view text, const std::string& file_name) {
  Document document = parse_document(text, file_name);
  RigConfig rig;
  rig.file_name = file_name;
  rig.text = std::string(text);
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.boolean("sample", rig.is_sample, Need::optional);
  RigConfig::visit_keys(rig, root);
  const bool backend_is_known = read_backend(root, rig, document);
  root.finish();
  if (backend_is_known) LimitChecks(rig, document).run();
  document.issues.throw_if_any();
  rig.positions = std::move(document.positions);
  return rig;
}

RigConfig load_rig(const std::string& path) { return parse_rig(read_config_file(path), path); }

}  // namespace eha::config
