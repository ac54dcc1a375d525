// SPDX-License-Identifier: GPL-3.0-or-later
// Starts of a model behind a valve map from models without one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "ident/estimation/fit_choice.hpp"

namespace eha::ident {

/// Fewest samples beyond either side of the dead band. Below this share the intervals of dead band and gain ratio cover
/// the true value far too seldom; at 0 the ratio is undetermined.
inline constexpr double kLeastShareOfASide = 0.06;

/// Dead bands that are worth a start, as shares of the input's range. Under an input of few levels the cost has several
/// minima over the dead band.
inline constexpr std::array<double, 3> kDeadBands = {0.01, 0.03, 0.1};

/// The requested model with its requests checked, if its structure has a valve map; else nothing.
/// @throws ConfigError  as check_requests()
[[nodiscard]] std::optional<StructureOptions> asked_behind_valve(const StructureOptions& asked);

/// The requested model with an input bias in place of the valve map and its requests.
[[nodiscard]] StructureOptions without_valve(const StructureOptions& asked);

/// The input bias of an optimum without a map. If free responses act as the bias: y = K bias/(s D) + offset/s is sum_i
/// c_i s^(i-1)/D with c_0 = K bias + offset a_0 and c_n = offset a_n.
[[nodiscard]] double equivalent_bias(const LocalOptimum& optimum);

/// The map of an optimum, if it has one.
[[nodiscard]] std::optional<ValveMap> valve_of(const LocalOptimum& optimum);

/// Moves the coordinate of the null, if there is one.
void move_null(const Parametrisation& parametrisation, Eigen::VectorXd& theta, double by);

/// Coordinates worth a start of a variant behind the map: G of the best optima without the map that treat the history
/// before t = 0 alike, the null at minus their bias, and the dead bands of kDeadBands. A requested start is the only
/// one.
/// @param linear  optima without the map, at least one
[[nodiscard]] std::vector<Eigen::VectorXd> valve_starts(const std::vector<LocalOptimum>& linear, const Variant& variant,
                                                        const Parametrisation& parametrisation,
                                                        const StructureOptions& asked,
                                                        const Parametrisation::Scale& scale);

/// The request for a record whose input is at 0 or on one side of it, as of a pump or a heater: the null of its map is
/// held at 0 and the gain ratio at 1, so that the dead band begins at rest. Other requests, and other records, as they
/// are.
[[nodiscard]] StructureOptions with_sides_of(const Eigen::Ref<const Eigen::VectorXd>& input, StructureOptions asked);

/// @throws DataError  the input stays at two levels and a dead band or gain ratio is wanted of it
void require_more_than_two_levels(const StructureOptions& asked, const Eigen::Ref<const Eigen::VectorXd>& input,
                                  const std::string& unit);

/// @param input  of the rows that estimate
/// @throws DataError  fewer than kLeastShareOfASide of them lie above the dead band, or below it; where the input has
///                    one side alone, beyond the dead band, or within it
void require_both_sides(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input,
                        const std::string& model_name, const std::string& unit);

}  // namespace eha::ident
