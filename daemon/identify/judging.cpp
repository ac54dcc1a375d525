// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/judging.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "core/time_text.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/uncertainty/usable_band.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/gain_change.hpp"
#include "ident/validation/loop_in_record.hpp"
#include "ident/validation/reasons.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr const char* kIntersample = "intersample";  // of the provenance
constexpr const char* kStraight = "straight";

/// "search 1 global, 9 local, 312 evaluations, 80 Jacobians, 1500 transforms; refine ..."
std::string work_text(const ident::WorkByStage& stages) {
  std::string text;
  for (const auto& [stage, work] : stages) {
    if (work == ident::Work{}) continue;
    text += fmt::format("{}{} {} global, {} local, {} evaluations, {} Jacobians, {} transforms",
                        text.empty() ? "" : "; ", stage, work.global_searches, work.local_searches, work.evaluations,
                        work.jacobians, work.transforms);
  }
  return text;
}

/// "2500 rows, 0.02 s apart, 50 s": those of the record, also where each was made into several.
std::string rows_text(const IdentificationTask& task) {
  const int parts = task.record.parts;
  const auto rows = static_cast<double>(task.record.output.size());
  return fmt::format("{:.0f} rows, {:.6g} s apart, {:.6g} s", std::ceil(rows / parts), task.record.step_s * parts,
                     task.record.step_s * rows);
}

/// Whether a cut leaves out the end stop or the jump that the model meets.
bool leaves_out(const importer::Cut& cut, const ident::Model& model) {
  if (cut.keeps_all() || !model.validation) return false;
  const auto& stop = model.validation->end_stop;
  const auto& jump = model.validation->jump;
  const bool is_clipped = model.validation->saturated_percent.value_or(0.0) > ident::kFarSaturated_percent;
  return (stop || jump || is_clipped) && (!stop || !cut.keeps(stop->from_s)) && (!jump || !cut.keeps(jump->time_s));
}

}  // namespace

ident::RecordFacts facts_of(const IdentificationTask& task) {
  return {.unmeasured = task.unmeasured,
          .noise_std = task.noise_std,
          .lacks_periods = task.lacks_periods,
          .piece = task.piece,
          .row_s = task.record.step_s * task.record.parts,
          .holds_both_parts = true,
          .beside_ladder = task.structures.empty(),
          .judging_part_rests = task.judging_part_rests};
}

std::optional<ident::FrequencyInterval> excited_lines_of(const Source& source) {
  const config::Played* played = source.experiment ? source.experiment->played() : nullptr;
  if (played == nullptr) return {};
  const auto samples = static_cast<std::size_t>(source.record.input.size());
  const std::size_t table = source.repetition_samples > 0 ? source.repetition_samples : samples;
  const std::vector<double> lines_Hz = ident::excited_lines(played->excitation, source.record.step_s, table);
  if (lines_Hz.empty()) return {};
  return ident::FrequencyInterval{lines_Hz.front(), lines_Hz.back()};
}

std::optional<ident::FrequencyInterval> excited_by(const IdentificationTask& task, const ident::FitResult& result) {
  if (task.excited) {
    // A run that ended early holds no whole period of the slowest tones.
    const double length_s = static_cast<double>(task.record.output.size()) * task.record.step_s;
    ident::FrequencyInterval band = *task.excited;
    band.lowest_Hz = std::max(band.lowest_Hz, 1.0 / length_s);
    return band.lowest_Hz <= band.highest_Hz ? std::optional(band) : std::nullopt;
  }
  const auto rows = static_cast<Eigen::Index>(result.estimation_samples);
  if (rows < 1 || result.time_s.size() < rows) return {};
  const double last = std::round((result.time_s[rows - 1] - task.record.start_s) / task.record.step_s);
  const auto band =
      ident::excited_band(task.record.input.head(static_cast<Eigen::Index>(last) + 1), task.record.step_s);
  // The place of a single tone is known to half a line; below a few of its periods it may be a step.
  constexpr double kFewestPeriods = 3.0;
  const bool is_band = band && (band->lowest_Hz < band->highest_Hz ||
                                band->lowest_Hz * (last + 1.0) * task.record.step_s >= kFewestPeriods);
  return is_band ? band : std::nullopt;
}

void note_loop(const ident::LoopInRecord& loop, ident::Model& model) {
  model.provenance[ident::kLoopOfRecord] = fmt::format("{:.2f}", loop.correlation);
}

