// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <set>
#include <utility>

#include "daemon/identify/clipped_input_trial.hpp"
#include "daemon/identify/cross_validation.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "daemon/identify/input_trial.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/last_round.hpp"
#include "daemon/identify/moving_start.hpp"
#include "daemon/identify/one_sided_map.hpp"
#include "daemon/identify/record_part_remarks.hpp"
#include "daemon/identify/standing_output.hpp"
#include "daemon/identify/structure_trial.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/identify/trend.hpp"
#include "ident/estimation/inside_fits.hpp"
#include "ident/estimation/judging_part.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/validation/measured_noise.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr double kUsualFits = 20.0;  // of the ladder, for its progress

/// Fits one structure and measures the duration.
template <typename Fit>
ident::FitResult timed(const Fit& fit) {
  const auto begin = std::chrono::steady_clock::now();
  ident::FitResult result = fit();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  if (result.model.estimation) result.model.estimation->seconds = taken.count();
  return result;
}

/// "fitting io to 125000 of 5000000 rows"
std::string progress_text(const IdentificationTask& task, const std::string& structure) {
  const auto rows = static_cast<std::size_t>(task.record.input.size());
  const std::size_t compared = rows / static_cast<std::size_t>(std::max(1, task.options.decimation));
  return compared == rows ? fmt::format("fitting {} to {} rows", structure, rows)
                          : fmt::format("fitting {} to {} of {} rows", structure, compared, rows);
}

/// "io1                    fit  95.5 %   0.03 s", of the estimating part
std::string result_text(const ident::Model& model) {
  return fmt::format("{:<22} fit {:5.1f} %  {:5.2f} s\n", model.name, model.estimation->score.fit_percent,
                     model.estimation->seconds);
}

/// Whether the poles are guessed from the record so well that a search of their whole box finds no better ones: one or
/// two that are free, without a map.
bool has_guessed_poles(const ident::Structure& structure) {
  constexpr std::size_t kMostGuessed = 2;
  return !structure.input_map.valve && has_finite_state(structure) && state_count(structure) <= kMostGuessed &&
         structure.denominator.front().coefficient.freedom == ident::Freedom::free;
}

/// What fits of one record by the default procedure share.
struct Shared {
  ident::PreparedRecord prepared;
  ident::InsideFits inside;

  explicit Shared(const IdentificationTask& task)
      : prepared(task.record, task.options), inside(prepared, task.options, thread_executor()) {}
};

/// @param shared  null: the paper's procedure shares nothing
IdentifiedModel identify_one(const IdentificationTask& task, Shared* shared, const ident::StructureOptions& structure,
                             const ident::FitProgress& progress = {}) {
  const auto fitted = [&] {
    if (shared == nullptr) return ident::fit(task.record, structure, task.options, thread_executor(), {}, progress);
    ident::FitOptions options = task.options;
    if (options.search == ident::Search::global && has_guessed_poles(structure.structure))
      options.search = task.ladder.search;
    return ident::fit(shared->prepared, structure, options, thread_executor(), {}, progress, shared->inside);
  };
  IdentifiedModel identified{structure, timed(fitted)};
  judge(task, excited_by(task, identified.result), identified.result);
  return identified;
}

/// The structures of the paper, whose procedure has no ladder.
std::vector<ident::StructureOptions> published_structures() {
  ident::StructureOptions io;
  ident::StructureOptions fo;
  fo.name = "fo";
  fo.structure = ident::structures::fo();
  return {io, fo};
}

