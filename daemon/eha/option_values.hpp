// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace eha::ident {
struct FrequencyInterval;
}

namespace eha::cli {

/// A name that an option accepts, and its value.
template <typename Value>
struct Choice {
  const char* name;
  Value value;
};

/// Adds an option that takes one of these names. (CLI::CheckedTransformer would also take the numbers behind an enum.)
/// @param target  assigned the chosen value; must outlive the parsing
template <typename Target, typename Value, std::size_t N>
CLI::Option* add_choice(CLI::App& app, const std::string& option, Target& target,
                        const std::array<Choice<Value>, N>& choices, const std::string& help) {
  std::vector<std::string> names;
  std::string type;
  for (const Choice<Value>& choice : choices) {
    names.emplace_back(choice.name);
    type += (type.empty() ? "" : "|") + names.back();
  }
  const auto assign = [&target, choices](const std::string& name) {
    for (const Choice<Value>& choice : choices) {
      if (name == choice.name) target = choice.value;
    }
  };
  return app.add_option_function<std::string>(option, assign, help)
      ->type_name(type)
      ->check(CLI::IsMember(names).description(""));
}

/// Checks that a value is a finite number that `accept` accepts. @param range  of such numbers, for the message
[[nodiscard]] CLI::Validator finite_number(const std::string& range, bool (*accept)(double));

/// Checks that a file's name ends in one of these.
[[nodiscard]] CLI::Validator ends_in(std::vector<std::string> endings);

/// The value of an option --band, "0.02:5" in Hz. @throws CLI::ValidationError  not LOW:HIGH with 0 < LOW < HIGH
[[nodiscard]] ident::FrequencyInterval band_of(const std::string& text);

}  // namespace eha::cli