/// A quiet loop biases no model that follows the record: it is noted where none does, and of models whose input seems
/// to have noise that did not reach the plant, as that came round the loop.
void note_quiet_loop(const IdentificationTask& task, Identification& identification) {
  constexpr double kFollowed_percent = 99.5;
  if (!task.loop || !task.loop->is_quiet) return;
  const bool is_followed =
      std::any_of(identification.models.begin(), identification.models.end(), [](const IdentifiedModel& one) {
        const auto& validation = one.result.model.validation;
        return validation && validation->score.r2_percent >= kFollowed_percent;
      });
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    if (!model.verdict) continue;
    if (is_followed && !ident::fails_any(*model.verdict, {ident::CriterionKind::input_noise})) continue;
    note_loop(*task.loop, model);
    const std::optional<ident::FrequencyInterval> band = model.verdict->usable_band;
    model.verdict = ident::judge(model, task.acceptance, facts_of(task));
    model.verdict->usable_band = band;
  }
}

void note_record(const IdentificationTask& task, ident::Model& model) {
  for (const char* key :
       {ident::kCutOfRecord, ident::kFrozenOfRecord, ident::kWithoutFrozen, ident::kGapsOfRecord, ident::kWithoutGaps,
        ident::kWithinDeadBand, ident::kAtCommandLimit, ident::kEffectOnOwnRecord, ident::kGainChanged,
        ident::kBesideGainChange, ident::kLongerPart, ident::kSlowRows, ident::kLoopOfRecord, ident::kOutputInInput,
        ident::kAgainstLostRows, ident::kWrongInput, ident::kMovedRows, ident::kAsSampled}) {
    model.provenance.erase(key);
  }
  ident::forget_explanation(model);
  if (!task.slow_rows.empty()) model.provenance[ident::kSlowRows] = task.slow_rows;
  if (task.loop && !task.loop->is_quiet) note_loop(*task.loop, model);
  constexpr double kMultiple = 0.95;
  if (model.validation && model.validation->score.r2_percent < ident::kNoAnswer_percent) {
    const double correlation = ident::same_row_correlation(task.record);
    if (std::abs(correlation) > kMultiple) model.provenance[ident::kOutputInInput] = fmt::format("{:.2f}", correlation);
  }
  if (leaves_out(task.cut, model)) model.provenance[ident::kCutOfRecord] = importer::cut_options(task.cut);
  if (!task.against_lost_rows.empty() && task.unmeasured.rows > 0) {
    model.provenance[ident::kAgainstLostRows] = task.against_lost_rows;
  }
  if (!task.within_dead_band.empty()) model.provenance[ident::kWithinDeadBand] = task.within_dead_band;
  if (!task.at_command_limit.empty()) model.provenance[ident::kAtCommandLimit] = task.at_command_limit;
  if (!task.frozen.empty()) {
    model.provenance[ident::kFrozenOfRecord] = task.frozen;
    if (!task.cut.keeps_all()) model.provenance[ident::kWithoutFrozen] = importer::cut_options(task.cut);
  }
  if (!task.gaps.empty()) {
    model.provenance[ident::kGapsOfRecord] = task.gaps;
    const importer::Cut& part = task.cut.keeps_all() ? task.without_gaps : task.cut;
    if (!part.keeps_all()) model.provenance[ident::kWithoutGaps] = importer::cut_options(part);
  }
}

namespace {

/// Of the parts beside a sudden change, the option that keeps the longer one.
void note_longer_part(const Eigen::VectorXd& time_s, double to_s, double from_s, ident::Model& model) {
  const bool is_first = to_s - time_s[0] >= time_s[time_s.size() - 1] - from_s;
  model.provenance[ident::kLongerPart] = is_first ? "--to " + time_text(to_s) : "--from " + time_text(from_s);
}

}  // namespace

void note_sudden_change(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured,
                        const Eigen::VectorXd& simulated, ident::Model& model) {
  if (!model.validation || model.validation->end_stop || time_s.size() < 2) return;
  if (const auto& jump = model.validation->jump) {
    const ident::CutBeside cut =
        ident::cut_beside(*jump, model.estimation ? model.estimation->compared_step_s : std::optional<double>());
    note_longer_part(time_s, cut.to_s, cut.from_s, model);
    return;
  }
  if (model.grey_box) return;
  const auto change = ident::gain_change(time_s, measured, simulated);
  if (!change) return;
  // It is known to a hundredth of the record.
  const double margin_s = 0.015 * (time_s[time_s.size() - 1] - time_s[0]);
  model.provenance[ident::kGainChanged] =
      fmt::format("at about {:.3g} s, by a factor of {:.2g}", change->time_s, change->ratio);
  model.provenance[ident::kBesideGainChange] =
      fmt::format("--to {:.3g} or --from {:.3g}", change->time_s - margin_s, change->time_s + margin_s);
  const auto in_digits = [](double seconds) { return std::stod(fmt::format("{:.3g}", seconds)); };
  note_longer_part(time_s, in_digits(change->time_s - margin_s), in_digits(change->time_s + margin_s), model);
}

namespace {

/// A record's name as the model keeps it: what the link `latest` led to.
std::string without_link(const std::string& name) {
  const std::filesystem::path path(name);
  std::error_code none;
  const std::filesystem::path target = std::filesystem::read_symlink(path, none);
  return target.empty() ? name : (target.is_absolute() ? target : path.parent_path() / target).string();
}

}  // namespace

