// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/twin_parameter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "core/text.hpp"

namespace eha::replay {
namespace {

/// Parameters not of the plant, or always fitted (the rod's first position).
constexpr std::array<std::string_view, 9> kNotOfThePlant{
    "initial_displacement_in", "command_min_V", "command_max_V",  "feedback_min_V", "feedback_max_V",
    "scale_in_per_V",          "offset_in",     "sensor_noise_V", "sub_step_us"};

/// Calls a function with every number of the options.
template <typename Visit>
struct Numbers {
  Visit visit;
  void number(std::string_view key, auto& value, const Range&, Need) { visit(key, value); }
  void integer(std::string_view, auto&, auto, auto, Need) {}
};

template <typename Visit>
void visit_numbers(auto& options, Visit&& visit) {
  Numbers<Visit&> numbers{visit};
  hal::SimOptions::visit_keys(options, numbers);
}

double* find(hal::SimOptions& options, std::string_view key) {
  double* found = nullptr;
  visit_numbers(options, [&](std::string_view name, double& value) {
    if (name == key) found = &value;
  });
  return found;
}

[[noreturn]] void refuse(std::string_view key) {
  const std::vector<std::string> known = twin_parameters();
  const std::vector<std::string_view> names(known.begin(), known.end());
  throw UsageError(
      fmt::format("\"{}\": expected a parameter of the simulated plant{}", shortened(key, 60), suggestion(key, names)));
}

bool is_of_the_plant(std::string_view key) {
  return std::find(kNotOfThePlant.begin(), kNotOfThePlant.end(), key) == kNotOfThePlant.end();
}

}  // namespace

std::vector<std::string> twin_parameters() {
  std::vector<std::string> keys;
  hal::SimOptions options;
  visit_numbers(options, [&](std::string_view name, double&) {
    if (is_of_the_plant(name)) keys.emplace_back(name);
  });
  return keys;
}

double value_of(const hal::SimOptions& options, std::string_view key) {
  hal::SimOptions copy = options;
  const double* value = is_of_the_plant(key) ? find(copy, key) : nullptr;
  if (value == nullptr) refuse(key);
  return *value;
}

hal::SimOptions with_value(hal::SimOptions options, std::string_view key, double value) {
  double* target = is_of_the_plant(key) ? find(options, key) : nullptr;
  if (target == nullptr) refuse(key);
  *target = value;
  return options;
}

}  // namespace eha::replay
