// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// Starts from models that were fitted to the same record.
struct KnownStarts {
  std::vector<Eigen::VectorXd> at;    ///< where this structure is the model; the best model first
  std::vector<Eigen::VectorXd> near;  ///< nearby, where what the model lacks has an effect

  /// Adds the places of the three best models and their neighbours.
  void append_to(std::vector<Eigen::VectorXd>& starts) const;
};

/// The coordinates of those models that have a place in the parametrisation, see Parametrisation::at_model. A part that
/// a smaller model lacks has no effect at its place. `near` adds places where it has some effect: a dead band of 1, 3
/// and 10 % of the input's range, a delay of 1 and 4 steps or that of another known model.
/// @param known  with validation or without; ordered by their estimation error here
[[nodiscard]] KnownStarts known_starts(const Parametrisation& parametrisation, const std::vector<Model>& known,
                                       const Parametrisation::Scale& scale);

/// A fit from known models is never worse than one of them, except for the tolerance of the search.
constexpr double kNoWorse = 1e-3;

/// The least mean square error of the models that have a place in the parametrisation; infinite without one.
[[nodiscard]] double least_known_error(const Parametrisation& parametrisation, const std::vector<Model>& known);

/// The input bias of a model without a map, also if its free response acts as the bias.
[[nodiscard]] double equivalent_bias(const Model& model);

/// Starts that restore a term whose coefficient has vanished: its weight 1 % and 10 % of the others', its order at a
/// quarter and three quarters of the search box. None if no term has vanished.
[[nodiscard]] std::vector<Eigen::VectorXd> revived(const Parametrisation& parametrisation,
                                                   const Eigen::VectorXd& theta);

}  // namespace eha::ident
