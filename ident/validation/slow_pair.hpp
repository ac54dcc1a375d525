// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// The time constant [records' lengths] that the slowest zero and the slowest pole of a model of integer order both
/// reach, of complex ones the inverse of their size; a pole at 0 is endlessly slow. Above 1 the two nearly cancel at
/// each frequency that the record shows, and what they describe is a drift of the output. None without such a zero or
/// pole, or where the length of the estimating part is not known. Cost: the roots of two polynomials.
[[nodiscard]] std::optional<double> slow_pair_over_record(const Model& model);

/// A model without its slowest zero and pole, which are real, its gain beyond them kept: the plant beside the drift
/// that they describe. None without such a zero and pole in the left half plane or at 0, or where nothing would be
/// left.
[[nodiscard]] std::optional<Model> without_slow_pair(const Model& model);

/// That plant in engineering_form(), "K = 1.79 V/V; T = 0.492 s"; empty without one.
[[nodiscard]] std::string form_without_slow_pair(const Model& model);

/// Time constants of a real pole and a real zero of the left half plane.
struct PoleAndZero {
  double pole_s = 0.0;
  double zero_s = 0.0;
};

/// The pole and zero of a model of integer order that come nearest to cancelling; none where no two time constants
/// differ by at most a quarter. Cost: the roots of two polynomials.
[[nodiscard]] std::optional<PoleAndZero> cancelling_pair(const Model& model);

/// What a pole and a zero that nearly cancel say of the figures of a model, a sentence; empty without such, and of a
/// model that takes_in_a_drift(), whose pair is that drift.
[[nodiscard]] std::string cancelling_sentence(const Model& model);

/// Whether the verdict of a model says so: it is recommended, and simulated with, only where no other one is accepted.
[[nodiscard]] bool takes_in_a_drift(const Verdict& verdict);
/// False without a verdict.
[[nodiscard]] bool takes_in_a_drift(const Model& model);

}  // namespace eha::ident
