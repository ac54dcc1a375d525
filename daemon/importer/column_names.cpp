// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/column_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string>
#include <vector>

#include "core/terminal_text.hpp"
#include "core/text.hpp"
#include "core/unit_names.hpp"
#include "daemon/importer/text_lines.hpp"

namespace eha::importer {
namespace {

constexpr std::array kTimeNames = std::to_array<std::string_view>(
    {"t", "time", "zeit", "temps", "tiempo", "timestamp", "elapsed", "seconds", "sec", "sekunden", "tout"});
constexpr std::array kInputNames = std::to_array<std::string_view>(
    {"u",        "uin",     "vin",          "input",      "voltage",  "volt",  "volts",
     "spannung", "tension", "command",      "commande",   "cmd",      "valve", "ventil",
     "stell",    "eingang", "entr",         "excitation", "anregung", "drive", "servo",
     "heater",   "heizung", "heizleistung", "pump",       "pumpe",    "pwm",   "ansteuerung"});
constexpr std::array kOutputNames = std::to_array<std::string_view>(
    {"y",       "output", "displacement", "placement", "position", "pos",     "weg",      "hub",    "stroke",
     "ausgang", "sortie", "lvdt",         "rod",       "kolben",   "travel",  "response", "yout",   "lage",
     "ist",     "actual", "feedback",     "fbk",       "measured", "istwert", "regelgr",  "mesure", "encoder"});
/// The same, as whole words alone: "contact" is no output.
constexpr std::array kWholeOutputNames = std::to_array<std::string_view>({"act", "fb", "pv"});
/// Ports of a card, with or without their number: a card's output is what it drives, the plant's input.
constexpr std::array kCardOutputs = std::to_array<std::string_view>({"ao", "aout", "dac", "analogout", "analogoutput"});
constexpr std::array kCardInputs = std::to_array<std::string_view>({"ai", "ain", "adc", "analogin", "analoginput"});
/// Of a set point whatever its unit but that of a valve, and of one where unit or another word is of the rod's place.
constexpr std::array kSetPointNames =
    std::to_array<std::string_view>({"soll", "setpoint", "consigne", "führung", "fuehrung"});
constexpr std::array kPlaceDemandNames = std::to_array<std::string_view>(
    {"command", "commande", "cmd", "demand", "reference", "ref", "target", "stell", "w", "sp"});
constexpr std::array kPlaceNames = std::to_array<std::string_view>(
    {"displacement", "position", "pos", "weg", "hub", "stroke", "kolben", "rod", "travel", "lage"});
constexpr std::array kValveNames = std::to_array<std::string_view>(
    {"valve", "ventil", "stell", "spannung", "voltage", "strom", "servo", "spool", "u"});
/// Of a valve whatever the unit: its spool may be measured in millimetres.
constexpr std::array kSpoolNames = std::to_array<std::string_view>({"valve", "ventil", "spool", "schieber"});
/// Of what was measured.
constexpr std::array kMeasuredNames =
    std::to_array<std::string_view>({"ist", "actual", "feedback", "fbk", "fb", "measured", "monitor", "istwert"});
constexpr std::array kPressureNames =
    std::to_array<std::string_view>({"pressure", "druck", "pression", "force", "kraft", "load"});
/// Of a temperature; those of oil are, beside a T.
constexpr std::array kTemperatureNames = std::to_array<std::string_view>({"temperatur", "oiltemp", "öltemp"});
constexpr std::array kOilNames = std::to_array<std::string_view>({"oil", "oel", "öl", "Öl", "huile", "tank"});
/// Of what surrounds the plant.
constexpr std::array kAmbientNames =
    std::to_array<std::string_view>({"ambient", "raumtemperatur", "umgebung", "room", "raum"});
constexpr std::array kTemperatureUnits = std::to_array<std::string_view>({"degC", "°C", "C", "degF", "°F", "F", "K"});
constexpr std::array kIndexNames = std::to_array<std::string_view>(
    {"", "index", "idx", "unnamed: 0", "#", "n", "no", "nr", "row", "sample", "samples", "zeile", "i", "k"});
constexpr std::array kTimeUnits = std::to_array<std::pair<std::string_view, double>>(
    {{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}, {"min", 60.0}, {"h", 3600.0}});
constexpr std::array kInputUnits = std::to_array<std::string_view>({"V", "mV", "kV", "A", "mA", "%", "W", "kW"});
constexpr std::array kOutputUnits =
    std::to_array<std::string_view>({"in", "mm", "cm", "dm", "m", "um", "ft", "deg", "rad"});
constexpr std::array kForceUnits =
    std::to_array<std::string_view>({"N", "kN", "daN", "lbf", "kgf", "bar", "mbar", "psi", "Pa", "hPa", "kPa", "MPa"});

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

/// The letters and digits of a name in words: "ValveCmd_1" is "valve", "cmd", "1". Other scripts are letters.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  bool in_word = false;
  bool was_lower = false;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_letter = std::isalnum(byte) != 0 || byte >= 0x80;
    const bool is_upper = std::isupper(byte) != 0;
    if (is_letter && (!in_word || (is_upper && was_lower))) words.emplace_back();
    if (is_letter) words.back() += c;
    in_word = is_letter;
    was_lower = std::islower(byte) != 0;
  }
  for (std::string& word : words) word = lower(word);
  return words;
}

