// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <mutex>
#include <optional>

#include "ident/record.hpp"

namespace eha::ident {

/// What the signals of a record show by themselves, whatever the model: each computed at its first use, at the cost of
/// the function it names, at most O(N log N). The record must outlive it. Thread-safe.
class SignalFacts {
 public:
  explicit SignalFacts(const Record& record) : record_(record) {}
  explicit SignalFacts(const Record&&) = delete;

  [[nodiscard]] const Record& record() const noexcept { return record_; }

  /// Of the input, as the functions of these names [input unit]; the first two of the recorded rows, the first as white
  /// in the record's own.
  [[nodiscard]] double input_error_std() const;
  [[nodiscard]] double apparent_input_noise() const;
  [[nodiscard]] const std::optional<Eigen::VectorXd>& held_levels() const;

  /// value_step() of the output [output unit].
  [[nodiscard]] double output_step() const;

 private:
  const Record& record_;
  mutable std::mutex computing_;
  mutable std::optional<double> input_error_std_;
  mutable std::optional<double> apparent_input_noise_;
  mutable std::optional<std::optional<Eigen::VectorXd>> held_levels_;
  mutable std::optional<double> output_step_;
};

}  // namespace eha::ident
