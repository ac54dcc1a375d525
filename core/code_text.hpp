// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace eha {

// Text from files in generated code. Names, units and reasons of a model file are untrusted: every generator passes
// them through the functions below, and no other text of a file enters code.

namespace code {

[[nodiscard]] constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
[[nodiscard]] constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Words that C, Python, Octave or structured text reserve, and names that the generated modules use themselves.
constexpr auto kReserved = std::to_array<std::string_view>({"and",        "as",
                                                            "assert",     "async",
                                                            "auto",       "await",
                                                            "bool",       "break",
                                                            "by",         "case",
                                                            "catch",      "char",
                                                            "class",      "classdef",
                                                            "const",      "continue",
                                                            "def",        "default",
                                                            "del",        "do",
                                                            "double",     "elif",
                                                            "else",       "elseif",
                                                            "elsif",      "end",
                                                            "enum",       "except",
                                                            "extern",     "finally",
                                                            "float",      "for",
                                                            "from",       "function",
                                                            "global",     "goto",
                                                            "if",         "import",
                                                            "in",         "inline",
                                                            "int",        "is",
                                                            "lambda",     "long",
                                                            "mod",        "nonlocal",
                                                            "not",        "of",
                                                            "or",         "parfor",
                                                            "pass",       "persistent",
                                                            "program",    "raise",
                                                            "real",       "register",
                                                            "repeat",     "restrict",
                                                            "return",     "short",
                                                            "signed",     "sizeof",
                                                            "spmd",       "static",
                                                            "struct",     "switch",
                                                            "then",       "to",
                                                            "true",       "false",
                                                            "none",       "try",
                                                            "type",       "typedef",
                                                            "union",      "unsigned",
                                                            "until",      "unwind_protect",
                                                            "var",        "void",
                                                            "volatile",   "while",
                                                            "with",       "xor",
                                                            "yield",      "np",
                                                            "sections",   "direct",
                                                            "delay_s",    "initial_output",
                                                            "input_bias", "null",
                                                            "dead_band",  "negative_gain_ratio"});

}  // namespace code

/// Converts a name to one that C, Python, Octave, MATLAB and structured text accept for a function or a variable:
/// letters, digits and '_', a letter first, at most 63 characters (MATLAB's limit), no reserved word in any case. Other
/// characters become '_'.
[[nodiscard]] inline std::string identifier(std::string_view name) {
  constexpr std::size_t kLongest = 63;
  std::string result;
  for (const char c : name.substr(0, kLongest)) result += code::is_letter(c) || code::is_digit(c) ? c : '_';
  if (result.empty() || !code::is_letter(result.front())) result.insert(0, "model_");
  result.resize(std::min(result.size(), kLongest));
  std::string lower = result;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (std::find(code::kReserved.begin(), code::kReserved.end(), lower) != code::kReserved.end()) result += "_model";
  return result;
}

/// Returns a quantity's name with its unit, for a variable: ("y", "mm") is y_mm. Only the listed units become code;
/// with another one, or none, returns the name alone.
[[nodiscard]] inline std::string with_unit(std::string_view name, std::string_view unit) {
  constexpr auto kUnits = std::to_array<std::string_view>({"V", "mV", "A", "mA", "in", "mm", "cm", "m", "um", "ft",
                                                           "deg", "rad", "bar", "psi", "Pa", "kPa", "MPa", "N", "kN"});
  const bool is_known = std::find(kUnits.begin(), kUnits.end(), unit) != kUnits.end();
  return is_known ? std::string(name) + "_" + std::string(unit) : std::string(name);
}

/// Converts text to one that is safe in a comment of any of these languages, or in a string between double quotes.
/// Keeps letters, digits, blanks and the characters of kPunctuation; other characters become '_', and text beyond
/// `length` becomes "...". No sequence of the kept characters ends a comment or a string, begins an escape or a
/// trigraph, or is a directive. The result is not a printf format.
[[nodiscard]] inline std::string code_text(std::string_view text, std::size_t length) {
  constexpr std::string_view kPunctuation = " .,:;()[]+-=|^%~_/'";
  std::string result(text.substr(0, length));
  for (char& c : result) {
    if (!code::is_letter(c) && !code::is_digit(c) && kPunctuation.find(c) == std::string_view::npos) c = '_';
  }
  if (text.size() > length) result += "...";
  return result;
}

}  // namespace eha