/// Climbs the ladder.
void climb(const IdentificationTask& task, const Progress& progress, Identification& identification) {
  const ident::PreparedRecord prepared(task.record, task.options);
  std::size_t fitted = 0;
  std::mutex showing;  // two structures may be fitted at the same time
  const auto show = [&](double done, const std::string& text) {
    if (progress) progress(std::min(1.0, done / kUsualFits), text);
  };
  const ident::FitStructure fit_structure = [&](const ident::StructureOptions& asked, const ident::FitOptions& options,
                                                const std::vector<ident::Model>& known) {
    {
      const std::scoped_lock lock(showing);
      show(static_cast<double>(fitted), progress_text(task, asked.name));
    }
    ident::FitResult result = timed([&] { return ident::fit(prepared, asked, options, thread_executor(), known); });
    const std::scoped_lock lock(showing);
    show(static_cast<double>(++fitted), result_text(result.model));
    return result;
  };
  ident::Climb climbed = ident::climb(prepared, task.ladder, task.options, {task.acceptance, facts_of(task)},
                                      fit_structure, thread_executor());
  // The same rows estimate every model.
  const auto excited = climbed.models.empty() ? std::nullopt : excited_by(task, climbed.models.front().result);
  for (ident::ClimbedModel& model : climbed.models) {
    judge(task, excited, model.result);
    identification.models.push_back({std::move(model.structure), std::move(model.result)});
  }
  identification.refused = std::move(climbed.refused);
  identification.work = std::move(climbed.work);
  // Takes account of the models' usable bands, which the ladder does not know.
  choose(task, identification);
}

/// Fits each structure of the task. Leaves out one that the record does not allow if another one can be fitted.
void fit_named(const IdentificationTask& task, const Progress& progress, Identification& identification) {
  std::exception_ptr first_failure;
  const double count = static_cast<double>(task.structures.size());
  std::optional<Shared> shared;
  if (task.options.procedure != ident::Procedure::paper) shared.emplace(task);
  for (std::size_t i = 0; i < task.structures.size(); ++i) {
    const ident::StructureOptions& structure = task.structures[i];
    ident::FitProgress of_one;
    if (progress) {
      of_one = [&](double share, const std::string& fitted) {
        progress((static_cast<double>(i) + share) / count, progress_text(task, fitted));
      };
    }
    try {
      identification.models.push_back(identify_one(task, shared ? &*shared : nullptr, structure, of_one));
      add(identification.work, identification.models.back().result.work);
      if (progress)
        progress(static_cast<double>(i + 1) / count, result_text(identification.models.back().result.model));
    } catch (const DataError& error) {
      if (!first_failure) first_failure = std::current_exception();
      identification.refused.push_back({structure.name, error.what()});
    }
  }
  if (identification.models.empty() && first_failure) std::rethrow_exception(first_failure);
  choose(task, identification);
}

bool any_accepted(const Identification& identification) {
  return std::any_of(identification.models.begin(), identification.models.end(), is_accepted);
}

/// Names a structure that the record does not allow once, and none that another start has fitted.
void keep_open_refusals(Identification& identification) {
  std::set<std::string> named;
  for (const IdentifiedModel& model : identification.models) named.insert(model.structure.name);
  std::erase_if(identification.refused,
                [&](const ident::Refusal& refusal) { return !named.insert(refusal.model).second; });
}

/// Fits the task's structures, or climbs the ladder.
Identification fit_once(const IdentificationTask& task, const Progress& progress) {
  Identification identification;
  try {
    if (task.structures.empty()) {
      climb(task, progress, identification);
    } else {
      fit_named(task, progress, identification);
    }
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", task.source_name, error.what()));
  }
  keep_open_refusals(identification);
  return identification;
}

/// Of two rounds with the same structures returns the models of lower estimation error: the estimation part decides.
void keep_closer(Identification& identification, Identification again, const IdentificationTask& task) {
  const auto error = [](const IdentifiedModel& identified) {
    const auto& estimation = identified.result.model.estimation;
    return estimation ? estimation->score.mse : std::numeric_limits<double>::infinity();
  };
  for (IdentifiedModel& other : again.models) {
    const auto same = std::find_if(identification.models.begin(), identification.models.end(),
                                   [&](const IdentifiedModel& m) { return m.structure.name == other.structure.name; });
    if (same != identification.models.end() && error(other) < error(*same)) *same = std::move(other);
  }
  choose(task, identification);
  add(identification.work, again.work);
}

/// Adds the accepted models of the ladder to the requested ones, which keep their names.
void add_climbed(Identification& identification, Identification climbed, const IdentificationTask& task) {
  for (IdentifiedModel& model : climbed.models) {
    const auto has_its_name = [&](const IdentifiedModel& m) { return m.structure.name == model.structure.name; };
    const bool is_there = std::any_of(identification.models.begin(), identification.models.end(), has_its_name);
    if (!is_there && is_accepted(model)) identification.models.push_back(std::move(model));
  }
  add(identification.work, climbed.work);
  for (ident::Refusal& refusal : climbed.refused) identification.refused.push_back(std::move(refusal));
  keep_open_refusals(identification);
  // The recommended one of all fitted models, unless its name is taken.
  identification.recommendation = std::move(climbed.recommendation);
  const auto is_recommended = [&](const IdentifiedModel& m) {
    return m.structure.name == identification.recommendation.model && is_accepted(m);
  };
  if (std::none_of(identification.models.begin(), identification.models.end(), is_recommended)) {
    choose(task, identification);
  }
}

