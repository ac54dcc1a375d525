// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/identify/compared_records.hpp"
#include "daemon/identify/comparison_fits.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/record_units.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/identify/trend.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/uncertainty/usable_band.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr double kSameRows = 1e-6;
constexpr double kMostHidden_percent = 10.0;  // of the output's variance, left over beside plain noise

// Of what is left over, from which on nothing is certified where the inputs differ, too.
constexpr double kFarOtherLeftOver = 2.0;

/// Rms error of a model on a record, with its offset estimated again, beyond the errors that are known of its
/// parameters and of the record's input.
double error_on(const ident::Model& model, const Source& source, const ident::FitOptions& options) {
  const ident::ValidationReport report = ident::validate(model, source.record, options);
  if (report.tests && report.tests->rms_beyond_errors) return *report.tests->rms_beyond_errors;
  return std::sqrt(report.offset_reestimated.value_or(report.score).mse);
}

ident::Model with_report(ident::Model model, const ident::ValidationReport& own) {
  model.validation = own;
  return model;
}

/// How far null and dead band of a model may be off the valve's; none where its map fits its own record.
/// @param own  its validation on that record
std::optional<double> shift_on(const ident::Model& model, const ident::ValidationReport& own) {
  return ident::noted_shift(with_report(model, own));
}

/// A jump of the error of a model on its own record; none where there is none. @param step_s  of the compared samples
std::optional<ComparedRun::SuddenError> sudden_error(const ident::ValidationReport& own, double step_s, bool is_first) {
  if (!own.jump) return std::nullopt;
  return ComparedRun::SuddenError{*own.jump, ident::cut_beside(*own.jump, step_s), is_first};
}

/// Options by which every record is compared on samples of one step.
/// @throws DataError  the rows of two records do not allow that
std::vector<ident::FitOptions> of_one_step(const std::vector<Source>& sources, std::vector<std::string>& notes) {
  const Source& first = sources.front();
  const ident::FitOptions options = options_of(first);
  double step_s = options.decimation * first.record.step_s;
  for (const Source& source : sources) step_s = std::max(step_s, source.record.step_s);
  std::vector<ident::FitOptions> all;
  for (const Source& source : sources) {
    all.push_back(options);
    all.back().decimation = times(step_s, source.record.step_s);
    if (all.back().decimation == 0 || times(std::max(source.record.step_s, first.record.step_s),
                                            std::min(source.record.step_s, first.record.step_s)) == 0) {
      throw DataError(fmt::format(
          "{} has rows every {:g} s, {} every {:g} s, and the samples compared every {:g} s; expected steps "
          "that are whole multiples of one another",
          source.name, source.record.step_s, first.name, first.record.step_s, step_s));
    }
    if (std::abs(source.record.step_s - first.record.step_s) > kSameRows * first.record.step_s) {
      notes.push_back(fmt::format("{} has rows every {:g} s, {} every {:g} s; both are compared every {:g} s",
                                  source.name, source.record.step_s, first.name, first.record.step_s, step_s));
    }
  }
  return all;
}

LeftOver left_over(const ident::Model& before, const ident::Model& after) {
  LeftOver found{std::sqrt(before.estimation->score.mse), std::sqrt(after.estimation->score.mse)};
  const double least = std::min(found.before, found.after);
  found.changed = least > 0.0 && std::max(found.before, found.after) > kOtherLeftOver * least;
  return found;
}

/// How records about other levels of the output differ by that alone: stiffness of the oil and flow of a valve depend
/// on where the rod is. Empty where they are about one level.
std::string other_level(const Source& before, const Source& after) {
  constexpr double kApart = 0.15;  // of the lesser range
  const Eigen::VectorXd& a = before.record.output;
  const Eigen::VectorXd& b = after.record.output;
  const double range = std::min(a.maxCoeff() - a.minCoeff(), b.maxCoeff() - b.minCoeff());
  if (!(std::abs(b.mean() - a.mean()) > kApart * range)) return {};
  return fmt::format(
      "the records are about two places, {:.0f} % of the motion apart, which alone shifts the parameters of a cylinder "
      "a "
      "little",
      100.0 * std::abs(b.mean() - a.mean()) / range);
}

