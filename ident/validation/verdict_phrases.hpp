// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::ident {

// Parts of the sentences of a verdict.

/// Of a model whose record is too short to judge it, see needs_longer_record().
inline constexpr std::string_view kControllerIsAGuess =
    "a controller of this model is a guess until a trial has measured it (`eha track`)";

/// Before half a 95 % interval: the sign, or "SIGN at least" where the model may miss a part of the plant, whose effect
/// the interval does not hold. @param sign  "+-" or "±"
[[nodiscard]] std::string half_width_sign(const Model& model, std::string_view sign);

/// What the residual depends on, and what of a plant makes it do so.
[[nodiscard]] std::string effect_of(const NonlinearityTest& test);

/// The same of the test of a model, whose map may explain it. @pre the model has the test
[[nodiscard]] std::string effect_of(const Model& model);

/// Whether an effect of the input's level is that of a map's edges, which a leak or friction bends (noted_shift()):
/// beside them a gain that falls is no saturation.
[[nodiscard]] bool is_of_bent_edges(const Model& model, const NonlinearityTest& test);

/// "+-1.5 V", "0 and 2 V" or "2 V". @param unit  of the input
[[nodiscard]] std::string levels_text(const InputLevels& levels, const std::string& unit);

/// The 95 % interval, "0 to 0.62"; "unbounded", "unbounded below 3" or "unbounded above 1" where the record leaves an
/// end open.
[[nodiscard]] std::string interval_text(const ParameterEstimate& p);

/// Whether a grey box's parameter in the output's unit, such as the level of a tank, has no upper bound or lies so far
/// beyond the output's motion that the plant is linear for it.
[[nodiscard]] bool is_level_out_of_sight(const Model& model, const ParameterEstimate& p);

/// The provenance of a model that gives the cut of its record ("--to 29.99") in place of the model's own.
inline constexpr const char* kCutOfRecord = "cut";

/// The provenance of a model that says where the sensor of its record froze ("from 30 to 49.98 s").
inline constexpr const char* kFrozenOfRecord = "frozen";
inline constexpr const char* kWithoutFrozen = "without_frozen";  ///< and the options that keep the longest part without

/// The provenance of a model of a run that says what to do where its rows were not measured.
inline constexpr const char* kAgainstLostRows = "against_lost_rows";
inline constexpr std::string_view kAgainstLateTicks =
    "`eha doctor` and `eha latency --load` say what makes ticks late or loses them; then record again";

/// The provenance of a model that says where rows of its record were not measured ("from 42 to 42.29 s").
inline constexpr const char* kGapsOfRecord = "gaps";
inline constexpr const char* kWithoutGaps = "without_gaps";  ///< and the options that keep the longest part without one

/// The provenance of a model that says when the gain of its plant changed, and by how much ("at about 60 s, by a factor
/// of 1.4"), and the cuts beside it ("--to 58.8 or --from 61.2").
inline constexpr const char* kGainChanged = "gain_changed";
inline constexpr const char* kBesideGainChange = "beside_gain_change";

/// The provenance of a model of a record with a jump or a change of gain: the option that keeps the longer part beside
/// it ("--to 58.8").
inline constexpr const char* kLongerPart = "longer_part";

/// The provenance of a model whose record has rows that are too slow for its plant: what shows it, and what to do.
inline constexpr const char* kSlowRows = "slow_rows";

/// The provenance of a model of a record in closed loop: the correlation of loop_in_record().
inline constexpr const char* kLoopOfRecord = "loop";

/// The provenance of a model that follows nothing of a record whose input is a multiple of its output: the correlation
/// of the two in a row.
inline constexpr const char* kOutputInInput = "output_in_input";

/// The provenance of a model of a file whose input column is not what the plant got: what shows it, and what to do.
inline constexpr const char* kWrongInput = "wrong_input";

/// The provenance of a model of a file whose rows were moved to even times: how far, or, where they had been sampled at
/// such, what shows it; and the option that reads them so ("--period 0.01"), absent where they had not.
inline constexpr const char* kMovedRows = "moved_rows";
inline constexpr const char* kAsSampled = "as_sampled";

/// That a controller closes the loop, and what to do; empty where none is seen.
[[nodiscard]] std::string loop_in_record_of(const Model& model);

/// That the sensor froze, and the command that cuts that off; empty where it did not.
[[nodiscard]] std::string frozen_in_record(const Model& model);

/// The provenance of a model of a record whose input hardly leaves the valve's dead band: how far it went, and what
/// the dead band takes.
inline constexpr const char* kWithinDeadBand = "within_dead_band";

/// The provenance of a model of a run whose volts come near the rig's limit, so that larger ones have no room: how
/// near.
inline constexpr const char* kAtCommandLimit = "at_command_limit";

/// The provenance of a model whose residual speaks for a grey box that was fitted to the same record and holds: how
/// that errs beside the model ("errs 0.4 times as much"). Without it no grey box is advised.
inline constexpr const char* kGreyBoxHolds = "grey_box";

/// The provenance of a model judged on another record: the nonlinear effect that its own record shows, where the other
/// record shows another one. As effect_of().
inline constexpr const char* kEffectOnOwnRecord = "effect_on_own_record";

/// The criteria in which it shows that a rod was shifted within a gap.
inline constexpr std::initializer_list<CriterionKind> kShownBesideGaps = {CriterionKind::r2,
                                                                          CriterionKind::max_abs_error,
                                                                          CriterionKind::residual_input,
                                                                          CriterionKind::nonlinearity,
                                                                          CriterionKind::predicted_error,
                                                                          CriterionKind::residual_drift,
                                                                          CriterionKind::residual_whiteness};

/// What such gaps do, and the command that cuts them off; empty without any.
[[nodiscard]] std::string gaps_in_record(const Model& model);

/// What lies in the record and explains the other reasons, each with the command that cuts it off: a rod on its end
/// stop, a jump of the error.
[[nodiscard]] std::vector<std::string> causes_in_record(const Model& model);

/// What to look at where a sensor shows no motion, after a semicolon.
inline constexpr std::string_view kAgainstNoMotion =
    "look at the sensor, its wire and supply, at hydraulics and valve (on the rig `eha read` shows whether the reading "
    "follows the rod), and in a file at the columns (--input, --output)";

/// Whether rounding to the sensor's step makes most of what the model leaves over on the validation part.
[[nodiscard]] bool rounding_makes_most(const Model& model);

/// The statement of a reason, without what to do: up to its first semicolon, and without a point.
[[nodiscard]] std::string statement_of(const std::string& reason);

/// The same as a sentence without the probability that a reason has in brackets: "(p = 0.0066, lags up to 20)".
[[nodiscard]] std::string in_few_words(const std::string& reason);

}  // namespace eha::ident