/// Fits in rounds until a model is accepted.
Identification fit_in_rounds(const Source& source, IdentificationTask task, const Comparisons& comparisons,
                             const Progress& progress) {
  Identification identification = fit_once(task, progress);
  const auto end_round = [&](std::string what, std::string reason) {
    identification.rounds.push_back(
        {.what = std::move(what), .reason = std::move(reason), .accepted = any_accepted(identification)});
  };
  const bool is_ladder = task.structures.empty();
  end_round(is_ladder ? "the ladder of structures" : "the asked models", "");
  if (task.options.procedure == ident::Procedure::paper) return identification;
  if (identification.rounds.back().accepted) {
    add_longer_experiment(source, task, identification);
    return identification;
  }
  // Neither other starts nor a longer experiment move a rod off its end stop, mend a sensor or make rows quicker.
  if (!task.slow_rows.empty() || is_loop_noted(identification)) return identification;
  const ident::FirstStep first = next_step_of(identification).first;
  if (first != ident::FirstStep::none && first != ident::FirstStep::longer_record) return identification;

  // Which one comes nearest may be another one after them.
  std::string reason = ident::statement_of(identification.recommendation.reason);
  IdentificationTask other = task;
  ++other.options.seed;
  other.ladder.search = ident::Search::global;
  const Progress anew = progress_for(
      fmt::format("no model passes its checks: all are fitted again from other starts (seed {})", other.options.seed),
      "other starts", progress);
  keep_closer(identification, fit_once(other, anew), task);
  end_round(fmt::format("other starts (seed {})", other.options.seed), reason);
  if (!identification.rounds.back().accepted && !is_ladder && comparisons.ladder == Comparisons::Ladder::include) {
    reason = ident::statement_of(identification.recommendation.reason);
    task.structures.clear();
    const Progress ladder =
        progress_for("no asked model passes its checks: the ladder of structures is fitted", "the ladder", progress);
    add_climbed(identification, fit_once(task, ladder), task);
    end_round("the ladder of structures", reason);
  }
  if (identification.rounds.back().accepted) {
    add_longer_experiment(source, task, identification);
    return identification;
  }
  end_with_experiment(source, task, progress, identification);
  return identification;
}

/// Returns the structures to cross-validate: the requested ones; of the ladder the recommended one, io and fo.
std::vector<ident::StructureOptions> compared_structures(const IdentificationTask& task,
                                                         const Identification& identification) {
  if (!task.structures.empty()) return task.structures;
  std::vector<ident::StructureOptions> structures;
  for (const IdentifiedModel& identified : identification.models) {
    const std::string& name = identified.structure.name;
    if (name == identification.recommendation.model || name == "io" || name == "fo") {
      structures.push_back(identified.structure);
    }
  }
  return structures;
}

}  // namespace

ident::NextStep next_step_of(const Identification& identification) {
  std::vector<const ident::Model*> models;
  for (const IdentifiedModel& identified : identification.models) models.push_back(&identified.result.model);
  return ident::next_step(models, identification.recommendation.model);
}

IdentificationTask task_of(const Source& source) {
  IdentificationTask task{.record = source.record,
                          .source_name = source.name,
                          .command = source.command,
                          .guess = source.guess,
                          .record_sha256 = source.sha256,
                          .units = source.units,
                          .cut = source.cut,
                          .frozen = source.frozen,
                          .slow_rows = source.slow_rows,
                          .loop = source.loop,
                          .gaps = source.gaps,
                          .without_gaps = source.without_gaps,
                          .against_lost_rows = std::string(source.run_folder ? ident::kAgainstLateTicks : ""),
                          .within_dead_band = within_dead_band(source),
                          .at_command_limit = at_command_limit(source),
                          .unmeasured = source.unmeasured,
                          .repetition_samples = source.repetition_samples};
  if (source.experiment) {
    task.structures = source.experiment->models;
    task.options = source.experiment->fit;
    task.acceptance = source.experiment->acceptance;
  }
  return task;
}