/// Whether more changed than another level makes: a parameter moved far, or null or dead band, which do not depend on
/// where the rod is, moved and the first model errs many times as much as the one fitted here; on the simulated rig
/// another place alone makes that 1.4 times.
bool is_beyond_other_level(const ComparedRun& run) {
  const bool errs_far_more = run.first_model_error > kHopeless * run.left_over.after;
  const std::vector<ident::ParameterChange>& all = run.change->parameters;
  return std::any_of(all.begin(), all.end(), [&](const ident::ParameterChange& p) {
    const bool is_far = std::abs(p.after - p.before) > kShiftByOtherInput * p.half_width;
    return p.changed && (is_far || (ident::is_of_dead_zone(p.role) && errs_far_more));
  });
}

bool has_negative_gain(const ident::Model& model) {
  const std::vector<ident::Term>& numerator = model.transfer_function.numerator;
  return !numerator.empty() && numerator.front().coefficient < 0.0;
}

/// Why a model by itself does not describe the record that it was fitted to; empty where it does.
std::string why_unfit(const ident::Model& model) {
  if (model.input_map && ident::is_one_way(*model.input_map)) {
    return "its map lets the input through in one direction only";
  }
  if (!model.verdict || ident::verdict_word(*model.verdict) != ident::text(ident::Grade::rejected)) return {};
  // What the record does not need tells less than what is wrong.
  ident::Verdict wrong = *model.verdict;
  std::erase_if(wrong.criteria, [](const ident::Criterion& c) {
    return c.kind == ident::CriterionKind::coefficient_interval || c.kind == ident::CriterionKind::order_error ||
           c.kind == ident::CriterionKind::left_out;
  });
  const std::vector<std::string> reasons = ident::reasons_of(model, wrong);
  std::string why = reasons.empty() ? "it is rejected" : ident::statement_of(reasons.front());
  why.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(why.front())));
  return why;
}

/// Whether a model leaves more of its own record over than it explains: beside it another one that is as bad does not
/// hold.
bool explains_little(const ident::Model& model) {
  constexpr double kLittle_percent = 50.0;  // of R2
  return !(model.estimation->score.r2_percent >= kLittle_percent);
}

/// Share of the output's variance [%] that a model leaves over beside plain noise: it may be a part of the plant, and
/// what changes there is not seen.
double hidden_percent(const ident::Model& model) {
  const double left = 100.0 - model.estimation->score.r2_percent;
  const double mse = model.estimation->score.mse;
  const double plain = model.estimation->noise && mse > 0.0 ? model.estimation->noise->variance / mse : 0.0;
  return left * std::max(0.0, 1.0 - plain);
}

/// Why two models of which neither is shown to differ certify nothing: one leaves so much over that a change may hide
/// there. None where both say enough.
std::optional<Unfit> hides_a_change(const ident::Model& before, const ident::Model& after) {
  const bool is_first = hidden_percent(before) >= hidden_percent(after);
  const ident::Model& poor = is_first ? before : after;
  if (!(hidden_percent(poor) > kMostHidden_percent)) return std::nullopt;
  return Unfit{is_first, fmt::format("it explains only {:.0f} % of that record, and a change may hide in the rest",
                                     poor.estimation->score.r2_percent)};
}

/// Of a map: the first record that does not determine the dead band or the gain behind it; none if all do.
std::optional<std::size_t> without_known_map(const std::vector<ComparedRun>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (const ident::ParameterEstimate& p : runs[i].fit.model.parameters) {
      const bool is_needed =
          p.role == ident::ParameterRole::dead_band || p.role == ident::ParameterRole::numerator_coefficient;
      if (is_needed && !p.fixed && !std::isfinite(p.std)) return i;
    }
  }
  return std::nullopt;
}

