// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ident/fractional/stability.hpp"
#include "ident/fractional/transfer_function.hpp"
#include "ident/grey_box/grey_box_kind.hpp"
#include "ident/model/criterion.hpp"
#include "ident/signal/valve_map.hpp"
#include "ident/structure/parameter_role.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// One estimated or fixed quantity of a model with its 95 % interval.
struct ParameterEstimate {
  std::string name;  ///< "a2", "n2", "K", "delay_s", "input_bias", "null", "initial_output", ...
  double value = 0.0;
  double std = 0.0;  ///< standard error under coloured residuals; 0 when fixed
  double lower95 = 0.0;
  double upper95 = 0.0;
  bool fixed = false;
  ParameterRole role = ParameterRole::denominator_coefficient;  ///< follows from the name
};

/// Agreement of a simulated output with a measured one. R2 and fit use the mean of the scored part.
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

/// Rise of the criterion when a free order's term is left out and the rest is estimated again.
struct LeftOut {
  std::string order;  ///< name of the order: "n2"
  double rise = 0.0;  ///< AR-BIC of the smaller structure less that of this one
};

/// Criteria that weigh a structure's error against its number of parameters; lower is better. Structures are compared
/// by AR-BIC alone: it has no unit, does not depend on the other fits, and holds for a coloured residual. With AR(m)
/// the autoregressive model of the residual that BIC chooses and s^2 its innovation variance over n rows (all but the
/// first 10, which are its past),
///   ar_bic = n ln(s^2 / var y) + (p + m) ln n.
/// The others treat the residual as `effective_samples` independent values of mean square V:
///   aic = n ln V + 2 p, aicc = aic + 2 p (p + 1)/(n - p - 1), bic = n ln V + p ln n, fpe = V (n + p)/(n - p).
/// Akaike, IEEE Trans. AC 19 (1974); Hurvich and Tsai, Biometrika 76 (1989); Schwarz, Ann. Stat. 6 (1978).
struct InformationCriteria {
  std::size_t parameters = 0;  ///< p, estimated from the record, offset and bias included
  double effective_samples = 0.0;
  double aic = 0.0;
  double aicc = 0.0;
  double bic = 0.0;
  double fpe = 0.0;  ///< [output unit^2]
  double ar_bic = 0.0;
  std::size_t ar_order = 0;  ///< m
  std::size_t samples = 0;   ///< n of ar_bic
  std::string record;        ///< identity of the compared rows: AR-BIC values are comparable only if n and record agree
  std::vector<LeftOut> left_out;  ///< one a free order; empty where it was not determined
};

/// Correlation of the errors of the estimated parameters.
struct ParameterCorrelation {
  std::vector<std::string> names;
  std::vector<std::vector<double>> matrix;     ///< one row a name
  std::vector<std::string> indistinguishable;  ///< parameters that the record cannot distinguish
};

/// Autoregressive model of the noise in the compared samples, from a model's residual e: e_k = sum_j c_j e_{k-j} + w_k.
struct ResidualNoise {
  double power = 0.0;                        ///< mean square of e [output unit^2]
  double variance = 0.0;                     ///< mean square of w [output unit^2]
  std::vector<double> coefficients = {};     ///< c_1, c_2, ...; empty for white
  std::vector<double> autocorrelation = {};  ///< of e at lags 0 .. order
  bool with_parameters = false;              ///< the parameters were estimated together with a noise model
};

/// Result of an estimation, without its parameters.
struct EstimationReport {
  Score score;
  std::optional<InformationCriteria> information;
  std::optional<ParameterCorrelation> correlation;
  std::size_t evaluations = 0;
  double seconds = 0.0;     ///< filled by the caller; ident has no clock
  std::string termination;  ///< "converged", "evaluation limit", ...
  bool converged = false;
  std::optional<double> compared_step_s = {};  ///< time between compared samples
  std::optional<ResidualNoise> noise = {};     ///< none after the paper's procedure
  /// Least and greatest input of the rows that estimate [input unit]; none in files of earlier versions.
  std::optional<std::pair<double, double>> input_range = {};
};

/// A joint test of the residual, whitened by its autoregressive model.
struct ResidualTest {
  double statistic = 0.0;  ///< chi-squared with `degrees` of freedom for a right model
  std::size_t degrees = 0;
  double p = 1.0;  ///< probability of a statistic at least as large
};

/// A straight line fitted to a residual.
struct ResidualDrift {
  double change = 0.0;    ///< absolute change of the line from the first sample to the last [output unit]
  double expected = 0.0;  ///< greatest change that noise and the parameters' errors explain [output unit]
};

/// Kinds of deviation of a plant from a linear one, see nonlinear_effects().
enum class NonlinearKind { level, direction, motion, position, time };

/// "level", "direction", "motion", "position" or "time", as in model files.
[[nodiscard]] std::string_view text(NonlinearKind kind);