/// Compounds count: "Ventilspannung", "Kolbenweg". Shorter words must match whole.
bool has_word(const std::vector<std::string>& words, std::span<const std::string_view> names) {
  constexpr std::size_t kShortestPart = 3;
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::any_of(names.begin(), names.end(), [&](std::string_view name) {
      return word == name || (name.size() > kShortestPart && word.starts_with(name)) ||
             (name.size() >= kShortestPart && word.size() > name.size() + 2 && word.ends_with(name));
    });
  });
}

template <typename List>
bool holds(const List& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

/// The unit of a label that is one of time itself, "millis", or ends in one behind words for a time, "Run Time ms". A
/// single letter is no unit then: s is a path, h a height.
std::optional<std::string> unit_word_of_time(std::string_view label) {
  const std::size_t blank = label.rfind(' ');
  const std::string_view word = label.substr(blank == std::string_view::npos ? 0 : blank + 1);
  const auto unit = known_unit(word);
  if (!unit || !seconds_in(*unit)) return std::nullopt;
  if (blank == std::string_view::npos) return word.size() > 1 ? unit : std::nullopt;
  return has_word(words_of(label.substr(0, blank)), kTimeNames) ? unit : std::nullopt;
}

/// "Soll", "Set point", but not "Ventil Soll".
bool names_set_point(const std::vector<std::string>& words) {
  const bool has_set_point = std::adjacent_find(words.begin(), words.end(), [](const auto& a, const auto& b) {
                               return a == "set" && b == "point";
                             }) != words.end();
  return (has_set_point || has_word(words, kSetPointNames)) && !has_word(words, kValveNames);
}

/// A set point in volts: a demand of a place, but no command, which may be the valve's.
bool is_demand_as_input(const std::vector<std::string>& words, std::string_view unit) {
  constexpr std::array kDemands =
      std::to_array<std::string_view>({"demand", "reference", "ref", "target", "w", "sp", "sollwert"});
  if (!holds(kInputUnits, unit) || has_word(words, kValveNames)) return false;
  return names_set_point(words) || has_word(words, kDemands) ||
         (has_word(words, kPlaceDemandNames) && has_word(words, kPlaceNames));
}

/// "Ventil Ist [V]", "spool actual [mm]", but not "servo position feedback".
bool is_valve_feedback(const std::vector<std::string>& words, std::string_view unit) {
  if (!has_word(words, kMeasuredNames) || has_word(words, kPlaceNames)) return false;
  return has_word(words, kSpoolNames) || (has_word(words, kValveNames) && !holds(kOutputUnits, unit));
}

/// The place that a control loop is to reach: "Soll", "Ch 1 Command [mm]", but not "Ventil Soll [V]".
bool is_set_point(const std::vector<std::string>& words, std::string_view unit) {
  if (holds(kInputUnits, unit)) return false;
  if (has_word(words, kPlaceDemandNames) && (holds(kOutputUnits, unit) || has_word(words, kPlaceNames))) return true;
  return names_set_point(words);
}

/// "AO0", "ao 0", "Analog Output 0": the words of a name without those of a card's port, and which port it is.
enum class CardPort { none, output, input };
CardPort take_card_port(std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string port = words[i].substr(0, words[i].find_last_not_of("0123456789") + 1);
    const bool is_two_words = port == "analog" && i + 1 < words.size();
    if (is_two_words) port += words[i + 1].substr(0, words[i + 1].find_last_not_of("0123456789") + 1);
    const bool is_output = holds(kCardOutputs, port);
    if (!is_output && !holds(kCardInputs, port)) continue;
    const auto first = words.begin() + static_cast<std::ptrdiff_t>(i);
    words.erase(first, first + (is_two_words ? 2 : 1));
    return is_output ? CardPort::output : CardPort::input;
  }
  return CardPort::none;
}

