// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/scored_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "daemon/identify/compared_records.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/identify/trend.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {
namespace {

constexpr double kMostBesideGain = 0.5;           // of the error, left over beside the gain that explains it
constexpr double kFollowsNothing_percent = 20.0;  // of R2
constexpr double kLessWithoutDrift = 0.7;         // of the error
constexpr double kFollows_percent = 80.0;         // the same, on the model's own record
constexpr double kFarError = 3.0;  // times the usual error: beyond what such a shift makes, 2.5 on the simulated rig

/// Rms error on the model's own record: what its structure leaves over of this plant. 0: not known.
double own_rms_error(const ident::Model& model) {
  if (model.validation) return std::sqrt(model.validation->score.mse);
  return model.estimation ? std::sqrt(model.estimation->score.mse) : 0.0;
}

double own_r2_percent(const ident::Model& model) {
  if (model.validation) return model.validation->score.r2_percent;
  return model.estimation ? model.estimation->score.r2_percent : 0.0;
}

/// Whether the record that estimated a model can be read and has another input; false where it cannot be read.
bool was_recorded_with_other_input(const ident::Model& model, const Source& source) {
  const auto record = model.provenance.find("record");
  if (record == model.provenance.end()) return false;
  try {
    return has_other_input(load_source(record->second, std::nullopt, {}).record, source.record);
  } catch (const Error&) {
    return false;
  }
}

/// Judges whether the model is of the record's plant, by its error and the parameters of its refit.
void judge_plant(ScoredModel& scored, const ident::Model& model, const Source& source) {
  const double usual = std::max(scored.refit_rms_error, own_rms_error(model));
  if (!(usual > 0.0)) {  // of an exact model
    scored.of_another_plant = scored.change->changed && scored.rms_error > 0.0;
    return;
  }
  const double ratio = scored.rms_error / usual;
  if (ratio > ident::kGreatestErrorOverRefit) {
    const ident::OtherGain gain = ident::other_gain(scored.output.measured, scored.output.simulated);
    if (gain.rms_error < kMostBesideGain * scored.rms_error) scored.other_gain = gain;
  }
  const ident::Score& score = scored.validation.offset_reestimated.value_or(scored.validation.score);
  // Of a plant that the structure itself does not fit every model of it errs as much as its refit.
  const bool follows_nothing = score.r2_percent < kFollowsNothing_percent && own_r2_percent(model) > kFollows_percent;
  const bool is_hopeless = follows_nothing || (ratio > kHopeless && score.fit_percent < kHopelessFit_percent);
  const auto moves_by = [&](double half_widths) {
    return std::any_of(scored.change->parameters.begin(), scored.change->parameters.end(),
                       [&](const ident::ParameterChange& p) {
                         return p.changed && std::abs(p.after - p.before) > half_widths * p.half_width;
                       });
  };
  const bool is_far = ratio > kFarError || !model.input_map;
  scored.of_another_plant =
      is_hopeless || (moves_by(is_far ? 1.0 : kShiftByExperiment) && ratio > ident::kGreatestErrorOverRefit);
  // Without a map a plant behind a valve is another straight one at other amplitudes, however far that is off.
  const bool is_beyond_inputs = model.input_map ? moves_by(kShiftByOtherInput)
                                                : holds_for_other_inputs(model, scored.refit->model, *scored.change);
  if (scored.of_another_plant && !is_beyond_inputs && was_recorded_with_other_input(model, source)) {
    scored.of_another_plant = false;
    scored.cannot_tell =
        "the inputs of this record and of the model's own differ, which alone can change the parameters of a plant "
        "that is not linear; record the model's experiment again and compare the two (`eha compare`)";
    return;
  }
  if (!scored.of_another_plant && scored.change->changed && ratio > ident::kGreatestErrorOverRefit) {
    scored.cannot_tell = fmt::format(
        "its error is {} times that on its own record, and parameters lie just outside their joint intervals, as "
        "other amplitudes or tones make them on an unchanged plant; record the model's experiment again and compare "
        "the two runs (`eha compare`)",
        ident::figure_text(ratio));
  } else if (!scored.of_another_plant && ratio > kFarError) {
    scored.is_doubtful = true;
    scored.cannot_tell = fmt::format(
        "its error is {} times that on its own record, yet no parameter of it is shown to differ: {}; fit a model to "
        "this record before you rely on one",
        ident::figure_text(ratio),
        scored.other_gain ? "another gain does that, which the intervals of several parameters together hide"
                          : "friction, a leak or a load do that, or a null that is off within its interval");
  }
}

void compare_with_refit(ScoredModel& scored, const ident::Model& model, const Source& source,
                        const ident::FitOptions& options, double level, const ident::FitProgress& progress) {
  if (!model.structure) return;
  try {
    scored.refit = ident::fit(source.record, *model.structure, options, thread_executor(), {}, progress);
  } catch (const DataError&) {
    return;  // the record cannot estimate this structure; the scores remain
  }
  scored.refit_rms_error = std::sqrt(scored.refit->model.estimation->score.mse);
  scored.change = ident::compare_parameters(model, scored.refit->model, level);
  judge_plant(scored, model, source);
  if (model.input_map) return;
  const std::string is_short = too_short(ident::compared_s(scored.refit->model), ident::compared_s(model),
                                         fmt::format("the record of {}", model.name));
  if (is_short.empty()) return;
  scored.cannot_tell = is_short;
  scored.is_doubtful = false;
  scored.of_another_plant = false;
}

ScoredModel scored_as_recorded(const ident::Model& model, const Source& source, const ident::FitOptions& options,
                               double level, const ident::FitProgress& progress) {
  ScoredModel one;
  one.validation = ident::validate(model, source.record, options);
  one.output = ident::output_of(model, source.record, options);
  one.rms_error = std::sqrt(one.validation.offset_reestimated.value_or(one.validation.score).mse);
  compare_with_refit(one, model, source, options, level, progress);
  return one;
}

/// What is left of an error's rms without the straight line that takes most of it.
double share_beside_line(const ident::OutputOfModel& of) {
  const Eigen::VectorXd error = (of.measured - of.simulated).array() - (of.measured - of.simulated).mean();
  const Eigen::VectorXd line = of.time_s.array() - of.time_s.mean();
  const double all = error.squaredNorm();
  const double slope = error.dot(line);
  return all > 0.0 ? std::sqrt(std::max(0.0, 1.0 - slope * slope / (line.squaredNorm() * all))) : 1.0;
}

/// Without the drift of the record, where the model errs clearly more than on its own record, and less without it.
ScoredModel scored(const ident::Model& model, const Source& source, const ident::FitOptions& options, double level,
                   const ident::FitProgress& progress) {
  ScoredModel one = scored_as_recorded(model, source, options, level, progress);
  if (!(one.rms_error > ident::kGreatestErrorOverRefit * own_rms_error(model))) return one;
  constexpr double kMargin = 1.1;  // the initial state may follow a line for a while
  if (share_beside_line(one.output) > kMargin * kLessWithoutDrift) return one;
  Source straight = source;
  std::string drift = take_trend_out(straight);
  if (drift.empty()) return one;
  ScoredModel other = scored_as_recorded(model, straight, options, level, progress);
  if (!(other.rms_error < kLessWithoutDrift * one.rms_error)) return one;
  other.drift = std::move(drift);
  return other;
}

/// What speaks against a model of less error would hide in that of the others.
void doubt_worse_ones(std::vector<ScoredModel>& all) {
  double least = std::numeric_limits<double>::infinity();
  for (const ScoredModel& one : all) {
    if (one.of_another_plant || one.is_doubtful) least = std::min(least, one.rms_error);
  }
  for (ScoredModel& one : all) {
    if (one.of_another_plant || one.rms_error < least) continue;
    one.is_doubtful = true;
    if (!one.cannot_tell.empty()) continue;
    one.cannot_tell =
        "a model that errs less here does not suit this record, and what speaks against that one would hide in the "
        "error of this one; fit a model to this record before you rely on one";
  }
}

}  // namespace