/// Whether an input is one step, from one level to another, or a single pulse back.
bool is_one_step(const Eigen::VectorXd& input) {
  constexpr double kMoves = 1e-3;  // of the range
  const double range = input.maxCoeff() - input.minCoeff();
  int moves = 0;
  for (Eigen::Index k = 1; k < input.size(); ++k) moves += std::abs(input[k] - input[k - 1]) > kMoves * range ? 1 : 0;
  return moves >= 1 && moves <= 2;
}

/// Makes a comparison claim nothing.
void claim_no_change(ident::PlantChange& change) {
  change.changed = false;
  for (ident::ParameterChange& p : change.parameters) p.changed = false;
}

}  // namespace

std::optional<Unfit> unfit_of(const ident::Model& before, const ident::Model& after) {
  if (const std::string why = why_unfit(before); !why.empty()) return Unfit{true, why};
  if (const std::string why = why_unfit(after); !why.empty()) return Unfit{false, why};
  const double worse = std::sqrt(after.estimation->score.mse / before.estimation->score.mse);
  const bool is_first = worse < 1.0;
  if (has_negative_gain(before) != has_negative_gain(after))
    return Unfit{is_first,
                 "its gain has the other sign, as with an input or output that is connected the other way round"};
  const double fit_percent = (is_first ? before : after).estimation->score.fit_percent;
  const double ratio = is_first ? 1.0 / worse : worse;
  if (ratio > kHopeless && fit_percent < kHopelessFit_percent) {
    return Unfit{is_first, fmt::format("its fit is {:.1f} %, and it errs {} times as much as the other one",
                                       fit_percent, ident::figure_text(ratio))};
  }
  return std::nullopt;
}

bool first_model_holds(const ComparedRun& run) {
  return !run.unfit && run.first_model_error <= ident::kGreatestErrorOverRefit * run.left_over.after;
}