bool is_bracketed(std::string_view text) {
  return text.size() >= 2 &&
         ((text.front() == '[' && text.back() == ']') || (text.front() == '(' && text.back() == ')'));
}

/// Of rec.data.u only the field says what it is, of Controller/Setpoint/Out1 the block before its port.
std::string_view telling_field(std::string_view name) {
  constexpr std::array kPorts = std::to_array<std::string_view>({"out", "outport", "in", "inport", "value"});
  for (std::size_t at = name.find_last_of("./"); at != std::string_view::npos; at = name.find_last_of("./")) {
    const std::string field = lower(name.substr(at + 1));
    if (!holds(kPorts, field.substr(0, field.find_last_not_of("0123456789") + 1))) return name.substr(at + 1);
    name = name.substr(0, at);
  }
  return name;
}

}  // namespace

std::string unit_meant(std::string_view text) {
  if (known_unit(text)) return {};
  const std::string small = lower(text);
  for (const units::Spelling& spelling : units::kSpellings) {
    if (small == lower(spelling.unit)) return std::string(spelling.unit);
  }
  // Of the keys beside m; nm, km and others are lengths of their own.
  const bool is_beside_m = small.size() == 2 && (small == "mn" || small == "mk" || small == "mj");
  return is_beside_m ? "mm" : std::string();
}

bool may_be_unit(std::string_view field) {
  field = trimmed(field);
  return field.empty() || field == "-" || field == "1" || is_bracketed(field) || known_unit(field);
}

std::string unit_of(std::string_view field) {
  field = trimmed(field);
  if (is_bracketed(field)) field = trimmed(field.substr(1, field.size() - 2));
  if (field == "-") return "1";
  return known_unit(field).value_or(std::string(field));
}

namespace {

/// "Flow l/min", "Speed, 1/min": what stands before the slash is no name of a time, and a unit of its own stands there.
std::optional<std::pair<std::string, std::string>> name_and_rate(std::string_view label) {
  const std::size_t slash = label.rfind('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto unit = known_unit(label.substr(slash + 1));
  if (!unit || !seconds_in(*unit)) return std::nullopt;
  const std::size_t before = label.find_last_of(" _,;", slash);
  if (before == std::string_view::npos || before == 0 || before + 1 == slash) return std::nullopt;
  std::string_view name = trimmed(label.substr(0, before));
  if (has_word(words_of(label.substr(0, slash)), kTimeNames)) return std::nullopt;
  if (name.ends_with(" in")) name = trimmed(name.substr(0, name.size() - 3));
  while (!name.empty() && (name.back() == ',' || name.back() == ';')) name.remove_suffix(1);
  if (name.empty()) return std::nullopt;
  return std::pair(std::string(name), std::string(trimmed(label.substr(before + 1))));
}

/// Behind a name that is of no input, "piston_v" is a velocity.
bool is_velocity(std::string_view name, std::string_view unit) {
  return trimmed(unit) == "v" && !has_word(words_of(name), kInputNames);
}

}  // namespace

std::pair<std::string, std::string> name_and_unit(std::string_view label) {
  label = trimmed(label);
  if (!label.empty() && (label.back() == ']' || label.back() == ')')) {
    const std::size_t open = label.rfind(label.back() == ']' ? '[' : '(');
    if (open != std::string_view::npos && open > 0) {
      return {std::string(trimmed(label.substr(0, open))), unit_of(label.substr(open))};
    }
  }
  if (auto rate = name_and_rate(label)) return *rate;
  for (const std::string_view separator : {"/", " in ", "_", ",", ";"}) {
    const std::size_t at = label.rfind(separator);
    if (at == std::string_view::npos || at == 0) continue;
    const std::string_view written = label.substr(at + separator.size());
    if (const auto unit = known_unit(written); unit && !is_velocity(label.substr(0, at), written)) {
      return {std::string(trimmed(label.substr(0, at))), *unit};
    }
  }
  if (auto unit = unit_word_of_time(label)) return {std::string(label), *unit};
  return {std::string(label), ""};
}

std::vector<std::pair<std::string, std::string>> names_and_last_units(const std::vector<std::string>& labels) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const std::string& label : labels) {
    const std::size_t blank = label.rfind(' ');
    const auto unit = blank == std::string::npos ? std::nullopt : known_unit(label.substr(blank));
    if (!unit || trimmed(label.substr(0, blank)).empty()) return {};
    all.emplace_back(trimmed(std::string_view(label).substr(0, blank)), *unit);
  }
  return all;
}