std::string other_gain_text(const ScoredModel& scored, double factor, const std::string& unit) {
  const double percent = 100.0 * (scored.other_gain->ratio - 1.0);
  return fmt::format(
      "a gain {:.2g} % {} alone takes the error from {:.3g} to {:.3g}{} rms: supply pressure, oil temperature, load or "
      "the sensor's scale change it",
      std::abs(percent), percent > 0.0 ? "greater" : "less", factor * scored.rms_error,
      factor * scored.other_gain->rms_error, unit);
}

std::vector<ScoredModel> score_models(const std::vector<ident::Model>& models, const Source& source,
                                      const Progress& progress) {
  return score_models(models, std::vector<const Source*>(models.size(), &source), progress);
}

std::vector<ScoredModel> score_models(const std::vector<ident::Model>& models,
                                      const std::vector<const Source*>& sources, const Progress& progress) {
  const double level = ident::kFalseAlarm / static_cast<double>(models.size());
  std::vector<ScoredModel> all;
  for (const ident::Model& model : models) {
    const Source& source = *sources[all.size()];
    all.push_back(
        scored(model, source, options_of(source), level, part_of(progress, all.size(), models.size(), source.name)));
  }
  doubt_worse_ones(all);
  return all;
}

ScoredModel score_model(const ident::Model& model, const Source& source, ident::FitOptions options,
                        const Progress& progress) {
  return scored(model, source, whole(options), ident::kFalseAlarm, part_of(progress, 0, 1, source.name));
}

}  // namespace eha::identify
