// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "ident/model/model.hpp"

/// Which model of a record may be recommended, by AR-BIC and what its kind must gain: the parts of recommend(). `all`
/// are those that compared() returns, with their verdicts; a part reads them alone. Cost of each: none to speak of.
namespace eha::ident::choice {

using Models = std::vector<const Model*>;

/// Those that can be compared with the first one that has a criterion, the least AR-BIC first.
[[nodiscard]] Models compared(const Models& models);

/// Whether its verdict is good or usable.
[[nodiscard]] bool is_accepted(const Model& model);

/// Frequency [Hz] of a pair of poles so far above the band that the record shows that only its lag can be seen there.
[[nodiscard]] std::optional<double> unseen_resonance_Hz(const Model& model);

/// The statistic of the test for nonlinear effects where it fails: such a plant looks fractional to a linear model.
[[nodiscard]] double bend(const Model& model);

/// The best of one kind; null without one. @param all  the least AR-BIC first
[[nodiscard]] const Model* best(const Models& all, bool with_estimated_order);

/// Whether every estimated order is a whole number for any use; what it gains is then another effect's.
[[nodiscard]] bool is_whole_in_effect(const Model& model);

/// The least AR-BIC first of the models that an estimated order must beat: those of integer order, and those whose
/// estimated orders are whole in effect, which speak for an integer order too. Null: it need not beat any.
[[nodiscard]] const Model* rival_of_orders(const Models& all, const Model& model);

/// Whether a pair of poles that hardly decays lies at or above half the rate of the compared samples: what the input
/// did between the rows makes one, and the record shows no such motion.
[[nodiscard]] bool rings_between_rows(const Model& model);

/// Whether noise of the measured input, or its way between the rows, makes what the model leaves over.
[[nodiscard]] bool is_blurred(const Model& model);

/// Whether noise of the measured input, or its way between the rows, makes what a model without a map and without
/// estimated orders leaves over: a map or an order then takes that in.
[[nodiscard]] bool takes_in_input_error(const Models& all, const Model& model);

/// Whether the excitation determines less than what the model estimates, and all of a plain one that errs as little.
[[nodiscard]] bool asks_too_much_of_input(const Models& all, const Model& model);

/// Whether the model has more parameters than a plain one and fits the sensor's steps with them, which no criterion of
/// noise knows.
[[nodiscard]] bool fits_rounding(const Models& all, const Model& model);

/// Whether the map may be what a controller in the record makes of noise: it bends one as no valve does.
[[nodiscard]] bool is_bent_by_loop(const Models& all, const Model& model);

/// Whether a zero on the right that is faster than the usable band does what the dead time of a model of integer order,
/// of no more parameters and behind a map only if this one is, does as well.
[[nodiscard]] bool stands_for_dead_time(const Models& all, const Model& model);

/// Whether the model is of integer order, or gains enough on every model that speaks for integer orders. One that takes
/// in a drift may not while another one is accepted.
[[nodiscard]] bool may_be_picked(const Models& all, const Model& model);

/// The identified models in the order in which they are preferred. One of estimated order that does not gain enough
/// comes last.
[[nodiscard]] Models preferred(const Models& all, Models identified);

/// Whether the difference of AR-BIC is too small to tell.
[[nodiscard]] bool is_unclear_between(const Model& picked, const Model& other);

/// Whether one of them has a dead time and the other none.
[[nodiscard]] bool one_has_a_delay(const Model& picked, const Model& other);

/// Whether the tests show that the input still moves what the model leaves over.
[[nodiscard]] bool fails_input_test(const Model& model);

/// An accepted model with less than half the error on the unseen part, or less than a third where it has more
/// parameters; null without one. What the estimation part gains by more parameters was then overfitted, or is of
/// frequencies that the other part has not; or a noise model took for noise what a part of the plant makes.
[[nodiscard]] const Model* surpassing(const Models& order, const Model& model);

/// The first of the models that is not the picked one; null without one. One that is far worse tells nothing of the
/// choice: then the least AR-BIC of the others. @param order  as preferred
[[nodiscard]] const Model* next_best(const Models& order, const Model& picked);

/// Of rejected models the one that errs least on unseen data, as their table has it first; of equal ones the best by
/// the criterion.
[[nodiscard]] const Model& nearest(const Models& all);

}  // namespace eha::ident::choice
