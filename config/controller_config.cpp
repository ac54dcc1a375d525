// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/controller_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "config/file_kind.hpp"
#include "config/toml_section.hpp"
#include "core/error.hpp"
#include "core/toml_text.hpp"

namespace eha::config {
namespace {

constexpr double kNoLimit = 1e9;  // stands for an infinite margin in the file
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kPurposes{
    {{"track", "track"}, {"hold", "hold"}}};

// The tables of an AxisSettings: keys of the file, members of the struct.

struct FeedbackTable {
  ident::AxisSettings* s;
  static void visit_keys(auto& self, auto& keys) {
    ident::Feedback& f = self.s->feedback;
    keys.number("kp_per_s", f.kp, Range::at_least(0.0));
    keys.number("ki_per_s2", f.ki, Range::at_least(0.0));
    keys.number("kd", f.kd, Range::at_least(0.0));
    keys.number("integral_order", f.integral_order, Range{0.0, 2.0, true, true}, Need::optional);
    keys.number("derivative_order", f.derivative_order, Range{0.0, 2.0, true, true}, Need::optional);
    keys.number("filter_s", f.filter_s, Range::at_least(0.0));
    keys.number("rest_error_in", self.s->rest_error, Range::at_least(0.0));
    keys.number("tracking_s", self.s->tracking_s, Range::at_least(0.0));
    keys.number("most_speed_in_per_s", self.s->most_speed, Range::above(0.0));
  }
};

struct InverseTable {
  ident::AxisSettings* s;
  static void visit_keys(auto& self, auto& keys) {
    ident::InverseMap& m = self.s->inverse;
    keys.number("null_V", m.null, Range::between(-10.0, 10.0));
    keys.number("dead_band_V", m.dead_band, Range::between(0.0, 10.0));
    keys.number("gain_positive_in_per_V_s", m.gain_positive, Range::above(0.0));
    keys.number("gain_negative_in_per_V_s", m.gain_negative, Range::above(0.0));
    keys.number("smoothing_in_per_s", m.smoothing, Range::above(0.0));
  }
};

struct FeedForwardTable {
  ident::AxisSettings* s;
  static void visit_keys(auto& self, auto& keys) {
    keys.number("position_rate_per_s", self.s->feed_forward.position_rate, Range::any());
    keys.number("rest_in", self.s->feed_forward.rest, Range::any());
    keys.number("velocity_share", self.s->feed_forward.velocity_share, Range::between(0.0, 2.0));
    keys.number("acceleration_s", self.s->feed_forward.acceleration_s, Range::any());
  }
};

struct ReferenceTable {
  ident::AxisSettings* s;
  static void visit_keys(auto& self, auto& keys) {
    ident::ReferenceLimits& r = self.s->reference;
    keys.number("lowest_in", r.lowest, Range::any());
    keys.number("highest_in", r.highest, Range::any());
    keys.number("velocity_in_per_s", r.velocity, Range::above(0.0));
    keys.number("acceleration_in_per_s2", r.acceleration, Range::above(0.0));
    keys.number("jerk_in_per_s3", r.jerk, Range::above(0.0));
  }
};

struct CommandTable {
  ident::AxisSettings* s;
  static void visit_keys(auto& self, auto& keys) {
    keys.number("min_V", self.s->command_min, Range::between(-10.0, 10.0));
    keys.number("max_V", self.s->command_max, Range::between(-10.0, 10.0));
    keys.number("slew_V_per_s", self.s->slew_per_s, Range::above(0.0));
  }
};

/// Writes the keys of a table as TOML.
class TomlWriter {
 public:
  explicit TomlWriter(std::string& text) : text_(text) {}

  template <typename Table>
  void table(std::string_view key, Table& target) {
    // A promised figure fits on one line.
    text_ += fmt::format("{} = {{ ", key);
    TomlWriter inner(text_);
    inner.separator_ = ", ";
    Table::visit_keys(target, inner);
    text_ += " }\n";
  }
  void number(std::string_view key, const double& value, const Range&, Need = Need::required) {
    const double written = std::isfinite(value) ? value : std::copysign(kNoLimit, value);
    std::string digits = fmt::format("{}", written);
    if (digits.find_first_of(".en") == std::string::npos) digits += ".0";
    put(key, digits);
  }
  template <typename Integer>
  void integer(std::string_view key, const Integer& value, std::int64_t, std::int64_t, Need = Need::required) {
    put(key, fmt::format("{}", value));
  }
  void text(std::string_view key, const std::string& value, Need need = Need::required) {
    if (!value.empty() || need == Need::required) put(key, toml_string(value));
  }
  void lines(std::string_view key, const std::string& value, Need need = Need::required) { text(key, value, need); }