/// How the plant's gain changes where the input grows: it falls as where something saturates, and grows as beyond a
/// dead band.
enum class GainTrend { unknown, falls, grows };

/// "falls" or "grows", as in model files; "" if unknown.
[[nodiscard]] std::string_view text(GainTrend trend);

/// Test of the residual for effects of a nonlinear plant.
struct NonlinearityTest {
  ResidualTest test;                          ///< all kinds together
  NonlinearKind kind = NonlinearKind::level;  ///< the kind that explains most of the residual
  GainTrend gain = GainTrend::unknown;        ///< beside the model's, of kind level
  /// The kind that explains as much, as far as the record tells, or what `kind` leaves over; none where `kind` is
  /// clear.
  std::optional<NonlinearKind> or_kind = {};
};

/// Predicted RMS error of the model's output on a fresh input of the same kind, without noise, over the output's
/// standard deviation [%]. Estimated from this part of the record.
struct PredictedError {
  double lower = 0.0;  ///< the part of the residual that input and nonlinear effects explain
  double upper = 0.0;  ///< that and the effects that noise may hide, or the whole residual if it need not be noise
};

/// Joint tests of the residual that account for the errors of the estimated parameters.
struct ResidualTests {
  std::size_t ar_order = 0;  ///< of the residual's model
  ResidualTest input;        ///< no correlation with the input up to 20 lags before, see residual_tests()
  ResidualTest whiteness;    ///< no correlation of the noise model's innovations at lags 1..20
  std::optional<ResidualDrift> drift = {};
  std::optional<NonlinearityTest> nonlinearity = {};  ///< none: not requested
  std::optional<ResidualTest> future_input = {};      ///< no correlation with the input that follows, up to 10 lags
  std::optional<PredictedError> error = {};
  /// Tested samples at most 20 lags behind a move of the input: the others hold no answer of the plant. None: not
  /// known.
  std::optional<std::size_t> moved = {};
  /// Rms of what the errors of the parameters and of the recorded input leave of the residual [output unit]. None: not
  /// known.
  std::optional<double> rms_beyond_errors = {};
};

/// The values of an input with at most two of them [input unit].
struct InputLevels {
  double lower = 0.0;
  double upper = 0.0;  ///< equals lower for a constant input
};

/// A stop at the end of the travel other than that of an EndStop.
struct OtherStop {
  double level = 0.0;   ///< [output unit]
  double from_s = 0.0;  ///< start of the first stay there, time of the record
};

/// The output stayed at its greatest or least value while the input demanded motion beyond it: a rod on its end stop.
struct EndStop {
  double level = 0.0;                   ///< position of the stop [output unit]
  double from_s = 0.0;                  ///< start of the first stay, time of the record
  double percent = 0.0;                 ///< rows of all stays, at either end
  std::optional<OtherStop> other = {};  ///< where the output stayed at the other end too
  /// Bounds of the longest stretch without a stay; none: it starts at the record's start, or ends at its end.
  std::optional<double> clean_from_s = {};
  std::optional<double> clean_to_s = {};
  /// It is no stop: the output stands whatever the input asks, at any place. Of such a stay the end; none: the
  /// record's.
  bool does_not_answer = false;
  std::optional<double> to_s = {};
};

/// A sudden lasting change of the error, or a burst of it.
struct ErrorJump {
  double time_s = 0.0;      ///< of the record; where a burst begins
  double change = 0.0;      ///< [output unit]; of a burst its greatest
  double usual = 0.0;       ///< least change over a few rows that counts as a jump [output unit]; 0: not known
  bool estimating = false;  ///< it lies in the rows that estimated the model, whose parameters are wrong by it
  /// Of a burst: when the error is back at what it is elsewhere [s].
  std::optional<double> until_s = {};
};

/// White noise of the recorded input in itself that did not reach the plant: a model makes of it what the plant does
/// not.
struct InputNoise {
  double rms = 0.0;          ///< [input unit]
  double in_output = 0.0;    ///< rms of what the model makes of it, about slow motion [output unit]
  double share = 0.0;        ///< of the power of what the model leaves over; above 1 by chance
  double attenuation = 0.0;  ///< share by which it makes a gain come out too small, about
  double step = 0.0;         ///< of the codes of the input, whose rounding it is [input unit]; 0: it is other noise
};

/// The step of a coarse sensor where rounding to it makes much of what a model leaves over.
struct SensorStep {
  double step = 0.0;  ///< [output unit]
};

