// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Probability of a reported change although nothing changed, for all that a comparison holds against each other
/// together: parameters or quantities, of all runs, sheets and models.
inline constexpr double kFalseAlarm = 0.01;

/// What a compared number is: a parameter as the model has it, or what an engineer makes of it for a plant that comes
/// to rest.
enum class Figure {
  parameter,
  gain_at_rest,  ///< "K/a0", in place of K
  time_constant  ///< "T", in place of a0 of a model with one pole [s]
};

/// What an engineer makes of a parameter of a plant that comes to rest.
struct FigureAtRest {
  Figure figure = Figure::parameter;
  std::string name;  ///< "K/a0", "T"
  double value = 0.0;
  double std = 0.0;  ///< by the parameters' covariance
  std::string unit = {};
};

/// Whether a model has a gain at rest: it comes to rest, has no zero and no map, by which its intervals would be that
/// map's.
[[nodiscard]] bool has_gain_at_rest(const Model& model);

/// The figure in place of a parameter: K/a0 of K, and 1/a0 of the a0 of one pole; none for others. Of a model that
/// has_gain_at_rest().
[[nodiscard]] std::optional<FigureAtRest> figure_at_rest(const Model& model, const ParameterEstimate& parameter);

/// One parameter of two models of equal structure, each from its own record.
struct ParameterChange {
  std::string name;
  ParameterRole role = ParameterRole::denominator_coefficient;
  double before = 0.0;
  double after = 0.0;
  double std = 0.0;                       ///< of after - before
  double half_width = 0.0;                ///< of its joint interval: after - before +- half_width
  double of_noise = 0.0;                  ///< the part of half_width due to noise alone
  bool changed = false;                   ///< the joint interval excludes 0
  std::vector<std::string> follows = {};  ///< changed parameters of the map that cause the rest of half_width
  bool may_lead = false;                  ///< the change, beyond noise, may be the cause of theirs instead
  Figure figure = Figure::parameter;

  /// Whether it moved far beyond noise and by a share that matters, though the map that changed may have made that.
  [[nodiscard]] bool may_have_changed() const noexcept;
};

/// The change of a plant between two models.
struct PlantChange {
  std::vector<ParameterChange> parameters;   ///< estimated in both models, those furthest outside 0 first
  std::vector<std::string> undetermined;     ///< estimated, but one of the records does not determine them
  std::vector<std::string> other_unit = {};  ///< of without_other_units(), which have no difference
  bool changed = false;                      ///< at least one parameter changed
};

/// Whether a parameter is null or dead band of a valve: what a leak or friction shifts where a map does not fit.
[[nodiscard]] inline bool is_of_dead_zone(ParameterRole role) noexcept {
  return role == ParameterRole::valve_null || role == ParameterRole::dead_band;
}

/// Whether nothing else is shown to have changed; true where nothing is.
[[nodiscard]] bool is_of_dead_zone_alone(const PlantChange& change);

/// Whether a model leaves plain noise over: a curved valve or a part that it misses would show in it.
[[nodiscard]] bool leaves_plain_noise(const Model& model);

/// Compares the parameters of the plant (not those of the record's start) that both models estimated. Among the latter
/// are input_bias of models that come to rest, and the null of such with a straight map: comes_to_rest().
/// Of models without a map that both come to rest the gain is K/a0, and of one pole the time constant is T = 1/a0: a
/// time constant that changed then moves no gain.
/// The intervals are joint: the probability that any of them excludes 0 although nothing changed is at most `level`
/// (Bonferroni). Each uses Student's t with the fewer effective samples of the two models. For a model that was fitted
/// with a noise model every sample is effective, because its whitened residual is independent. Standard errors of
/// independent records add in squares; a parameter without one counts as known.
/// A piecewise linear map approximates a curved valve. If a parameter of the map changed, the joint interval of each
/// other parameter also includes the shift that follows from that change by their estimated correlation. A dead band
/// that grew is thus not reported as a change of the gain, too. Not where both models leave plain noise over: the valve
/// is then no more curved than the noise shows, and the intervals of the fits hold.
/// @param level  0 < level < 1, for all parameters together
[[nodiscard]] PlantChange compare_parameters(const Model& before, const Model& after, double level);

/// Beside another change, what moves null, half dead band and ratio of a map is within their intervals: friction takes
/// another share of a changed gain, and a cylinder is another one at another place of its rod. On the simulated rig a
/// gain that falls by 20 % moves the null by 0.5 % of half the dead band, and another place half the dead band by 5 %.
/// @param is_elsewhere  the records are about two places
/// Cost: none to speak of.
void widen_beside_other_changes(PlantChange& change, bool is_elsewhere);

/// Widens the interval of a parameter; where it is no change any more, no other one follows it.
void widen_to(PlantChange& change, ParameterChange& parameter, double half_width);

/// Leaves out what has another unit in the other model, as a coefficient of another order has, where the structures
/// differ: there is no difference of a time and a time to the power 1.044. Of one structure nothing is left out.
[[nodiscard]] PlantChange without_other_units(PlantChange change, const Model& before, const Model& after);

/// "a2 has another unit in each, so it has no difference".
[[nodiscard]] inline std::string other_unit_sentence(const std::string& parameter) {
  return parameter + " has another unit in each, so it has no difference";
}

/// States which change is hidden by more than noise: "a change of K below 0.23 mm/(V s) does not show here: dead_band
/// changed, and the fit lets K follow it (by noise alone 0.023 mm/(V s))". Empty if only noise hides a change, and for
/// a change that shows.
[[nodiscard]] std::string hidden_sentence(const ParameterChange& change, const Model& model);

/// "dead_band changed, and the fit lets K follow it".
[[nodiscard]] std::string lets_follow(const std::vector<std::string>& causes,
                                      const std::vector<std::string>& followers);

/// "dead_band or K changed, or both, as the fit lets one follow the other".
[[nodiscard]] std::string either_follows(const std::vector<std::string>& some, const std::vector<std::string>& others);

/// What a change may be of although the model names another parameter: "without a valve map a dead band or null that
/// changed shows as K: ...". Empty where the model has a map, or none of the changed parameters would show it.
/// @param changed  names of the parameters that changed
[[nodiscard]] std::string map_instead(const std::vector<std::string>& changed, bool has_map);

/// What a changed gain is instead where it is 25.4, 10, 100 or 1000 times as great or as small, within its interval or
/// 1 %: the unit of one record. Empty for any other ratio, and where the interval is wider than a tenth of the gain.
[[nodiscard]] std::string unit_instead(const PlantChange& change);

/// A parameter's value in a table: "0.148"; "0 to 0.0061" for a coefficient of which the record only shows that it is
/// small, as its 95 % interval holds 0.
[[nodiscard]] std::string value_text(const std::string& parameter, double value, const Model& model);

/// The same with the decimals that half its interval justifies, see rounded_to().
[[nodiscard]] std::string value_text(const std::string& parameter, double value, const Model& model, double half_width);

/// Unit of a changed parameter of a model, as of any of its parameters.
[[nodiscard]] std::string unit_of(const ParameterChange& change, const Model& model);

}  // namespace eha::ident
