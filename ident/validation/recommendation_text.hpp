// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/validation/model_choice.hpp"

/// The sentences that say why a model is recommended, or none: parts of Recommendation::reason.
namespace eha::ident::choice {

/// What is wrong first of all, in half a sentence.
[[nodiscard]] std::string first_reason(const Model& model);

/// @param all  the least AR-BIC first
[[nodiscard]] std::string reason_for(const Model& picked, const Models& all, const Model* runner_up);

/// "; cylinder, 2.2 better, has a resonance at 14.6 Hz ..." of those that would else be picked, or as well.
/// @param all  the least AR-BIC first
[[nodiscard]] std::string unseen_resonances(const Model& picked, const Models& all, const Model* runner_up);

/// "; io_valve, 4.2 better, has a map ..." of the accepted ones that their map kept from being picked.
[[nodiscard]] std::string needless_maps(const Model& picked, const Models& all);

/// "; io, 130.2 better, takes a drift ..." of those that would else be picked.
[[nodiscard]] std::string drifts(const Model& picked, const Models& all);

/// @param all  the least AR-BIC first
[[nodiscard]] std::string without_input_in_residual(const Model& picked, const Models& all);

/// Why better models by AR-BIC are not picked: "; io3, 25.1 better, is rejected: a0 = ...". @param all  the least first
/// @param named  already; null for none @param runner_up  of which any lower AR-BIC is explained; null for none
[[nodiscard]] std::string better_but_rejected(const Model& picked, const Models& all, const Model* named,
                                              const Model* runner_up);

/// What lies in the record, and holds for every model of it, with what to do; empty without such a thing.
[[nodiscard]] std::string cause_in_record(const Models& all);

[[nodiscard]] std::string accepted_among(const Models& models, const Models& all, const Models& order);

/// Why none of the identified models is picked.
[[nodiscard]] std::string none_picked(const Models& order, const Models& all);

}  // namespace eha::ident::choice
