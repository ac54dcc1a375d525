// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace eha {
namespace units {

/// A spelling of a unit, and the one of the project.
struct Spelling {
  std::string_view written;
  std::string_view unit;
};

/// Units of voltage, current, length, angle, pressure, force, time and ratio, and other spellings of them.
inline constexpr std::array kSpellings = std::to_array<Spelling>({
    {"V", "V"},
    {"mV", "mV"},
    {"kV", "kV"},
    {"A", "A"},
    {"mA", "mA"},
    {"%", "%"},
    {"in", "in"},
    {"mm", "mm"},
    {"cm", "cm"},
    {"dm", "dm"},
    {"m", "m"},
    {"um", "um"},
    {"\xC2\xB5m", "um"},
    {"\xCE\xBCm", "um"},
    {"micron", "um"},
    {"microns", "um"},
    {"micrometer", "um"},
    {"micrometre", "um"},
    {"ft", "ft"},
    {"deg", "deg"},
    {"rad", "rad"},
    {"bar", "bar"},
    {"psi", "psi"},
    {"mbar", "mbar"},
    {"Pa", "Pa"},
    {"hPa", "hPa"},
    {"kPa", "kPa"},
    {"MPa", "MPa"},
    {"N", "N"},
    {"kN", "kN"},
    {"daN", "daN"},
    {"lbf", "lbf"},
    {"kgf", "kgf"},
    {"s", "s"},
    {"ms", "ms"},
    {"us", "us"},
    {"ns", "ns"},
    {"min", "min"},
    {"h", "h"},
    {"Hz", "Hz"},
    {"volt", "V"},
    {"v", "V"},
    {"VDC", "V"},
    {"mv", "mV"},
    {"millivolt", "mV"},
    {"millivolts", "mV"},
    {"MM", "mm"},
    {"volts", "V"},
    {"ampere", "A"},
    {"amps", "A"},
    {"inch", "in"},
    {"inches", "in"},
    {"\"", "in"},
    {"''", "in"},
    {"IN", "in"},
    {"\xE2\x80\xB3", "in"},
    {"\xE2\x80\x9D", "in"},
    {"sec", "s"},
    {"secs", "s"},
    {"second", "s"},
    {"seconds", "s"},
    {"sek", "s"},
    {"sekunde", "s"},
    {"sekunden", "s"},
    {"msec", "ms"},
    {"msecs", "ms"},
    {"millis", "ms"},
    {"millisecond", "ms"},
    {"millisekunde", "ms"},
    {"millisekunden", "ms"},
    {"usec", "us"},
    {"usecs", "us"},
    {"micros", "us"},
    {"microsecond", "us"},
    {"microseconds", "us"},
    {"mikrosekunde", "us"},
    {"mikrosekunden", "us"},
    {"minute", "min"},
    {"minutes", "min"},
    {"minuten", "min"},
    {"percent", "%"},
    {"metre", "m"},
    {"meter", "m"},
    {"millimeter", "mm"},
    {"millimetre", "mm"},
    {"millimeters", "mm"},
    {"millimetres", "mm"},
    {"milliseconds", "ms"},
    {"degrees", "deg"},
    {"\xC2\xB0", "deg"},
    {"\xC2\xB5s", "us"},
    {"\xCE\xBCs", "us"},
    {"\xC2\xB0"
     "C",
     "\xC2\xB0"
     "C"},
    {"degC", "degC"},
    {"degF", "degF"},
    {"\xC2\xB0"
     "F",
     "\xC2\xB0"
     "F"},
    {"l/min", "l/min"},
});

}  // namespace units

/// A unit as the project writes it ("Volt" is V, "inches" is in, "sec" is s); none when the text is no unit it knows.
[[nodiscard]] inline std::optional<std::string> known_unit(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return std::nullopt;
  text = text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
  for (const units::Spelling& spelling : units::kSpellings) {
    if (text == spelling.written) return std::string(spelling.unit);
  }
  // Written out, the case does not matter: Volt, SECONDS. Of short ones it does: mm and Mm, s and S.
  constexpr std::size_t kShortestWord = 3;
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const units::Spelling& spelling : units::kSpellings) {
    if (small.size() >= kShortestWord && small == spelling.written) return std::string(spelling.unit);
  }
  return std::nullopt;
}

/// The same, and what is no unit that the project knows as it is.
[[nodiscard]] inline std::string unit_as_written_here(const std::string& text) {
  return known_unit(text).value_or(text);
}

}  // namespace eha
