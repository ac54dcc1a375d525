// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/signal_facts.hpp"

#include <cmath>
#include <cstddef>

#include "ident/signal/held_levels.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/signal/value_step.hpp"
#include "ident/validation/input_error.hpp"

namespace eha::ident {
namespace {

template <typename Value, typename Compute>
const Value& computed_once(std::mutex& computing, std::optional<Value>& value, const Compute& compute) {
  const std::scoped_lock lock(computing);
  if (!value) value = compute();
  return *value;
}

}  // namespace

double SignalFacts::input_error_std() const {
  return computed_once(computing_, input_error_std_, [&] {
    // The error of a recorded row is that of all its parts.
    return ident::input_error_std(recorded_input(record_)) * std::sqrt(static_cast<double>(record_.parts));
  });
}

double SignalFacts::apparent_input_noise() const {
  return computed_once(computing_, apparent_input_noise_,
                       [&] { return ident::apparent_input_noise(recorded_input(record_)); });
}

const std::optional<Eigen::VectorXd>& SignalFacts::held_levels() const {
  return computed_once(computing_, held_levels_, [&] { return ident::held_levels(record_.input); });
}

double SignalFacts::output_step() const {
  return computed_once(computing_, output_step_, [&] {
    // A converter of 12 bits in half of its range; what a step does beside the noise is asked where it is used.
    constexpr std::size_t kMostCodes = 2048;
    return value_step({record_.output.data(), static_cast<std::size_t>(record_.output.size())}, kMostCodes);
  });
}

}  // namespace eha::ident
