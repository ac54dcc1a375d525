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

/// One repetition of an experiment and its use.
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

/// A multisine and what it does.
struct Improvement {
  std::vector<Tone> tones;  ///< by rising frequency
  double offset_V = 0.0;    ///< without which the output would drift
  BindingLimit binding = BindingLimit::voltage;
  double peak_V = 0.0;
  double peak_slew_V_per_s = 0.0;
  double lowest_output = 0.0;  ///< predicted [output unit]
  double highest_output = 0.0;
  double std = 0.0;  ///< of the parameter, predicted for one repetition
};

/// Standard error of one parameter that an estimation from an experiment would have: the model simulated with the
/// input, its derivatives by every estimated parameter at the samples that estimate, and the errors that the model's
/// own residual would then leave. The residual contains noise and model error; the new residual is assumed to be alike.
/// It is whitened if the model was estimated with a noise model, otherwise it keeps its colour.
/// @param input  one repetition, a value a tick [input unit]
/// @throws ConfigError  the model file lacks standard errors or the noise, or does not estimate the
/// parameter Cost: a simulation a parameter.
[[nodiscard]] double predicted_std(const Model& model, const std::string& parameter,
                                   const Eigen::Ref<const Eigen::VectorXd>& input, const ImprovementTask& task);

/// Designs the multisine that makes the standard error of one parameter of G smallest within the limits. Tones lie at
/// multiples of 1/period_s, up to a band that the decimation filter passes; their powers are
/// optimal for the stored noise (tone_powers); phases, the best of many draws, keep voltage, slew and travel low; the
/// whole is scaled until a limit binds, the travel predicted by the model with its map.
/// @throws ConfigError  as predicted_std, or the parameter is none of G, or the limits leave no room
[[nodiscard]] Improvement improve(const Model& model, const std::string& parameter, const ImprovementTask& task);

/// The candidates of improve(), for trials with a better model of the plant than the model file: optimal for the stored
/// and for a white noise, each with several shares of the power given to the lowest tone, which carries the others over
/// a dead band. At least one; smallest predicted standard error first.
[[nodiscard]] std::vector<Improvement> improvements(const Model& model, const std::string& parameter,
                                                    const ImprovementTask& task);

}  // namespace eha::ident
