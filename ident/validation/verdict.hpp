// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/acceptance_limits.hpp"
#include "ident/model/model.hpp"
#include "ident/signal/measured_rows.hpp"

namespace eha::ident {

/// Of the rows, in gaps of kRowsOfGap rows or more. Chosen above the 0.2 % of a 50 s run that the loop's abort limits
/// allow.
inline constexpr double kMostInterpolated_percent = 1.0;

/// Of the rows, scattered ones as well, which are left out of the fit.
inline constexpr double kMostUnmeasured_percent = 10.0;

/// A validating residual above this many times the measured noise shows a part of the plant that the model lacks.
inline constexpr double kGreatestErrorOverNoise = 3.0;

/// From this many times the noise on the model is rejected, unless its fit is 95 %.
inline constexpr double kFarErrorOverNoise = 10.0;

/// A model whose parameters differ from those of its structure fitted to another record, and whose error there is more
/// than this many times the refit's, is of another plant, whatever its R2.
inline constexpr double kGreatestErrorOverRefit = 1.5;

/// An error on unseen data above this many times the estimating one lowers the grade, unless the fit there is 95 %.
inline constexpr double kGreatestErrorOverEstimating = 3.0;

/// A difference of AR-BIC from which on one model describes the record clearly better than another; "very strong" in
/// Kass and Raftery, JASA 90 (1995).
inline constexpr double kClearGain = 10.0;

/// Below this probability the test for nonlinear effects says that the plant is not linear.
inline constexpr double kNonlinearLevel = 0.002;

/// Share of the residual's power that past input makes, which the residual's test has to notice.
inline constexpr double kNoticedShare = 0.1;

/// Facts about a record in addition to its rows.
struct RecordFacts {
  Unmeasured unmeasured = {};  ///< rows of which a value was not measured
  /// Noise of a compared output sample, measured between periods of the record, as measured_noise() [output unit]; none
  /// for a record that does not repeat.
  std::optional<double> noise_std = {};
  /// Its excitation repeats, but the record holds too few periods to measure the noise from.
  bool lacks_periods = false;
  /// On a record that the model has not seen, the rms error over that of the structure fitted to it; none where no
  /// parameter differs.
  std::optional<double> error_over_refit = {};
  /// Length of a record whose estimating part is a piece of its slower motions [s], and the length that would do.
  struct Piece {
    double length_s = 0.0;
    double enough_s = 0.0;
    bool is_too_little = false;  ///< whatever the tests can judge: a small part of a run, or a record that stands still
  };
  std::optional<Piece> piece = {};
  double row_s = 0.0;               ///< time between the rows of input and output [s]; 0 where not known
  bool holds_both_parts = false;    ///< one part of it estimated the model, the other one validates it
  bool beside_ladder = false;       ///< every structure of the ladder is fitted to it too
  bool judging_part_rests = false;  ///< as in Verdict
  /// The recommended model of the same samples, where it is another one.
  struct Recommended {
    std::string name;
    double ar_bic_lower_by = 0.0;  ///< than that of the judged model
  };
  std::optional<Recommended> recommended = {};
  /// As in Verdict.
  std::string explained_by = {};
  std::optional<double> error_over_recommended = {};
};

/// Compares a fitted model with the experiment's limits and with the information in its own record.
/// Rejects for: a fit that did not converge; an R2 below or an error above its limit; a model of another plant; one
/// that is unstable or too near to it, a pole at 0 that its structure declares apart; a free order whose standard error
/// exceeds 0.15 or whose term costs less than 10 of AR-BIC to leave out; a free coefficient whose 95 % interval does
/// not exclude 0; an output at an end for more than 5 % of the samples; a valve map whose gain ratio is below -0.05,
/// which is no valve; a record too short for its slower motions on whose unseen part neither a missing part of the
/// plant nor the predicted error can be judged; an error of more than ten times the noise unless the fit is 95 %; a
/// record of which more than kMostUnmeasured_percent was not measured, or kMostInterpolated_percent in gaps or in rows
/// that the procedure does not leave out; an error that shows beside such gaps of an integrating rod, where a part
/// without them is to be had. A model that is not rejected is good when it passes the rest too, else
/// usable: each residual test at 1
/// %, no drift of the residual, no jump of the error, an AR-BIC at most kClearGain above that of the recommended model,
/// no nonlinear effect in it (0.2 %) and no correlation with the input that follows (0.1 %), no resonance above half
/// the Nyquist frequency, a predicted error on a fresh input of at most 5 %, no stay at an end stop and at most 1 % of
/// samples at which the output is at its limit and the model is not, a validating error (rms) of at most
/// kGreatestErrorOverNoise times the noise and, unless the fit is 99.9 %, of at most kGreatestErrorOverEstimating times
/// the estimating one, at most 5 % of the validating samples with an input beyond the estimating ones, and an input of
/// an excitation order no less than the parameters of G. A criterion that a short record does not determine is not
/// judged, and the model is usable: the residual tests that pass on too few samples to say something (see
/// kNoticedShare), or on an input that hardly moves (see answering_samples()), a predicted error whose interval holds 5
/// %, other amplitudes than those of an input of two levels, the noise of an excitation that repeats without two
/// periods. Where noise of the measured input makes what is left over (InputNoise), that is the criterion, and the
/// tests of the residual, the noise between periods and the error on unseen data are not judged, as they would see that
/// noise. Every criterion that applied is listed with value and limit; each that failed or was not judged has a
/// sentence, those of a rejection first. A model without validation (the whole record estimated) is judged by its
/// estimation figures, and usable; a sentence says so. Never throws on a model's content; a figure that is not finite
/// does not pass.
[[nodiscard]] Verdict judge(const Model& model, const AcceptanceLimits& limits, const RecordFacts& facts = {});

/// The validating samples that can show an answer of the plant: those behind a move of the input, as in ResidualTests.
[[nodiscard]] std::size_t answering_samples(const ValidationReport& validation);

/// Whether a residual test fails, or the record holds too little for it: the intervals of the parameters, which take
/// the structure for the plant's, then are least ones.
[[nodiscard]] bool may_miss_a_part(const Verdict& verdict);

/// Why a grade may puzzle beside that of another record: what this record's tests can see. Empty where they see neither
/// little nor much.
[[nodiscard]] std::string sight_of(const Model& model, const Verdict& verdict);

/// Whether a longer record would judge what this one is too short for.
[[nodiscard]] bool needs_longer_record(const Verdict& verdict);

/// The sentences of a verdict in the unit of the model's output: one for each criterion that failed or was not judged,
/// and notes. Those of a rejection first.
/// @param verdict  of this model; its stored sentences are not read
[[nodiscard]] std::vector<std::string> reasons_of(const Model& model, const Verdict& verdict);

/// What else failed, and has no sentence of its own as one of reasons_of() names the cause: "the input moves the error
/// (p = 0.0066)".
[[nodiscard]] std::vector<std::string> also_shown_in(const Model& model, const Verdict& verdict);

/// Whether a criterion of one of these kinds was judged and failed.
[[nodiscard]] bool fails_any(const Verdict& verdict, std::initializer_list<CriterionKind> kinds);

inline constexpr std::string_view kNotNeeded = "not needed";
inline constexpr std::string_view kNotDetermined = "undetermined";
inline constexpr std::string_view kOutdone = "outdone";
inline constexpr std::array<std::string_view, 3> kWordsBesideGrades{kOutdone, kNotNeeded, kNotDetermined};

/// What to do about white noise, after a semicolon.
inline constexpr std::string_view kAgainstNoise =
    "play a larger amplitude or filter the sensor; a longer record makes the parameters exact, but leaves the error";

/// A model describes a record as well as another if its rms error is at most this many times the other's.
inline constexpr double kAsWell = 1.5;

/// Samples at an end from which on the parameters are those of the end as well [%].
inline constexpr double kFarSaturated_percent = 5.0;

/// The verdict in one word for tables: its grade, but for an accepted model that the recommended one outdoes clearly
/// (CriterionKind::above_recommended) kOutdone, and for a rejected model that is wrong in nothing and describes the
/// record as well as the recommended one (kAsWell) kNotDetermined where the interval of a coefficient has no end, no
/// model is recommended, or that one errs far more (kAsWell squared), else kNotNeeded: the record hardly determines
/// parameters, or shows that it does without them.
[[nodiscard]] std::string_view verdict_word(const Verdict& verdict);

/// What a word of verdict_word() means that is not a grade; empty for a grade.
[[nodiscard]] std::string_view meaning_of(std::string_view verdict_word);

}  // namespace eha::ident
