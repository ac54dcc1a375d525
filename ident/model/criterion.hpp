// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace eha::ident {

/// The quantity that a criterion of the verdict compares with a limit.
enum class CriterionKind : std::uint8_t {
  interpolated,
  unmeasured,
  converged,
  r2,
  max_abs_error,
  input_noise,   ///< share of the residual's power that the noise of the measured input makes
  between_rows,  ///< error of straight lines between the rows of the input, over the model's
  residual_input,
  residual_whiteness,
  nonlinearity,     ///< of the residual, see nonlinear_effects()
  future_input,     ///< correlation of the residual with the input that follows
  predicted_error,  ///< of the noise-free output of a fresh input of the same kind
  residual_drift,
  slow_pair,       ///< time constant of a zero and a pole over the record's length, see slow_pair_over_record()
  fast_resonance,  ///< frequency of a resonance that may be one above the Nyquist frequency [Hz]
  input_levels,    ///< distinct values of the record's input
  saturated,
  far_saturated,  ///< saturated, or on an end stop, in so many samples that the parameters are wrong
  jump,           ///< a sudden lasting change of the error
  far_jump,       ///< such a change in the rows that estimate, so great that the parameters are wrong
  extrapolated,
  wrong_input,  ///< the record's input column is not what the plant got (1), see identify::wrong_input()
  error_over_noise,
  far_error_over_noise,   ///< the same, with so great an error that the model is wrong
  error_over_refit,       ///< on another record: against the same structure fitted to it
  error_over_estimating,  ///< rms error on the validation part over that on the estimating one
  record_length,          ///< [s], of a record that is too short to judge the model on unseen data
  stability_margin,
  excitation_order,
  order_error,           ///< standard error of a free order
  left_out,              ///< rise of AR-BIC without an order's term
  coefficient_interval,  ///< distance of a coefficient's interval from 0
  above_recommended,     ///< AR-BIC less that of the recommended model, which is the parameter
  gain_ratio,            ///< of a valve map, its gain below the dead band over that above
  other,                 ///< of a file of another version; its name is the parameter
};

/// Effect of a failed criterion on the grade.
enum class CriterionWeight : std::uint8_t { rejects, lowers };

/// Unit of a criterion's value and limit.
enum class CriterionUnit : std::uint8_t { none, percent, radian, output };

/// Facts of a kind. Its name in files is `prefix`, the criterion's part or parameter, `suffix`.
struct CriterionTraits {
  CriterionKind kind = CriterionKind::other;
  std::string_view prefix = {};
  std::string_view suffix = {};
  CriterionUnit unit = CriterionUnit::none;
  CriterionWeight weight = CriterionWeight::lowers;
  std::string_view words = {};  ///< displayed name; a part or parameter follows
  std::string_view note = {};   ///< what is wrong where it failed; {parameter} and {value} stand for the criterion's
};

/// One comparison by which a model is judged.
struct Criterion {
  CriterionKind kind = CriterionKind::other;
  std::string parameter = {};  ///< "n2"; of r2 and max_abs_error the scored part, "validation" or "estimation"
  double value = 0.0;
  double limit = 0.0;
  bool passed = false;
  bool judged = true;  ///< false: the record does not suffice to judge it; then `value` may be NaN
};

/// Every kind, in the order in which a verdict lists them.
[[nodiscard]] std::span<const CriterionTraits> criterion_kinds();
[[nodiscard]] const CriterionTraits& traits_of(CriterionKind kind);

/// As model files and tables spell it: "validation_r2_percent", "std_n2".
[[nodiscard]] std::string name_of(const Criterion& criterion);

/// For people: "R2, validation", "standard error of an order, n2".
[[nodiscard]] std::string words_of(const Criterion& criterion);

/// What is wrong with a model that fails a criterion, in few words: "the input moves the error", "n2 may be 0".
[[nodiscard]] std::string note_of(const Criterion& criterion);

/// A criterion of a given name, without figures.
[[nodiscard]] Criterion criterion_named(std::string_view name);

/// Whether the criterion failed although the record suffices to judge it.
[[nodiscard]] inline bool has_failed(const Criterion& criterion) { return criterion.judged && !criterion.passed; }

}  // namespace eha::ident
