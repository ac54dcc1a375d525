// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::ident {

/// One parameter of two models of equal structure, from records of their own.
struct ParameterChange {
  std::string name;
  ParameterRole role = ParameterRole::denominator_coefficient;
  double before = 0.0;
  double after = 0.0;
  double std = 0.0;                       ///< of after - before
  double half_width = 0.0;                ///< of its joint interval: after - before +- half_width
  double of_noise = 0.0;                  ///< the part of half_width that noise alone makes
  bool changed = false;                   ///< the joint interval excludes 0
  std::vector<std::string> follows = {};  ///< parameters of the map that changed and make the rest of half_width
};

/// The change of a plant between two models.
struct PlantChange {
  std::vector<ParameterChange> parameters;  ///< the estimated ones of both, those furthest outside 0 first
  std::vector<std::string> undetermined;    ///< estimated, but one of the records does not determine them
  bool changed = false;                     ///< at least one parameter did
};

/// Compares the parameters of the plant (not those of the record's start) that both models estimated.
/// The intervals are joint: with `level` the probability that any of them excludes 0 although nothing changed is at
/// most `level` (Bonferroni), each by Student's t with the fewer effective samples of the two; a model that was fitted
/// beside a model of its noise has as many as samples, because its whitened residual is independent. Standard errors of
/// independent records add in squares; a parameter without one counts as known.
/// A map of straight lines stands for a curved valve. Where a parameter of the map changed, the joint interval of each
/// parameter beside it also includes the shift that its estimated correlation with the changed one makes of that
/// change: a dead band that grew is not named as a change of the gain too.
/// @param level  0 < level < 1, for all parameters together
[[nodiscard]] PlantChange compare_parameters(const Model& before, const Model& after, double level);

/// What hides a change beyond noise: "a change of K below 0.23 mm/(V s) does not show here: dead_band changed, and the
/// fit lets K follow it (by noise alone 0.023 mm/(V s))". Empty where noise alone does, and for a change that shows.
[[nodiscard]] std::string hidden_sentence(const ParameterChange& change, const Model& model);

/// Unit of a changed parameter of a model, as of any of its parameters.
[[nodiscard]] std::string unit_of(const ParameterChange& change, const Model& model);

}  // namespace eha::ident
