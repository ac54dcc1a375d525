// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ident/fractional/transfer_function.hpp"
#include "ident/signal/valve_map.hpp"
#include "ident/structure/parameter_role.hpp"

namespace eha::ident {

/// One estimated (or fixed) quantity of a model with its 95 % interval.
struct ParameterEstimate {
  std::string name;  ///< "a2", "n2", "K", "delay_s", "input_bias", "null", "initial_output", ...
  double value = 0.0;
  double std = 0.0;  ///< standard error under coloured residuals; 0 when fixed
  double lower95 = 0.0;
  double upper95 = 0.0;
  bool fixed = false;
  ParameterRole role = ParameterRole::denominator_coefficient;  ///< follows from the name
};

/// How well a simulated output follows a measured one. R2 and fit use the mean of the scored part.
struct Score {
  double r2_percent = 0.0;   ///< 100 (1 - sum e^2 / sum (y - mean y)^2)
  double mse = 0.0;          ///< mean e^2 [output unit^2]
  double fit_percent = 0.0;  ///< 100 (1 - |e| / |y - mean y|)
  double error_min = 0.0;    ///< least residual [output unit]
  double error_max = 0.0;    ///< greatest residual [output unit]
  std::size_t samples = 0;
};

/// A sampled correlation function with its confidence bounds.
struct Correlation {
  std::vector<int> lags;
  std::vector<double> values;  ///< normalised, one a lag
  double bound95 = 0.0;        ///< +- band that holds 95 % of the values of independent signals
  double bound99 = 0.0;
};

/// Criteria that weigh a structure's error against its number of parameters, to compare structures on one record: lower
/// is better. n is the effective number of samples, which counts correlated residuals less; p is the number of
/// parameters and V the mean square error:
///   aic = n ln V + 2 p, aicc = aic + 2 p (p + 1)/(n - p - 1), bic = n ln V + p ln n, fpe = V (n + p)/(n - p).
/// Akaike, IEEE Trans. AC 19 (1974); Hurvich and Tsai, Biometrika 76 (1989); Schwarz, Ann. Stat. 6 (1978).
struct InformationCriteria {
  std::size_t parameters = 0;  ///< estimated from the record
  double effective_samples = 0.0;
  double aic = 0.0;
  double aicc = 0.0;
  double bic = 0.0;
  double fpe = 0.0;  ///< [output unit^2]
};

/// Correlation of the errors of the estimated parameters.
struct ParameterCorrelation {
  std::vector<std::string> names;
  std::vector<std::vector<double>> matrix;     ///< one row a name
  std::vector<std::string> indistinguishable;  ///< parameters that the record cannot tell apart
};

/// How a fit was reached.
struct EstimationReport {
  Score score;
  std::optional<InformationCriteria> information;
  std::optional<ParameterCorrelation> correlation;
  std::size_t evaluations = 0;
  double seconds = 0.0;     ///< filled by the caller; ident has no clock
  std::string termination;  ///< "converged", "evaluation limit", ...
  bool converged = false;
};

/// The model held against the part of the record that did not estimate.
struct ValidationReport {
  Score score;                              ///< bias and offset kept
  std::optional<Score> offset_reestimated;  ///< initial_output fitted anew on the scored part
  Correlation acf;                          ///< of the residual, lags 0..20
  Correlation ccf;                          ///< residual against input, lags -20..20
  double ljung_box_p = 0.0;                 ///< p value of the portmanteau test on 20 lags
};

/// Frequency response of a model with first-order standard errors, one value a frequency.
struct BodeCurve {
  std::vector<double> frequency_Hz;
  std::vector<double> gain_dB;  ///< re 1 output unit per input unit
  std::vector<double> gain_std_dB;
  std::vector<double> phase_deg;
  std::vector<double> phase_std_deg;
};

struct StabilityReport {
  bool stable = false;
  std::string test;         ///< "matignon" or "argument_principle"
  double margin_rad = 0.0;  ///< least |arg pole| - pi/2 on the principal sheet; at most pi/2
};

struct Verdict {
  bool accepted = false;
  std::vector<std::string> reasons;  ///< why it is rejected, then notes; one sentence each
};

/// One window of the estimated input before t = 0, added to its value at rest: constant over from_s <= t < to_s <= 0.
struct PastInput {
  double from_s = 0.0;
  double to_s = 0.0;
  double value = 0.0;  ///< [input unit]; what passes the map where there is one
};

/// y(t) = initial_output + G(v)(t) + free response, at rest before t = 0 and before the past input, if any;
/// v = input_map(u) from t = 0 on where there is a map, else u + input_bias.
struct Model {
  std::string name;                   ///< "io", "fo"
  std::optional<ValveMap> input_map;  ///< none: the bias alone
  TransferFunction transfer_function;
  double input_bias = 0.0;      ///< [input unit], switched on at t = 0; 0 beside a map
  double initial_output = 0.0;  ///< [output unit], a permanent offset
  /// Numerator of the decaying free response x(s) = sum_i c_i s^i / D(s), i = 0..; empty for none.
  std::vector<double> initial_state;
  std::vector<PastInput> past_input;  ///< the latest window first; empty for none
  std::string input_unit = "V";
  std::string output_unit = "in";
  std::vector<ParameterEstimate> parameters;
  std::optional<EstimationReport> estimation;
  std::optional<ValidationReport> validation;
  std::optional<StabilityReport> stability;
  std::optional<BodeCurve> bode;
  std::optional<Verdict> verdict;
  std::string procedure = "default";
  std::map<std::string, std::string> provenance;  ///< normalisation, notes, source file, seed, versions
};

}  // namespace eha::ident
