// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ident/excitation/tone.hpp"
#include "ident/fit_options.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// Limits of a rig on an excitation.
struct ExcitationLimits {
  double lowest_V = 0.0;  ///< input
  double highest_V = 0.0;
  double slew_V_per_s = 0.0;
  double lowest_output = 0.0;  ///< travel [output unit]
  double highest_output = 0.0;
  double step_s = 0.001;  ///< tick
};

/// Length, rig limits and fit options of one repetition of an experiment.
struct ImprovementTask {
  double duration_s = 50.0;
  double period_s = 20.0;  ///< tones are multiples of its reciprocal
  FitOptions options;      ///< discard_s, decimation and split
  ExcitationLimits limits;
  std::uint64_t seed = 1;  ///< of the draws of phases
};

/// The binding limit of the excitation.
enum class BindingLimit { voltage, slew, travel };
[[nodiscard]] std::string_view text(BindingLimit limit);

/// A multisine with its predicted effect.
struct Improvement {
  std::vector<Tone> tones;  ///< by rising frequency
  double offset_V = 0.0;    ///< prevents a drift of the output
  BindingLimit binding = BindingLimit::voltage;
  double peak_V = 0.0;
  double peak_slew_V_per_s = 0.0;
  double lowest_output = 0.0;  ///< predicted [output unit]
  double highest_output = 0.0;
  double std = 0.0;  ///< of the parameter, predicted for one repetition
};

/// Predicts the standard error of one parameter after an estimation from an experiment. Simulates the model with the
/// input, takes its derivatives by every estimated parameter at the samples that estimate, and assumes a residual like
/// the model's own, which contains noise and model error. The residual is whitened if the model was estimated with a
/// noise model, otherwise it keeps its colour.
/// @param input  one repetition, a value a tick [input unit]
/// @throws ConfigError  the model file lacks standard errors or the noise, or does not estimate the parameter
/// Cost: a simulation a parameter.
[[nodiscard]] double predicted_std(const Model& model, const std::string& parameter,
                                   const Eigen::Ref<const Eigen::VectorXd>& input, const ImprovementTask& task);

/// Designs the multisine that minimises the standard error of one parameter of G within the limits.
/// Its tones lie at multiples of 1/period_s, up to a band that the decimation filter passes. Their powers are optimal
/// for the stored noise (tone_powers). Their phases are the best of many draws with respect to voltage, slew and
/// travel. The multisine is scaled until a limit binds; the model with its map predicts the travel.
/// @throws ConfigError  as predicted_std, or the parameter is none of G, or the limits leave no room
[[nodiscard]] Improvement improve(const Model& model, const std::string& parameter, const ImprovementTask& task);

/// Returns the candidates of improve(), for trials with a better plant model than the model file: optimal for the
/// stored and for a white noise, each with several shares of the power moved to the lowest tone. That tone carries the
/// others over a dead band. At least one candidate; the smallest predicted standard error first.
[[nodiscard]] std::vector<Improvement> improvements(const Model& model, const std::string& parameter,
                                                    const ImprovementTask& task);

}  // namespace eha::ident