/// Comparison of the model with the part of the record that was not used for estimation.
struct ValidationReport {
  Score score;                              ///< bias and offset kept
  std::optional<Score> offset_reestimated;  ///< initial_output refitted to the scored part
  Correlation acf;                          ///< of the residual, lags 0..20
  Correlation ccf;                          ///< residual against input, lags -20..20
  double ljung_box_p = 0.0;                 ///< p value of the portmanteau test on 20 lags
  std::optional<ResidualTests> tests;       ///< none where the samples are too few
  /// Samples whose input exceeds the range of the estimating part by half of that range, or by a tenth behind a map
  /// [%]; none on another record.
  std::optional<double> extrapolated_percent;
  /// Samples, estimating ones included, at which the output stays at its greatest or least value while the model's
  /// output goes beyond it [%].
  std::optional<double> saturated_percent = {};
  std::optional<EndStop> end_stop = {};  ///< of all compared samples
  std::optional<ErrorJump> jump = {};    ///< of all compared samples
  /// Excitation order of the input to G at all compared samples, see excitation_order(); none for a constant input.
  std::optional<std::size_t> excitation_order = {};
  /// Greatest error of the valve map's lines beside its edges, as map_error() [input unit].
  std::optional<double> map_error = {};
  std::optional<InputLevels> input_levels = {};  ///< none if the input takes more than two values
  std::optional<SensorStep> sensor_step = {};    ///< none where rounding makes little of the residual
  /// Of an input that is taken as straight between its rows, see curves_between_rows(); none of another.
  std::optional<double> between_rows = {};
  std::optional<InputNoise> input_noise = {};  ///< none where the input has none, or the residual speaks against it
  /// R2 of the faster motion, see r2_of_faster_percent() [%]; none where the samples are too few.
  std::optional<double> faster_r2_percent = {};
};

/// A scalar statistic and its name in model files. The reader and the writer of the files use this list.
struct NamedStatistic {
  const char* name;
  double ValidationReport::*value;
};
inline constexpr std::array kValidationStatistics{NamedStatistic{"ljung_box_p", &ValidationReport::ljung_box_p}};

/// Frequency response of a model with first-order standard errors, one value a frequency.
struct BodeCurve {
  std::vector<double> frequency_Hz;
  std::vector<double> gain_dB;  ///< re 1 output unit per input unit
  std::vector<double> gain_std_dB;
  std::vector<double> phase_deg;
  std::vector<double> phase_std_deg;
};

/// Grade of confidence in a model.
enum class Grade {
  rejected,  ///< not stable, not identified, or the limits are not met
  usable,    ///< only residual tests or extrapolation fail, or a criterion could not be judged
  good,      ///< every criterion passed
};

/// "good", "usable" or "rejected", as in model files.
[[nodiscard]] std::string_view text(Grade grade);

/// lowest_Hz <= f <= highest_Hz.
struct FrequencyInterval {
  double lowest_Hz = 0.0;
  double highest_Hz = 0.0;
};

struct Verdict {
  bool accepted = false;                  ///< not rejected
  std::vector<std::string> reasons = {};  ///< why it is rejected, then notes; one sentence each
  Grade grade = Grade::rejected;
  std::vector<Criterion> criteria = {};  ///< every applicable one
  /// Band in which the record's input excites the plant and the model's response is accurate; see usable_band(). None:
  /// there is no such band, or it is unknown.
  std::optional<FrequencyInterval> usable_band = {};
  bool beside_ladder = false;  ///< every structure of the ladder was fitted to the record, too
  /// Input and output rest in the part of the record that would judge, so that all of it estimated the model.
  bool judging_part_rests = false;
  /// The verdict in one word, for tables; see verdict_word(). Empty in files of earlier versions.
  std::string word = {};
  /// Another accepted model of the record, which leaves nothing over that the input moves; empty: none.
  std::string explained_by = {};
  /// Rms error over that of the recommended model, both on the validation part; none: it is the recommended one, or
  /// there is none.
  std::optional<double> error_over_recommended = {};
};

/// One window of the estimated input before t = 0, added to its value at rest: constant over from_s <= t < to_s <= 0.
struct PastInput {
  double from_s = 0.0;
  double to_s = 0.0;
  double value = 0.0;  ///< [input unit]; behind the map if there is one
};

/// A plant with equations of its own: a kind and its values, one an entry of the kind's list.
struct GreyBox {
  const GreyBoxKind* kind = nullptr;
  std::vector<double> values;
};

/// y(t) = initial_output + G(v)(t) + free response, at rest before t = 0 and before the past input, if any;
/// v = input_map(u) from t = 0 on where there is a map, else u + input_bias. With a grey box y(t) = initial_output +
/// z(t), z the first of its states, which start at initial_state, or at 0.
struct Model {
  std::string name;                           ///< "io", "fo"
  std::optional<ValveMap> input_map;          ///< none: the bias alone
  std::optional<GreyBox> grey_box;            ///< none: the plant is G
  TransferFunction transfer_function;         ///< G; beside a grey box its linear form, see GreyBoxKind::linearised
  std::optional<StructureOptions> structure;  ///< the fitted one; its name is that of the model
  double input_bias = 0.0;                    ///< [input unit], switched on at t = 0; 0 beside a map
  double initial_output = 0.0;                ///< [output unit], a permanent offset
  /// Numerator of the decaying free response x(s) = sum_i c_i s^i / D(s), i = 0..; of a grey box its states. Empty for
  /// none.
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