const IdentifiedModel* recommended_model(const Identification& identification) {
  const auto at = std::find_if(
      identification.models.begin(), identification.models.end(),
      [&](const IdentifiedModel& one) { return one.result.model.name == identification.recommendation.model; });
  return at == identification.models.end() ? nullptr : &*at;
}

IdentificationTask with_record(const IdentificationTask& task, const ident::Record& record) {
  return {.record = record,
          .source_name = task.source_name,
          .command = task.command,
          .guess = task.guess,
          .record_sha256 = task.record_sha256,
          .units = task.units,
          .structures = task.structures,
          .ladder = task.ladder,
          .options = task.options,
          .acceptance = task.acceptance,
          .remarks = task.remarks,
          .cut = task.cut,
          .frozen = task.frozen,
          .slow_rows = task.slow_rows,
          .loop = task.loop,
          .gaps = task.gaps,
          .without_gaps = task.without_gaps,
          .against_lost_rows = task.against_lost_rows,
          .within_dead_band = task.within_dead_band,
          .at_command_limit = task.at_command_limit,
          .trend = task.trend,
          .unmeasured = task.unmeasured,
          .repetition_samples = task.repetition_samples,
          .excited = task.excited,
          .noise_std = task.noise_std,
          .lacks_periods = task.lacks_periods,
          .piece = task.piece,
          .is_split_given = task.is_split_given,
          .judging_part_rests = task.judging_part_rests,
          .intersample = task.intersample,
          .models_folder = task.models_folder};
}

Identification identify(const Source& source, const IdentificationTask& task, const Comparisons& comparisons,
                        const Progress& progress) {
  IdentificationTask named = task;
  const bool is_paper = task.options.procedure == ident::Procedure::paper;
  if (is_paper && named.structures.empty()) named.structures = published_structures();
  named.excited = excited_lines_of(source);
  named.remarks = source.remarks;
  if (!is_paper && ident::judging_part_rests(task.record, task.options)) {
    named.options.split = 1.0;
    named.judging_part_rests = true;
  }
  const bool has_map =
      named.structures.empty() || std::any_of(named.structures.begin(), named.structures.end(),
                                              [](const auto& s) { return s.structure.input_map.valve.has_value(); });
  const auto other = is_paper || !has_map || named.is_split_given || named.judging_part_rests
                         ? std::nullopt
                         : ident::covering_split(task.record, task.options);
  if (other) {
    named.options.split = other->share;
    named.remarks.push_back(other_split_remark(*other, task));
  }
  const auto piece = piece_remark(task);
  if (piece) {
    named.remarks.push_back(piece->sentence);
    named.piece = piece->piece;
  }
  const auto standing = named.judging_part_rests ? standing_output(task.record) : std::nullopt;
  if (standing) {
    named.remarks.push_back(standing->sentence);
    named.piece = standing->piece;
  }
  constexpr double kPartThatSays = 0.25;  // of what a run was to record, whose excitation is made for the whole
  const auto whole_s = planned_s(source);
  const double recorded_s = static_cast<double>(source.record.output.size()) * source.record.step_s;
  if (whole_s && recorded_s < kPartThatSays * *whole_s) {
    const double enough_s = std::max(kPartThatSays * *whole_s, named.piece ? named.piece->enough_s : 0.0);
    named.piece = ident::RecordFacts::Piece{recorded_s, enough_s, true};
  }
  std::vector<std::string> notes;
  auto frequency_response = frequency_response_of(source, task.options, notes);
  // Of several realisations each is another input: what differs between them is no noise, and the two or three periods
  // of one are no measure for what a model leaves over of the others.
  const bool is_one_input = !frequency_response || frequency_response->realisations == 1;
  if (frequency_response && is_one_input) {
    named.noise_std = ident::measured_noise(source.record.output, frequency_response->periods, task.options.decimation);
  }
  // A note gives the reason why a periodic excitation has no response.
  named.lacks_periods = is_one_input && named.noise_std.value_or(0.0) <= 0.0 && (frequency_response || !notes.empty());
  Identification identification = fit_in_rounds(source, named, comparisons, progress);
  const FitTask fit = [&](const IdentificationTask& other_task) {
    return fit_in_rounds(source, other_task, comparisons, progress);
  };
  const std::optional<WrongInput> wrong = wrong_input(source, named, identification, progress);
  // What a wrong input leaves over looks like a drift, friction or more poles.
  if (wrong) reject_for(*wrong, named, identification);
  const std::optional<WithoutTrend> straight = wrong ? std::nullopt : without_trend(named, identification, fit);
  if (straight) {
    identification = straight->identification;
    named.trend = straight->trend;
    named.remarks.push_back(straight->sentence);
  }
  IdentificationTask judged = straight ? with_record(named, straight->record) : named;
  std::string later = wrong ? std::string() : leave_out_moving_start(judged, identification, fit);
  if (!wrong && later.empty()) later = leave_out_resting_start(judged, identification, fit);
  if (!wrong) {
    hold_one_sided_maps(judged, identification);
    try_other_structures(judged, identification, progress);
  }
  if (const std::string clipped = wrong ? std::string() : may_be_clipped(source, judged, identification);
      !clipped.empty()) {
    for (IdentifiedModel& model : identification.models) add_remark(model.result.model, clipped);
    identification.warnings.push_back(clipped);
  }
  if (other) identification.warnings.push_back(other_split_remark(*other, task));
  if (piece) identification.warnings.push_back(piece->sentence);
  if (standing) identification.warnings.push_back(standing->sentence);
  if (straight) identification.warnings.push_back(straight->sentence);
  if (!later.empty()) identification.warnings.push_back(later);
  identification.frequency_response = std::move(frequency_response);
  (identification.frequency_response ? identification.response_notes : identification.notes) = std::move(notes);
  if (comparisons.paper == Comparisons::Paper::include) {
    IdentificationTask published = named;
    published.options = task.options;  // the procedure has its own halves, whatever part estimates here
    published.judging_part_rests = false;
    if (published.structures.empty()) published.structures = published_structures();
    identification.paper = fit_as_in_the_paper(published, identification.warnings);
  }
  if (comparisons.cross_validation == Comparisons::CrossValidation::include) {
    judged.structures = compared_structures(judged, identification);
    identification.cross_validation = cross_validate(judged, progress);
  }
  identification.fit_table = fit_table(judged.record, judged.options, identification.models);
  ident::FitOptions paper_options = task.options;
  paper_options.procedure = ident::Procedure::paper;
  identification.paper_fit_table = fit_table(task.record, paper_options, identification.paper);
  return identification;
}

