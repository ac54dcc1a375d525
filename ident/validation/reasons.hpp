// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {

inline constexpr double kHardlyFollows_percent = 50.0;  ///< R2 below which other amplitudes are not the first thought
inline constexpr double kNoAnswer_percent = 20.0;       ///< R2 below which the input explains next to nothing

/// The sentences of a verdict: why it is not better, and what to do. Lives as long as model and verdict.
class Reasons {
 public:
  Reasons(const Model& model, const Verdict& verdict)
      : model_(model),
        verdict_(verdict),
        cause_(error_cause(model, verdict)),
        explanation_(explanation_of(model, verdict)) {}
  std::vector<std::string> all();
  /// The criteria that failed and have no sentence, as another one names their cause.
  [[nodiscard]] std::vector<Criterion> explained() const;

 private:
  /// The one statement about a sensor that shows nothing: each other one would be about its noise.
  [[nodiscard]] std::string no_motion() const;
  /// What is left over shows the sensor there, no plant: no statement on it.
  [[nodiscard]] std::vector<std::string> frozen();
  /// Whether a sentence before says what keeps the model from following.
  [[nodiscard]] bool is_cause_named() const;
  /// Whether a test of the residual failed.
  [[nodiscard]] bool shows_in_residual() const;
  /// Whether a controller closes the loop: what is left over is its, whatever it looks like.
  [[nodiscard]] bool is_in_loop() const;
  /// "The output answers within one row ..."
  [[nodiscard]] std::string slow_rows() const;
  /// Whether another sentence says what makes a criterion fail, or the criterion sees that alone.
  [[nodiscard]] bool is_explained(CriterionKind kind) const;
  /// Whether a part of the record that is none of the plant is named, which what is left over then shows.
  [[nodiscard]] bool is_cut_advised() const;
  /// "cut with --from 3 --to 8", the part that does not stand at an end and moves most.
  [[nodiscard]] std::string cut_of_record() const;
  /// What to do where rows were not measured. @param of_file  what helps in a file, but for recording again
  [[nodiscard]] std::string against_lost_rows(std::string_view of_file) const;
  /// "; beside the drift the plant is about K = 1.79 V/V; T = 0.492 s".
  [[nodiscard]] std::string beside_the_drift() const;
  /// ", or, as its own record has it, on the direction of motion, ..." where that shows another effect.
  [[nodiscard]] std::string effect_on_own_record() const;
  /// "fit the structure with dry friction (`eha fit --model friction`), which errs 0.4 times as much"; empty where no
  /// such fit is known to hold.
  [[nodiscard]] std::string better_grey_box() const;
  /// A map takes dry friction for a dead band.
  [[nodiscard]] std::string_view friction_in_the_map() const;
  void about(std::initializer_list<CriterionKind> kinds);
  /// What is wrong, the figure, what to do.
  [[nodiscard]] std::string failed(const Criterion& c) const;
  /// Whether the output answered to the input in the part that estimated.
  [[nodiscard]] bool answers_in_estimation() const;
  /// The same of a slow part of the error alone.
  [[nodiscard]] std::string wandering(const Criterion& c) const;
  /// Why R2 is low, by the cause of the error.
  [[nodiscard]] std::string low_r2(const Criterion& c) const;
  /// What the other structure that explains the error asks for.
  [[nodiscard]] std::string against_explanation() const;
  /// One width, the greater of the interval's and the one that the standard error gives.
  [[nodiscard]] std::string undetermined_order(const Criterion& c) const;
  /// The noise that differs between the record's periods, from the error in multiples of it; none where not measured.
  [[nodiscard]] std::optional<double> measured_noise() const;
  /// "record greater amplitudes, as ..." where the input hardly leaves the dead band; else empty.
  [[nodiscard]] std::string greater_amplitudes() const;
  /// Whether another sentence asks for smaller amplitudes: the output stands at an end, or the plant saturates.
  [[nodiscard]] bool asks_for_smaller_amplitudes() const;
  /// Whether time alone is what the model leaves over.
  [[nodiscard]] bool drifts_in_gain() const;
  /// Whether a model that comes to rest was fitted by itself without a dead time, which a heater or a pipe has: what is
  /// left over then follows the motion, as friction's does.
  [[nodiscard]] bool may_lack_dead_time() const;
  /// Whether the input determines fewer parameters than five poles and four zeros have.
  [[nodiscard]] bool tells_few_parameters() const;
  /// What may describe more of the plant.
  [[nodiscard]] std::string remedy() const;
  /// Whether a greater motion has less of the nonlinear effect: of dry friction, play or a dead band.
  [[nodiscard]] bool is_less_beside_larger_motions() const;
  /// The one advice on amplitudes: larger ones against friction, play and a dead band, unless there is no room; smaller
  /// ones against a gain that is curved alone; the valve measured where that is not known.
  [[nodiscard]] std::string advice_on_amplitudes() const;
  /// What helps against the nonlinear effect that a model shows.
  [[nodiscard]] std::string against_nonlinearity() const;
  /// "where an error of 0.012 in does not matter"
  [[nodiscard]] std::string where_it_matters() const;
  [[nodiscard]] std::string not_judged(const Criterion& c) const;
  /// Why a residual test that passes says little, and what to do.
  [[nodiscard]] std::string lacks_power() const;
  [[nodiscard]] bool is_judged(CriterionKind kind) const;
  /// Whether every criterion passed but that of the input's levels.
  [[nodiscard]] bool passes_the_rest() const;
  [[nodiscard]] std::string unstable(const Criterion& c) const;
  void note_flat_ridge();
  void note_low_r2();
  void note_allowed_instability();
  void note_wide_intervals();
  void note_cancelling_pair();
  [[nodiscard]] const ParameterEstimate* find(const std::string& name) const;
  /// "n2 = 1.75 +- 0.05"
  [[nodiscard]] std::string estimate(const std::string& name) const;
  const Model& model_;
  const Verdict& verdict_;
  const ErrorCause cause_;
  const std::optional<Explanation> explanation_;
  std::vector<std::string> rejections_;
  std::vector<std::string> notes_;
};

}  // namespace eha::ident