void judge(const IdentificationTask& task, const std::optional<ident::FrequencyInterval>& excited,
           ident::FitResult& result) {
  ident::Model& model = result.model;
  note_record(task, model);
  if (task.piece && task.piece->is_too_little && model.validation) {
    // A sensor that slips ends a run at once; what a wrong model leaves over of the short piece jumps as well.
    model.validation->jump.reset();
  } else {
    note_sudden_change(result.time_s, result.measured, result.simulated, model);
  }
  model.verdict = ident::judge(model, task.acceptance, facts_of(task));
  if (excited) {
    model.verdict->usable_band = ident::usable_band(model, result.covariance, *excited, task.acceptance);
  }
  model.provenance["record"] = without_link(task.source_name);
  if (!task.record_sha256.empty()) model.provenance["record_sha256"] = task.record_sha256;
  model.provenance["record_rows"] = rows_text(task);
  // With both the same rows and columns can be read again.
  if (!task.command.empty()) model.provenance["command"] = task.command;
  if (!task.guess.empty()) model.provenance["read_as"] = task.guess;
  model.provenance["seed"] = fmt::format("{}", task.options.seed);
  model.provenance["decimation"] = fmt::format("{}", task.options.decimation);
  if (task.intersample == ident::Intersample::straight) {
    model.provenance[kIntersample] =
        fmt::format("{} (foh): {} rows for each of the record's", kStraight, ident::kPartsOfARow);
  }
  model.provenance["discard_s"] = fmt::format("{}", task.options.discard_s);
  model.provenance["split"] = fmt::format("{}", task.options.split);
  model.provenance["work"] = work_text(result.work);
  if (!task.trend.empty()) model.provenance["trend"] = task.trend;
  if (!task.remarks.empty()) model.provenance["remarks"] = fmt::format("{}", fmt::join(task.remarks, "\n"));
  model.provenance["software"] = fmt::format("eha {}", EHA_VERSION);
}

bool is_loop_noted(const Identification& identification) {
  return std::any_of(identification.models.begin(), identification.models.end(), [](const IdentifiedModel& one) {
    return one.result.model.provenance.contains(ident::kLoopOfRecord);
  });
}

void add_remark(ident::Model& model, const std::string& remark) {
  std::string& remarks = model.provenance["remarks"];
  remarks += (remarks.empty() ? "" : "\n") + remark;
}

ident::Intersample intersample_of(const ident::Model& model) {
  const auto told = model.provenance.find(kIntersample);
  const bool is_straight = told != model.provenance.end() && told->second.starts_with(kStraight);
  return is_straight ? ident::Intersample::straight : ident::Intersample::held;
}

void choose(const IdentificationTask& task, Identification& identification) {
  note_quiet_loop(task, identification);
  identification.recommendation = recommend(identification.models, task);
  const auto picked =
      std::find_if(identification.models.begin(), identification.models.end(), [&](const IdentifiedModel& m) {
        return m.structure.name == identification.recommendation.model && is_accepted(m);
      });
  if (picked == identification.models.end()) return;
  const ident::Model& best = picked->result.model;
  std::vector<const ident::Model*> models;
  for (const IdentifiedModel& identified : identification.models) models.push_back(&identified.result.model);
  std::map<const ident::Model*, std::string> explained_by;
  for (const ident::Model* model : models) {
    const ident::Model* other = ident::explaining(*model, models);
    // One that the recommended model outdoes is no advice.
    const bool is_outdone = other != nullptr && other != &best && ident::is_comparable(*other, best) &&
                            ident::ar_bic(*other) - ident::ar_bic(best) > ident::kClearGain;
    if (other != nullptr && !is_outdone) explained_by[model] = other->name;
  }
  for (IdentifiedModel& identified : identification.models) {
    ident::Model& model = identified.result.model;
    ident::RecordFacts facts = facts_of(task);
    facts.explained_by = explained_by[&model];
    const bool is_best = &model == &best;
    if (!is_best) facts.error_over_recommended = ident::error_over(model, best);
    if (!is_best && is_accepted(identified) && ident::is_comparable(model, best)) {
      facts.recommended = {best.name, ident::ar_bic(model) - ident::ar_bic(best)};
    }
    const std::optional<ident::FrequencyInterval> band = model.verdict->usable_band;
    model.verdict = ident::judge(model, task.acceptance, facts);
    model.verdict->usable_band = band;
    if (band && facts.recommended && facts.recommended->ar_bic_lower_by > ident::kClearGain &&
        model.input_map.has_value() == best.input_map.has_value()) {
      model.verdict->usable_band = ident::agreeing_band(model, best, *band, task.acceptance);
    }
  }
}

}  // namespace eha::identify
