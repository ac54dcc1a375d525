// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"

namespace eha::ident {

/// Greatest error of a valve map beside its edges, at the map's output: the residual is explained by an output of the
/// map that is off by a constant within each half of the dead band, as far again beyond either edge, and farther on.
///   e(t) = c_0 + sum_b c_b G(1_b(u))(t) + slopes;  the greatest |c_b| beyond two standard errors, of the four inner b
/// Oil that leaks past a piston moves the rod within the dead band. The fit bends null and dead band towards that, and
/// their intervals, which take the map for the valve's, do not hold it.
/// @param outputs   on the record that `whole_residual` is of  @param whole_residual  of all compared rows
/// @returns [input unit]; none without a map or a dead band, for a model that grows, or on fewer than 60 rows
/// Cost eight responses.
[[nodiscard]] std::optional<double> map_error(const Model& model, OutputOnRecord& outputs,
                                              const Eigen::VectorXd& whole_residual);

/// Whether a map lets its input through in one direction only, as that of a record which reached one edge of the dead
/// band: that edge is known, null and half dead band are not.
[[nodiscard]] bool is_one_way(const ValveMap& map);

/// The error of a model's map by its report; 0 where it has none, infinite where the map is one-way [input unit].
[[nodiscard]] double reported_map_error(const Model& model);

/// Null and dead band of a fit may be off by this many times that error, see MapError in the tests.
inline constexpr double kShiftOverMapError = 2.0;

/// A shift of null and half dead band by more than this is worth a sentence [V]; two measurements of one valve differ
/// by less.
inline constexpr double kNotedShift_V = 0.03;

/// The half dead band that a record leaves open, as its interval holds 0; null where one is found or held, and without
/// a map.
[[nodiscard]] const ParameterEstimate* unfound_dead_band(const Model& model);

/// The shift that map_note() names: above kNotedShift_V (of another input unit none) or 0.4 of the dead band
/// [input unit].
[[nodiscard]] std::optional<double> noted_shift(const Model& model);

/// What a valve sheet of the rig says of a leak, beside a model of it.
enum class SheetSays {
  nothing,   ///< there is none, or it did not see
  is_tight,  ///< the rod rests within the valve's own dead band
};

/// What the error of a model's map means: that the rod moves within the dead band, or that the map stands for dry
/// friction where that is known to hold (kGreyBoxHolds), and by how much null and half dead
/// band of the fit may be off the valve's; or that the map is one-way. Of a dead band that is not found nothing
/// else. No capital and no point. Empty where the map
/// fits: for a shift of at most kNotedShift_V (of another input unit none) and of at most 0.4 of the dead band.
/// @param sheet  of a tight rig, whose rod friction moves within the map's dead band
[[nodiscard]] std::string map_note(const Model& model, SheetSays sheet = SheetSays::nothing);

/// Returns how far null and dead band of a model may be off the valve's, whatever their intervals say [input unit].
/// None where its map errs by less than a fifth of the dead band, or has no error.
[[nodiscard]] std::optional<double> map_shift(const Model& model);

}  // namespace eha::ident