std::optional<double> seconds_in(std::string_view unit) {
  for (const auto& [name, seconds] : kTimeUnits) {
    if (unit == name) return seconds;
  }
  return std::nullopt;
}

std::string readable(std::string_view name, std::size_t length) {
  if (!to_utf8(name, "UTF-8")) return shortened(name, length);
  std::size_t end = std::min(name.size(), length);
  // Not within a character.
  while (end < name.size() && end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) --end;
  const std::string text = one_line(name.substr(0, end));
  return end < name.size() ? text + "..." : text;
}

Hints hints_of(std::string_view name, std::string_view unit) {
  std::vector<std::string> words = words_of(telling_field(name));
  const CardPort port = take_card_port(words);
  Hints hints;
  // "t" is a time, "T_block" a temperature.
  const bool is_of_place =
      words.size() > 1 && words.front() == "t" && telling_field(name).starts_with('T') && !seconds_in(unit);
  // X_Value is LabVIEW's column of times.
  const bool is_time = (has_word(words, kTimeNames) && !is_of_place) || name == "X_Value";
  hints.time = (is_time ? 2 : 0) + (seconds_in(unit) ? 1 : 0);
  hints.input = (has_word(words, kInputNames) ? 2 : 0) + (holds(kInputUnits, unit) ? 1 : 0);
  const bool is_output = has_word(words, kOutputNames) || std::any_of(words.begin(), words.end(), [](const auto& w) {
                           return holds(kWholeOutputNames, w);
                         });
  hints.output = (is_output ? 2 : 0) + (holds(kOutputUnits, unit) ? 1 : 0);
  // What else the name says of the signal comes before the port: "AI0 Valve Command".
  const bool says_more = hints.input > 1 || hints.output > 0;
  if (port == CardPort::output && !says_more) hints.input += 2;
  // No more than volts weigh: of two inputs of a card, in V and mm, that in volts is the plant's input.
  if (port == CardPort::input && !says_more) hints.output += 1;
  if (is_set_point(words, unit)) {
    hints.input = 0;
    hints.output = 0;
    hints.is_beside = true;
    hints.is_set_point = true;
  }
  hints.is_demand_as_input = is_demand_as_input(words, unit);
  hints.is_valve_feedback = is_valve_feedback(words, unit);
  hints.is_pressure = holds(kForceUnits, unit) || has_word(words, kPressureNames);
  // "Weg Soll [V]" is what a loop is to reach.
  hints.is_beside =
      hints.is_beside || holds(kForceUnits, unit) || (hints.is_demand_as_input && has_word(words, kPlaceNames));
  const bool is_named = has_word(words, kTemperatureNames) || holds(words, "temp") ||
                        (holds(words, "t") && has_word(words, kOilNames)) || is_of_place;
  hints.names_temperature = is_named || holds(kTemperatureUnits, unit);
  if (holds(kTemperatureUnits, unit) || (is_named && unit.empty())) {
    hints.time = 0;
    hints.is_temperature = true;
    hints.is_beside = true;
  }
  hints.is_ambient = has_word(words, kAmbientNames);
  hints.is_beside = hints.is_beside || hints.is_ambient;
  hints.is_letter_t = unit.empty() && trimmed(name) == "T";
  hints.index = holds(kIndexNames, lower(trimmed(name))) ? 2 : 0;
  return hints;
}

}  // namespace eha::importer