std::vector<IdentifiedModel> fit_as_in_the_paper(IdentificationTask task, std::vector<std::string>& warnings) {
  if (task.options.procedure == ident::Procedure::paper) return {};
  task.options.procedure = ident::Procedure::paper;
  task.options.input_before.reset();
  std::vector<IdentifiedModel> models;
  for (const ident::StructureOptions& structure : task.structures) {
    const auto published = ident::published_structure(structure.structure);
    if (!published) continue;
    ident::StructureOptions plain;
    plain.name = structure.name;
    plain.structure = *published;
    try {
      models.push_back(identify_one(task, nullptr, plain));
    } catch (const Error& error) {
      warnings.push_back(
          fmt::format("no comparison with the paper's procedure for {}: {}", structure.name, error.what()));
    }
  }
  return models;
}

ident::Recommendation recommend(const std::vector<IdentifiedModel>& models, const IdentificationTask& task) {
  std::vector<const ident::Model*> all;
  for (const IdentifiedModel& identified : models) all.push_back(&identified.result.model);
  return ident::recommend(all, task.acceptance, task.unmeasured);
}

bool is_accepted(const IdentifiedModel& identified) {
  return identified.result.model.verdict && identified.result.model.verdict->accepted;
}

ExitCode exit_code(const std::vector<IdentifiedModel>& models) {
  if (std::any_of(models.begin(), models.end(), is_accepted)) return ExitCode::ok;
  const bool converged = std::any_of(models.begin(), models.end(), [](const IdentifiedModel& identified) {
    return identified.result.model.estimation && identified.result.model.estimation->converged;
  });
  return converged ? ExitCode::model_rejected : ExitCode::not_converged;
}

}  // namespace eha::identify
