// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/export/sections.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// Largest error that an exported model of fractional order may have over the band.
constexpr double kMostGainError_percent = 1.0;
constexpr double kMostPhaseError_deg = 1.0;

/// Error of the exported sections against the model of fractional order, measured at export.
struct ApproximationError {
  FrequencyInterval band;
  double gain_percent = 0.0;       ///< greatest over the band
  double phase_deg = 0.0;          ///< greatest over the band
  double step_percent = 0.0;       ///< of a step response over two of the band's longest periods, relative to its peak
  double multisine_percent = 0.0;  ///< of the response to three tones over the band, relative to its peak
};

/// A model in a form that needs no fractional operators:
///   y(t) = initial_output + sections(v)(t), v = map(u) from t = 0 on, or u + input_bias, 0 before.
struct ExportedModel {
  std::string name;
  TransferFunction transfer_function;
  Sections sections;
  std::optional<ApproximationError> error;  ///< none: exact, the orders are whole
  std::optional<ValveMap> input_map;
  double input_bias = 0.0;
  double initial_output = 0.0;
  std::string input_unit;
  std::string output_unit;
  std::optional<FrequencyInterval> shown_band = {};  ///< band in which the model's record supports it; none: not known
  std::string verdict = {};                          ///< verdict_word(); empty: not judged
  std::vector<std::string> rejected_for;             ///< reasons of a verdict that rejects it
  /// Largest error where it was not estimated [output unit]; none: not known.
  std::optional<double> largest_error = {};
  std::optional<FrequencyInterval> usable_band = {};
  std::vector<std::string> origin = {};  ///< record, program, file: one line each, as untrusted as the name
};

/// Realises a model as sections of order one or two: whole orders exactly, fractional ones by a stable approximation.
/// @param band  for fractional orders; none: the verdict's usable band, else the frequencies of the model's Bode plot,
///              else those where its terms cross
/// @throws ConfigError  not well formed; fractional orders and unstable, or an initial state or a delayed past input
///                      beside them; or the approximation misses kMostGainError_percent or kMostPhaseError_deg
/// Cost: some 0.1 s for fractional orders.
[[nodiscard]] ExportedModel exported(const Model& model, const std::optional<FrequencyInterval>& band);

/// Returns the output of an exported model: N samples for N of the input, as simulate(Model). Cost O(N states).
[[nodiscard]] Eigen::VectorXd simulate(const ExportedModel& model, const Eigen::Ref<const Eigen::VectorXd>& input,
                                       double step_s);

}  // namespace eha::ident