namespace {

/// A model on the record that it was fitted to.
struct OnOwnRecord {
  ident::ValidationReport validation;
  double step_s = 0.0;  ///< of the compared samples
};

/// What changed from the first model to that of a run, by figures.
void measure_change(const ident::Model& before, ComparedRun& run, const Source& source,
                    const ident::FitOptions& options, double level) {
  run.first_model_error = error_on(before, source, options);
  run.of_first_model = ident::output_of(before, source.record, options);
  run.left_over = left_over(before, run.fit.model);
  run.change = ident::compare_parameters(before, run.fit.model, level);
}

/// Claims nothing where a model does not describe its own record.
void find_unfit(const ident::Model& before, ComparedRun& run) {
  const ident::Model& after = run.fit.model;
  if (explains_little(before) || explains_little(after) || !first_model_holds(run)) run.unfit = unfit_of(before, after);
  if (!run.unfit && !run.change->changed && first_model_holds(run)) run.unfit = hides_a_change(before, after);
  if (run.unfit) claim_no_change(*run.change);
}

/// Claims nothing where the error of a model jumps on its own record.
void take_back_for_a_jump(const OnOwnRecord& first, const OnOwnRecord& own, ComparedRun& run) {
  run.sudden = sudden_error(own.validation, own.step_s, false);
  if (!run.sudden) run.sudden = sudden_error(first.validation, first.step_s, true);
  if (!run.sudden) return;
  run.unfit.reset();
  claim_no_change(*run.change);
}

/// The shift of null and dead band that the poorer of two maps makes; none where both fit.
std::optional<ComparedRun::BentMap> bent_map(const ident::Model& first_model, const OnOwnRecord& first,
                                             const ComparedRun& run, const OnOwnRecord& own) {
  const std::optional<double> before = shift_on(first_model, first.validation);
  const std::optional<double> after = shift_on(run.fit.model, own.validation);
  const bool is_first = before && (!after || *before > *after);
  const std::optional<double>& greater = is_first ? before : after;
  if (!greater) return std::nullopt;
  constexpr double kAppeared = 2.0;
  const double least =
      ident::kShiftOverMapError * ident::reported_map_error(with_report(first_model, first.validation));
  return ComparedRun::BentMap{*greater, is_first, explains_valve(*greater, *run.change),
                              !is_first && *greater >= kAppeared * std::max(before.value_or(0.0), least)};
}

/// Beside another change, as of the load, a null or dead band that moved by no more than a poor map shifts it is within
/// its interval: the map's imperfection is a part of that. Where both are, nothing is left to be said of that map.
void widen_by_shift(ComparedRun& run) {
  ident::PlantChange& change = *run.change;
  if (!run.bent_map || ident::is_of_dead_zone_alone(change)) return;
  bool is_any_left = false;
  for (ident::ParameterChange& p : change.parameters) {
    if (!ident::is_of_dead_zone(p.role)) continue;
    ident::widen_to(change, p, run.bent_map->shift);
    is_any_left = is_any_left || p.changed;
  }
  if (!is_any_left) run.bent_map.reset();
}

/// Why records of different inputs tell nothing where far more is left over of one; empty where no more is.
std::string far_other_left_over(const ComparedRun& run, const Source& first, const Source& source) {
  const LeftOver& left = run.left_over;
  const double ratio = left.before > 0.0 ? left.after / left.before : 1.0;
  if (!(std::max(ratio, 1.0 / ratio) > kFarOtherLeftOver)) return {};
  const bool is_more = ratio > 1.0;
  return fmt::format(
      "what the model leaves over is {:.2g} times as much on {} as on {}: another input may make that, and a sensor "
      "that drifts, slips or freezes does",
      std::max(ratio, 1.0 / ratio), (is_more ? source : first).name, (is_more ? first : source).name);
}

/// Why straight models of records of two lengths tell nothing; empty where both are long enough.
std::string other_length(const ident::Model& before, const Source& first, const ident::Model& after,
                         const Source& source) {
  const double before_s = ident::compared_s(before);
  const double after_s = ident::compared_s(after);
  return too_short(std::min(before_s, after_s), std::max(before_s, after_s),
                   (after_s < before_s ? first : source).name);
}

RunComparison compared(const std::vector<Source>& sources, const Progress& progress) {
  const Source& first = sources.front();
  RunComparison comparison;
  const std::vector<ident::FitOptions> options = of_one_step(sources, comparison.notes);
  for (std::string& sentence : named_warnings(sources)) comparison.notes.push_back(std::move(sentence));
  ident::StructureOptions structure;
  structure.name = comparison.structure = "io_valve";
  structure.structure = ident::structures::behind_valve(ident::structures::io());
  std::string without_map;
  ComparisonFits fits(sources, options, progress);
  try {
    comparison.runs = fits.of(structure);
    if (const auto unknown = without_known_map(comparison.runs)) {
      without_map = fmt::format("{} does not determine one", sources[*unknown].name);
    }
  } catch (const DataError& error) {
    without_map = error.what();
  }
  if (!without_map.empty()) {
    structure.name = "io";
    structure.structure = ident::structures::io();
    comparison.runs = fits.of(structure);
  }
  auto with_dead_time = fits.with_dead_time(comparison.runs, structure);
  if (!with_dead_time.empty()) comparison.runs = std::move(with_dead_time);
  comparison.structure = structure.name;
  comparison.has_dead_time = structure.structure.delay.freedom == ident::Freedom::free;
  const bool are_plain = std::all_of(comparison.runs.begin(), comparison.runs.end(),
                                     [](const ComparedRun& run) { return ident::leaves_plain_noise(run.fit.model); });
  const bool are_steps = std::all_of(sources.begin(), sources.end(),
                                     [](const Source& source) { return is_one_step(source.record.input); });
  if (are_steps) {
    comparison.notes.push_back(
        "Each record has one step, which shows gain, time constant and dead time between its two levels; a dead band, "
        "a null or another gain at other levels shows only with an input of many levels in both records");
  } else if (!without_map.empty() && !(comparison.has_dead_time && are_plain)) {
    comparison.notes.push_back(fmt::format("Compared without a valve map: {}", without_map));
  }
  const double level = ident::kFalseAlarm / static_cast<double>(sources.size() - 1);
  std::vector<OnOwnRecord> own(sources.size());
  thread_executor()(sources.size(), [&](std::size_t i) {
    own[i] = {ident::validate(comparison.runs[i].fit.model, sources[i].record, options[i]),
              options.front().decimation * first.record.step_s};
  });
  for (std::size_t i = 1; i < comparison.runs.size(); ++i) {
    const ComparedRun& before = comparison.runs.front();
    ComparedRun& run = comparison.runs[i];
    measure_change(before.fit.model, run, sources[i], options[i], level);
    run.has_other_input = has_other_input(first.record, sources[i].record) &&
                          !holds_for_other_inputs(before.fit.model, run.fit.model, *run.change);
    if (run.has_other_input) {
      comparison.notes.push_back(
          fmt::format("{} and {} have different inputs; this alone can change the parameters of a nonlinear plant",
                      sources[i].name, first.name));
    }
    find_unfit(before.fit.model, run);
    take_back_for_a_jump(own.front(), own[i], run);
    if (structure.structure.input_map.valve) {
      run.bent_map = bent_map(before.fit.model, own.front(), run, own[i]);
      widen_by_shift(run);
      ident::widen_beside_other_changes(*run.change, !other_level(first, sources[i]).empty());
      const std::string level_differs = run.change->changed ? other_level(first, sources[i]) : "";
      if (!level_differs.empty() && is_beyond_other_level(run)) {
        comparison.notes.push_back(fmt::format("{} and {}: {}", first.name, sources[i].name, level_differs));
      } else if (!level_differs.empty()) {
        run.cannot_tell = level_differs + "; compare two runs about one place";
      }
    }
    if (run.cannot_tell.empty() && run.has_other_input) run.cannot_tell = far_other_left_over(run, first, sources[i]);
    if (run.cannot_tell.empty() && (!first.frozen.empty() || !sources[i].frozen.empty())) {
      run.cannot_tell = fmt::format("the sensor froze on {}; cut it as its warning says, and compare again",
                                    (first.frozen.empty() ? sources[i] : first).name);
    }
    if (!structure.structure.input_map.valve && run.cannot_tell.empty()) {
      run.cannot_tell = other_length(before.fit.model, first, run.fit.model, sources[i]);
    }
  }
  return comparison;
}

}  // namespace

RunComparison compare_runs(const std::vector<Source>& recorded, const Progress& progress) {
  std::vector<Source> sources = in_units_of_first(recorded);
  RunComparison comparison = compared(sources, progress);
  std::vector<std::string> drifts(sources.size());
  thread_executor()(sources.size(), [&](std::size_t i) {
    if (ident::leaves_plain_noise(comparison.runs[i].fit.model)) return;
    if (const std::string drift = take_trend_out(sources[i]); !drift.empty()) {
      drifts[i] = fmt::format("{}: {}", sources[i].name, drift);
    }
  });
  const auto is_any = [](const std::string& text) { return !text.empty(); };
  if (std::none_of(drifts.begin(), drifts.end(), is_any)) return comparison;
  comparison = compared(sources, progress);
  for (std::size_t i = 1; i < sources.size(); ++i) {
    comparison.runs[i].drift = drifts[i].empty() ? drifts.front() : drifts[i];
  }
  std::copy_if(drifts.begin(), drifts.end(), std::inserter(comparison.notes, comparison.notes.begin()), is_any);
  return comparison;
}

}  // namespace eha::identify