 private:
  void put(std::string_view key, const std::string& value) {
    const bool is_inline = separator_ != "\n";
    text_ += fmt::format("{}{} = {}{}", is_inline && !is_first_ ? separator_ : "", key, value, is_inline ? "" : "\n");
    is_first_ = false;
  }

  std::string& text_;
  std::string_view separator_ = "\n";
  bool is_first_ = true;
};

template <typename Table>
void read(Section& root, std::string_view key, Table table) {
  root.table(key, table);
}

template <typename Table>
void write(std::string& text, std::string_view key, std::string_view comment, Table& table) {
  text += fmt::format("\n# {}\n[{}]\n", comment, key);
  TomlWriter keys(text);
  Table::visit_keys(table, keys);
}

constexpr std::array<std::pair<std::string_view, std::string_view>, 1> kPositionUnits{{{"in", "in"}}};
constexpr std::array<std::pair<std::string_view, std::string_view>, 1> kCommandUnits{{{"V", "V"}}};

}  // namespace

ControllerConfig parse_controller(std::string_view text, const std::string& file_name) {
  Document document = parse_document(text, file_name);
  ControllerConfig c;
  c.file_name = file_name;
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.text("name", c.name);
  std::string_view purpose = "track";
  root.choice("for", purpose, kPurposes);
  c.purpose = purpose;
  root.choice("kind", c.settings.kind, ident::kFeedbackKinds);
  root.number("tick_s", c.settings.tick_s, Range{1e-5, 1.0});
  if (auto units = root.section("units")) {
    std::string_view unit;
    units->choice("position", unit, kPositionUnits);
    units->choice("command", unit, kCommandUnits);
    units->finish();
  }
  read(root, "feedback", FeedbackTable{&c.settings});
  read(root, "inverse", InverseTable{&c.settings});
  read(root, "feed_forward", FeedForwardTable{&c.settings});
  read(root, "reference", ReferenceTable{&c.settings});
  read(root, "command", CommandTable{&c.settings});
  root.table("promise", c.promise);
  root.table("fault", c.fault);
  root.table("provenance", c.provenance);
  root.finish();
  document.issues.throw_if_any();
  try {
    static_cast<void>(ident::coefficients(c.settings));  // checks conditions between keys
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", file_name, error.what()));
  }
  return c;
}

ControllerConfig load_controller(const std::string& path) { return parse_controller(read_config_file(path), path); }

std::string controller_text(const ControllerConfig& controller) {
  ControllerConfig c = controller;  // the tables read and write through one pointer
  std::string text = fmt::format(
      "# A controller of an axis, made by eha tune; eha-controller(5). Played on the rig, tick and units below only.\n"
      "# Lengths are in inches whatever units the rig shows; eha export FILE --format csv --units mm gives them in "
      "mm.\n"
      "schema = 1\nname = {}\nfor = {}\nkind = \"{}\"\ntick_s = {}\n\n[units]\nposition = \"in\"\ncommand = \"V\"\n",
      toml_string(c.name), toml_string(c.purpose), ident::text(c.settings.kind), c.settings.tick_s);
  FeedbackTable feedback{&c.settings};
  write(text, "feedback", "From the filtered error [in] to the speed that is asked for [in/s]", feedback);
  InverseTable inverse{&c.settings};
  write(text, "inverse", "From speed to command: null, dead band bridged within the smoothing, two gains", inverse);
  FeedForwardTable feed_forward{&c.settings};
  write(text, "feed_forward",
        "Speed that the plant needs: position_rate (r - rest) + velocity_share r' + acceleration_s r''", feed_forward);
  ReferenceTable reference{&c.settings};
  write(text, "reference", "Bounds of the generated reference", reference);
  CommandTable command{&c.settings};
  write(text, "command", "Limits of the command: the rig's, and within its closed_loop_max_V of the null", command);
  write(text, "promise",
        "On the drawn rigs: the median, and their range with a quarter of it more; of margins 95 % of the draws",
        c.promise);
  write(text, "fault", "Beyond these a run of it is a fault", c.fault);
  write(text, "provenance", "What it was made from", c.provenance);
  return text;
}

}  // namespace eha::config
