// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/comparison_answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/capitalised.hpp"
#include "daemon/eha/change_text.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/better_model.hpp"
#include "daemon/report/change_causes.hpp"
#include "ident/model/difference_text.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using ident::ParameterChange;

std::string table_of(const report::ComparedSubject& first, const report::ComparedSubject& subject,
                     Shows shows = Shows::change) {
  const ident::Model& model = subject.model;
  std::vector<std::vector<std::string>> rows;
  for (const ParameterChange& p : subject.change->parameters) {
    const ident::DifferenceText text = ident::difference_text(p.after - p.before, p.half_width);
    rows.push_back({p.name, ident::value_text(p.name, p.before, first.model, text.resolution),
                    ident::value_text(p.name, p.after, model, text.resolution), text.difference, text.half_width,
                    ident::unit_of(p, model), report::change_word(subject, p.changed)});
  }
  if (const identify::LeftOver& e = subject.left_over; e.before > 0.0) {
    rows.push_back({"left over, rms", fmt::format("{:.3g}", e.before), fmt::format("{:.3g}", e.after),
                    fmt::format("{:.3g}", e.after - e.before), fmt::format("x {:g}", identify::kOtherLeftOver),
                    model.output_unit, report::left_over_word(subject)});
    if (subject.first_model_error > 0.0) {
      rows.push_back({"of the first model", fmt::format("{:.3g}", e.before),
                      fmt::format("{:.3g}", subject.first_model_error),
                      fmt::format("{:.3g}", subject.first_model_error - e.before),
                      fmt::format("x {:g}", ident::kGreatestErrorOverRefit), model.output_unit,
                      report::first_model_word(subject)});
    }
  }
  return text_table({{"parameter"},
                     {"before", Align::right},
                     {"after", Align::right},
                     {"difference", Align::right},
                     {"joint +-", Align::right},
                     {"unit"},
                     {shows == Shows::change ? "changed" : "differs"}},
                    rows);
}
/// Adds what changed, beginning with the name of the run.
void add_changes(std::vector<std::string>& sentences, const std::string& name, const ident::PlantChange& change,
                 const ident::Model& model, Shows shows = Shows::change) {
  for (const ParameterChange& p : change.parameters) {
    if (p.changed) sentences.push_back(name + ": " + change_sentence(p, model, shows));
  }
  if (const std::string unit = ident::unit_instead(change); !unit.empty()) sentences.push_back(name + ": " + unit);
}

std::optional<std::pair<double, double>> input_range(const ident::Record& record) {
  if (record.input.size() == 0) return std::nullopt;
  return std::pair(record.input.minCoeff(), record.input.maxCoeff());
}

/// "runs/a on simulated rig": a record, and the rig of a run.
std::string of_rig(const identify::Source& source) {
  if (!source.run_folder) return source.name;
  const Json& other = record::read_manifest(*source.run_folder).other;
  const std::string rig = other.value(Json::json_pointer("/rig/name"), std::string());
  return source.name + (rig.empty() ? "" : " on " + rig);
}

suggest::RigAccess access_of_record(const identify::Source& source) {
  return source.run_folder ? access_of_run(*source.run_folder) : access_of_file();
}

/// The commands of a text that speaks of records, for their rig; of several rigs what the command measures, as one
/// command is for one rig. @param spoken_of  numbers of sources   @param for_page  with names that hold anywhere
std::string with_commands(const std::string& text, const std::vector<identify::Source>& sources,
                          const std::vector<std::size_t>& spoken_of, bool for_page = false) {
  constexpr std::string_view kCommand = "`eha characterise`";
  std::string whole;
  for (const std::size_t one : spoken_of) {
    const suggest::RigAccess rig = access_of_record(sources[one]);
    const std::string completed = suggest::completed(text, for_page ? for_a_page(rig) : rig);
    if (whole.empty()) whole = completed;
    if (completed == whole) continue;
    std::string named = text;
    for (std::size_t at = named.find(kCommand); at != std::string::npos; at = named.find(kCommand)) {
      named.replace(at, kCommand.size(), "a valve sheet of each rig");
    }
    return named;
  }
  return whole;
}

/// Says what to look at on the bench, where a parameter is shown to have changed.
/// @param source  the last one with a change   @param found  what explains another map
/// @param complete  makes the commands of the advice whole; none: for the rig of the console
void add_to_do(Compared& out, const std::vector<const ident::PlantChange*>& changes, std::size_t source,
               std::string_view then, report::MapCause found = report::MapCause::unknown,
               const std::function<std::string(const std::string&)>& complete = {}) {
  std::string advice = report::advice_on(changes, found, then);
  if (advice.empty()) return;
  if (complete) advice = complete(advice);
  out.text += "To do: " + wrapped(advice, 7) + "\n";
  out.changed_source = source;
  out.changes_valve =
      std::any_of(changes.begin(), changes.end(), [](const auto* change) { return report::changes_valve(*change); });
}

constexpr std::string_view kRejected = "rejected";
constexpr std::string_view kNoGrade = "-";

/// The verdict of the fit that made a model, as its file has it.
std::string grade_of(const ident::Model& model) {
  return std::string(model.verdict ? ident::verdict_word(*model.verdict) : kNoGrade);
}

std::string plant_of(const identify::ScoredModel& scored) {
  if (!scored.refit || !scored.cannot_tell.empty()) return "unknown";
  return scored.of_another_plant ? "another" : "this";
}

/// Whether two models, named without a record, are of one plant, and what differs.
std::string pair_text(const report::ComparedSubject& first, const report::ComparedSubject& subject,
                      bool is_one_record) {
  if (is_one_record) return "two models of one record, so of one plant";
  if (subject.change->parameters.empty())
    return "Not shown whether the plants differ: no parameter of both is estimated";
  if (first.model.name != subject.model.name) {
    return fmt::format("Not shown whether the plants differ: the structures do, {} and {}, and each has its own values",
                       first.model.name, subject.model.name);
  }
  return subject.change->changed ? report::outcome(first, subject)
                                 : "The same plant, as far as the models show: no parameter changed";
}

/// The models by their errors on the part of their one record that estimated none of them; none where these parts may
/// differ.
std::optional<std::vector<report::RankedModel>> ranked_on_unseen_data(const std::vector<ident::Model>& models,
                                                                      const std::vector<std::string>& titles) {
  const auto rows = [](const ident::Model& model) -> std::string {
    const bool is_known = model.validation && model.estimation && model.estimation->information;
    return is_known ? fmt::format("{} {}", model.estimation->information->record, model.validation->score.samples) : "";
  };
  std::vector<report::RankedModel> ranked;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const std::string known = rows(models[i]);
    if (known.empty() || known != rows(models.front())) return std::nullopt;
    ranked.push_back({.label = titles[i],
                      .rms_error = std::sqrt(models[i].validation->score.mse),
                      .parameters = report::estimated_parameters(models[i]),
                      .but = grade_of(models[i]) == kRejected ? std::string(kRejected) : ""});
  }
  return ranked;
}

/// "io_valve, usable, rms error 0.00213 in on the unseen data of its own record".
std::string fit_text(const ident::Model& model) {
  const std::string grade = grade_of(model);
  return model.name + (grade == kNoGrade ? "" : ", " + grade) +
         (model.validation ? fmt::format(", rms error {} on the unseen data of its own record",
                                         ident::error_text(std::sqrt(model.validation->score.mse), model.output_unit))
                           : "");
}

/// "Both models are of this record's plant".
std::string plants_text(const std::vector<identify::ScoredModel>& scored) {
  const auto all = static_cast<std::ptrdiff_t>(scored.size());
  const auto count = [&](std::string_view plant) {
    return std::count_if(scored.begin(), scored.end(), [&](const auto& one) { return plant_of(one) == plant; });
  };
  if (const auto others = count("another"); others > 0) {
    return all == 1 ? std::string("The model is of another plant than this record")
                    : fmt::format("{} of {} models {} of another plant than this record", others, all,
                                  others == 1 ? "is" : "are");
  }
  if (count("unknown") > 0) return "Not shown whether every model is of this record's plant";
  return all == 1   ? std::string("The model is of this record's plant")
         : all == 2 ? std::string("Both models are of this record's plant")
                    : fmt::format("All {} models are of this record's plant", all);
}

}  // namespace

identify::RunComparison converted(identify::RunComparison comparison, const DisplayUnit& unit) {
  for (identify::ComparedRun& run : comparison.runs) {
    const double factor = unit.factor(run.fit.model.output_unit);
    run.fit.model = in_unit(std::move(run.fit.model), unit);
    run.fit.measured *= factor;
    run.fit.simulated *= factor;
    if (run.change) run.change = in_output_unit(*run.change, factor);
    run.left_over.before *= factor;
    run.left_over.after *= factor;
    run.first_model_error *= factor;
    run.of_first_model.measured *= factor;
    run.of_first_model.simulated *= factor;
    if (run.sudden) run.sudden->jump.change *= factor;
  }
  return comparison;
}

identify::ScoredModel converted(identify::ScoredModel scored, const DisplayUnit& unit, const std::string& output_unit) {
  const double factor = unit.factor(output_unit);
  if (scored.validation.jump) scored.validation.jump->change *= factor;
  for (ident::Score* score :
       {&scored.validation.score,
        scored.validation.offset_reestimated ? &*scored.validation.offset_reestimated : nullptr}) {
    if (score == nullptr) continue;
    score->error_min *= factor;
    score->error_max *= factor;
  }
  scored.rms_error *= factor;
  scored.output.measured *= factor;
  scored.output.simulated *= factor;
  scored.refit_rms_error *= factor;
  if (scored.change) scored.change = in_output_unit(*scored.change, factor);
  return scored;
}

Compared described(const identify::RunComparison& comparison, const std::vector<identify::Source>& sources) {
  Compared out;
  std::vector<std::string> names;
  for (const identify::Source& source : sources) names.push_back(source.name);
  const std::vector<std::string> titles = report::titles_of(names);
  Json runs = Json::array();
  std::string leak;  ///< finding of the first rig that leaks by its valve sheet
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const identify::ComparedRun& run = comparison.runs[i];
    const ident::Model& model = run.fit.model;
    const ident::Score& score = model.estimation->score;
    out.models.emplace_back(titles[i], &model);
    out.subjects.push_back({.label = titles[i],
                            .model = model,
                            .change = run.change,
                            .left_over = run.left_over,
                            .first_model_error = run.first_model_error,
                            .first_model_holds = i == 0 || identify::first_model_holds(run),
                            .time_s = run.fit.time_s,
                            .measured = run.fit.measured,
                            .simulated = run.fit.simulated,
                            .of_first_model = run.of_first_model});
    out.subjects.back().input_range = input_range(sources[i].record);
    out.subjects.back().rig = for_a_page(access_of_record(sources[i]));
    out.text +=
        fmt::format("{} {}: {} fitted, R2 {} %, rms error {:.3g} {}, {} samples\n", i == 0 ? "before" : "after ",
                    of_rig(sources[i]), model.name, ident::percent_text(score.r2_percent, 3), std::sqrt(score.mse),
                    model.output_unit, score.samples);
    Json entry{{"source", sources[i].name}, {"model", Json::parse(ident::to_text(model))}};
    if (run.change) entry["change"] = change_json(*run.change, model);
    if (i > 0) {
      entry["left_over"] = {
          {"rms_before", run.left_over.before}, {"rms_after", run.left_over.after}, {"changed", run.left_over.changed}};
      entry["first_model"] = {{"rms_error", run.first_model_error}, {"holds", identify::first_model_holds(run)}};
    }
    if (run.unfit) entry["unfit"] = {{"source", sources[run.unfit->is_first ? 0 : i].name}, {"why", run.unfit->why}};
    if (!run.cannot_tell.empty()) entry["cannot_tell"] = run.cannot_tell;
    if (run.sudden) {
      entry["error_jump"] = {{"source", sources[run.sudden->is_first ? 0 : i].name},
                             {"time_s", run.sudden->jump.time_s},
                             {"change", run.sudden->jump.change}};
    }
    runs.push_back(std::move(entry));
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const identify::Source& source = sources[i];
    out.findings.sentences.push_back(fmt::format("{}: {}.", i == 0 ? "Before" : "After", of_rig(source)));
    if (!source.run_folder || !leak.empty()) continue;
    const auto found = record::leak_beside(*source.run_folder);
    if (!found) continue;
    const DisplayUnit unit(comparison.runs.front().fit.model.output_unit);
    // The next step is for the rig that leaks; the other one may be sound.
    const std::string finding = titles[i] + ": " + ident::leak_finding(*found, unit);
    leak = with_commands(finding, sources, {i});
    out.findings.sentences.push_back(with_commands(finding, sources, {i}, true));
  }
  std::string found = leak.empty() ? "" : "\n" + leak + "\n";
  const auto is_tight = [&](const identify::Source& source) {
    return source.run_folder && record::sheet_says_beside(*source.run_folder) == ident::SheetSays::is_tight;
  };
  for (std::size_t i = 1; i < sources.size(); ++i) {
    const identify::ComparedRun& run = comparison.runs[i];
    const ident::PlantChange& change = *run.change;
    const ident::Model& model = run.fit.model;
    report::ComparedSubject& subject = out.subjects[i];
    const report::ComparedSubject& first = out.subjects.front();
    subject.unfit = run.unfit;
    subject.cannot_tell = run.cannot_tell;
    if (subject.cannot_tell.empty() && (change.changed || !subject.first_model_holds) && run.has_other_input) {
      subject.has_other_input = true;
      subject.cannot_tell = fmt::format("the inputs differ, which alone can change {} of a plant that is not linear",
                                        change.changed ? "the parameters" : "the error of a model");
    }
    subject.judges_left_over = !run.has_other_input;
    subject.is_tight = is_tight(sources.front()) && is_tight(sources[i]);
    if (run.sudden) {
      subject.jumps = fmt::format("on {} the {}", titles[run.sudden->is_first ? 0 : i],
                                  ident::jump_text(run.sudden->jump, model.output_unit));
      subject.cut_beside_jump = ident::cut_options(run.sudden->cut);
      subject.has_other_input = false;
      subject.cannot_tell = subject.jumps;
    }
    const std::string left_over = report::left_over_sentence(first, subject);
    const std::string holds = report::first_model_sentence(first, subject);
    // A leak that shifts null and dead band by less than they changed is not all of it.
    const bool explains = run.bent_map && run.bent_map->explains;
    if (!leak.empty()) {
      subject.map_cause = run.bent_map && !explains ? report::MapCause::leak_and_valve : report::MapCause::leak;
    }
    const bool is_bent_by_leak = explains && !is_tight(sources[run.bent_map->is_first ? 0 : i]);
    if (explains && leak.empty()) {
      subject.map_cause = is_bent_by_leak ? report::MapCause::leak : report::MapCause::friction;
    }
    // Of two runs the first line says it.
    found += sources.size() > 2 ? fmt::format("\n{}: {}\n", sources[i].name, report::outcome(first, subject)) : "\n";
    if (subject.unfit) {
      out.findings.sentences.push_back(report::unfit_sentence(first, subject));
      out.findings.sentences.push_back(holds);
      found += fmt::format("  {}\n  {}\n", report::unfit_sentence(first, subject), holds);
      continue;
    }
    if (!subject.cannot_tell.empty()) {
      found += fmt::format("  cannot tell: {}{}\n", subject.cannot_tell,
                           subject.has_other_input ? "; compare two runs of one experiment" : "");
      out.findings.sentences.push_back(fmt::format("{}: cannot tell: {}.", titles[i], subject.cannot_tell));
    }
    const Shows shows = subject.cannot_tell.empty() ? Shows::change : Shows::difference;
    found += with_commands(change_sentences(change, model, shows), sources, {i});
    add_changes(out.findings.sentences, titles[i], change, model, shows);
    if (subject.map_cause == report::MapCause::leak_and_valve && report::changes_valve(change)) {
      const std::string both = fmt::format(
          "a leak shifts null and dead band of such a fit by up to {:.2g} {}, and they changed by more: the valve is "
          "another one, too",
          run.bent_map->shift, model.input_unit);
      found += "  " + both + "\n";
      out.findings.sentences.push_back(titles[i] + ": " + both + ".");
    }
    if (explains && leak.empty()) {
      const std::string bent = fmt::format(
          "on {} the rod moves within the dead band, {}: null and dead band of that fit may be up to {:.2g} {} off the "
          "valve's, so that {} alone explains their change and the valve may be the same; {}",
          titles[run.bent_map->is_first ? 0 : i],
          is_bent_by_leak ? "as where oil leaks past the piston" : "and by the valve sheet too slowly for a leak",
          run.bent_map->shift, model.input_unit, is_bent_by_leak ? "a leak" : "dry friction",
          is_bent_by_leak
              ? "`eha characterise` of the rig shows the drift inside the dead band, and the valve's own null"
              : "two valve sheets (`eha characterise`) compare the valve alone");
      const std::vector<std::size_t> spoken_of =
          is_bent_by_leak ? std::vector{run.bent_map->is_first ? 0 : i} : std::vector<std::size_t>{0, i};
      found += "  " + with_commands(bent, sources, spoken_of) + "\n";
      out.findings.sentences.push_back(with_commands(capitalised(bent) + ".", sources, spoken_of, true));
    }
    if (subject.left_over.changed && subject.judges_left_over) {
      found += "  " + left_over + "\n";
      out.findings.sentences.push_back(titles[i] + ": " + left_over);
    }
    if (const std::string cause = report::cause_sentence(subject); !cause.empty()) {
      // Of two runs it is what to do.
      if (out.subjects.size() > 2) found += "  " + with_commands(cause, sources, {i}) + "\n";
    }
    found += "  " + holds + "\n  " + report::tested_sentence(change) + "\n" + table_of(first, subject);
    out.findings.sentences.push_back(holds);
    if (i == 1) out.findings.sentences.push_back(report::tested_sentence(change));
  }
  out.findings.title = fmt::format("Comparison of {} and {}", titles.front(),
                                   titles.size() == 2 ? titles.back() : fmt::format("{} others", titles.size() - 1));
  out.findings.heading = report::outcome_of_all(out.subjects);
  out.findings.is_alike = std::all_of(out.subjects.begin() + 1, out.subjects.end(), report::is_alike);
  out.text = out.findings.heading + "\n" + out.text + found;
  out.findings.sentences.push_back(
      fmt::format("At most {:g} % false alarms for all parameters and runs together.", 100.0 * ident::kFalseAlarm));
  for (const std::string& note : comparison.notes) out.findings.sentences.push_back(note);
  const bool has_table =
      std::any_of(out.subjects.begin() + 1, out.subjects.end(), [](const auto& s) { return !s.unfit; });
  if (has_table) {
    out.text += fmt::format(
        "joint +-: a difference within it is not shown to be a change; at most {:g} % false alarms for all parameters "
        "and runs together\n"
        "left over: what the model fitted to each record does not explain; a change from a factor of {:g} on\n"
        "of the first model: what it leaves over here beyond the known errors of its parameters and of a noisy input; "
        "it holds up to a factor of {:g} over the model fitted here\n"
        "{}: {}, alike for all records{}\n"
        "{}K/a0: gain at rest; T: time constant; K, b: gain; a: poles, in the denominator (eha(1))\n",
        100.0 * ident::kFalseAlarm, identify::kOtherLeftOver, ident::kGreatestErrorOverRefit, comparison.structure,
        comparison.structure == "io1" ? "one pole, no zero and a dead time (delay_s)"
        : comparison.has_dead_time    ? "two poles, no zero and a dead time (delay_s)"
                                      : "two poles and no zero (gain K)",
        comparison.structure == "io1" ? "" : "; a model of that name from `eha fit` may have a zero (gains b0, b1)",
        comparison.runs.front().fit.model.input_map ? "null, dead_band, negative_gain_ratio: of the valve; " : "");
    if (comparison.runs.front().fit.model.input_map) out.text += fmt::format("{}\n", ident::kDeadBandIs);
  }
  std::vector<const ident::PlantChange*> changes;
  std::vector<std::size_t> changed;
  report::MapCause map_cause = report::MapCause::unknown;
  for (std::size_t i = 1; i < out.subjects.size(); ++i) {
    const report::ComparedSubject& subject = out.subjects[i];
    const bool is_claimed = subject.change && !subject.unfit && subject.cannot_tell.empty();
    if (!is_claimed || !subject.change->changed) continue;
    changes.push_back(&*subject.change);
    if (map_cause == report::MapCause::unknown) map_cause = subject.map_cause;
    changed.push_back(i);
  }
  add_to_do(out, changes, changed.empty() ? 0 : changed.back(), report::kUntilKnown, map_cause,
            [&](const std::string& advice) { return with_commands(advice, sources, changed); });
  // Where no parameter is shown to have changed: of the last run that differs.
  for (std::size_t i = out.subjects.size() - 1; i > 0 && changes.empty(); --i) {
    const report::ComparedSubject& subject = out.subjects[i];
    if (report::is_alike(subject) && sources.size() > 2) continue;
    out.text += "To do: " + wrapped(with_commands(report::to_do_of(subject), sources, {i}), 7) + "\n";
    if (report::cause_sentence(subject).empty()) break;
    out.changed_source = i;
    out.changes_valve = !subject.is_tight;  // else its sheet is there
    break;
  }
  out.document = {{"schema", "eha-comparison/1"},
                  {"structure", comparison.structure},
                  {"false_alarm", ident::kFalseAlarm},
                  {"runs", std::move(runs)},
                  {"notes", comparison.notes}};
  return out;
}

Compared described(const std::vector<identify::ScoredModel>& scored, const std::vector<ident::Model>& models,
                   const std::vector<std::string>& files, const identify::Source& source) {
  Compared out;
  std::vector<std::vector<std::string>> rows;
  Json entries = Json::array();
  std::string sentences;
  const std::vector<std::string> titles = report::titles_of(files);
  std::vector<std::string> rejected;
  std::vector<std::string> jumps;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const identify::ScoredModel& one = scored[i];
    const ident::Score best = one.validation.offset_reestimated.value_or(one.validation.score);
    out.models.emplace_back(titles[i], &models[i]);
    out.subjects.push_back({.label = titles[i],
                            .model = models[i],
                            .time_s = one.output.time_s,
                            .measured = one.output.measured,
                            .simulated = one.output.simulated});
    out.subjects.back().input_range = input_range(source.record);
    const std::string grade = grade_of(models[i]);
    if (grade == kRejected) rejected.push_back(titles[i]);
    out.findings.sentences.push_back(
        fmt::format("{}: {}R2 {} %, rms error {:.3g} {}; of {} plant", titles[i],
                    grade == kNoGrade ? "" : fmt::format("{} by the fit that made it; ", grade),
                    ident::percent_text(best.r2_percent), one.rms_error, models[i].output_unit,
                    plant_of(one) == "unknown" ? "an unknown" : plant_of(one)));
    if (one.of_another_plant) {
      out.findings.sentences.back() +=
          fmt::format(": its error is {:.1f} times that of its structure fitted to the record",
                      one.rms_error / one.refit_rms_error);
      add_changes(out.findings.sentences, titles[i], *one.change, models[i], Shows::change);
    }
    if (!one.cannot_tell.empty()) {
      out.findings.sentences.push_back(
          fmt::format("{}: cannot tell whether it is of this plant: {}", titles[i], one.cannot_tell));
    }
    rows.push_back({files[i], ident::percent_text(one.validation.score.r2_percent),
                    ident::percent_text(best.r2_percent), ident::percent_text(best.fit_percent),
                    fmt::format("{:.3g}", one.rms_error),
                    fmt::format("{:.3g}", std::max(std::abs(best.error_min), std::abs(best.error_max))),
                    one.refit ? fmt::format("{:.3g}", one.refit_rms_error) : "-", plant_of(one), grade});
    Json entry{{"file", files[i]},
               {"r2_percent", one.validation.score.r2_percent},
               {"r2_reestimated_percent", best.r2_percent},
               {"fit_percent", best.fit_percent},
               {"rms_error", one.rms_error},
               {"plant", plant_of(one)},
               {"grade", grade == kNoGrade ? Json(nullptr) : Json(grade)}};
    if (one.refit) entry["refit_rms_error"] = one.refit_rms_error;
    if (const auto& jump = one.validation.jump) {
      entry["error_jump"] = {{"time_s", jump->time_s}, {"change", jump->change}};
      jumps.push_back(fmt::format("with {} the {}", titles[i], ident::jump_text(*jump, models[i].output_unit)));
    }
    if (one.change) entry["change"] = change_json(*one.change, models[i]);
    entries.push_back(std::move(entry));
    if (!one.cannot_tell.empty()) {
      entries.back()["cannot_tell"] = one.cannot_tell;
      sentences += fmt::format("{}: cannot tell whether it is of this plant: {}\n", files[i], one.cannot_tell);
    }
    if (!one.of_another_plant) continue;
    sentences += fmt::format(
        "{}: a model of another plant, although it scores R2 {} %: its error is {:.1f} times that of its structure "
        "fitted to {}\n",
        files[i], ident::percent_text(best.r2_percent), one.rms_error / one.refit_rms_error, source.name);
    sentences += change_sentences(*one.change, models[i]);
  }
  out.findings.title = fmt::format("Models on {}", report::titles_of({source.name}).front());
  std::vector<const ident::PlantChange*> changes;
  for (const identify::ScoredModel& one : scored) {
    if (one.of_another_plant && one.change) changes.push_back(&*one.change);
  }
  const auto of_another =
      std::count_if(scored.begin(), scored.end(), [](const auto& one) { return one.of_another_plant; });
  const auto unknown =
      std::count_if(scored.begin(), scored.end(), [](const auto& one) { return plant_of(one) == "unknown"; });
  out.findings.heading = plants_text(scored);
  if (scored.size() > 1) {
    std::vector<report::RankedModel> ranked;
    for (std::size_t i = 0; i < models.size(); ++i) {
      ranked.push_back({.label = titles[i],
                        .rms_error = scored[i].rms_error,
                        .parameters = report::estimated_parameters(models[i]),
                        .but = grade_of(models[i]) == kRejected ? std::string(kRejected)
                               : scored[i].of_another_plant     ? "of another plant"
                                                                : ""});
    }
    out.findings.heading += "; " + report::better_model(std::move(ranked), models.front().output_unit);
  } else if (!rejected.empty()) {
    out.findings.heading += ", but it is rejected";
  }
  if (!jumps.empty()) {
    const std::string told =
        fmt::format("{}: {}; `eha validate` names the cut", fmt::join(jumps, ", "), ident::kMakesAJump);
    out.findings.heading += "; but " + told;
    out.findings.sentences.push_back(capitalised(told) + ".");
  }
  out.findings.is_alike = of_another == 0 && unknown == 0 && rejected.empty() && jumps.empty();
  out.findings.is_one_plant = of_another == 0 && unknown == 0;
  out.findings.sentences.emplace_back(
      "Scored on the whole record with the offset estimated again; the figures of a fit are of the part that did not "
      "estimate the model, so that they differ a little.");
  out.findings.is_one_record = true;
  if (of_another > 0) {
    out.findings.to_do =
        "Use no model of another plant for this record: fit one to it, or look for what changed since the "
        "model's own record. " +
        report::causes_of(changes);
  } else if (std::all_of(scored.begin(), scored.end(), [](const auto& one) { return plant_of(one) == "this"; }) &&
             !rejected.empty()) {
    out.findings.to_do = fmt::format(
        "Do not use {}, however small the error is here: `eha report` with the models' files says why, and recommends "
        "one.",
        fmt::join(rejected, ", "));
  }
  out.text = fmt::format("{}\non {}: {} samples\n", out.findings.heading, source.name,
                         scored.front().validation.score.samples);
  out.text += text_table({{"model"},
                          {"R2 %", Align::right},
                          {"re. R2 %", Align::right},
                          {"re. fit %", Align::right},
                          {"rms error", Align::right},
                          {"largest", Align::right},
                          {"refit rms", Align::right},
                          {"plant"},
                          {"verdict"}},
                         rows);
  out.text += fmt::format(
      "re.: offset re-estimated; errors [{}]; refit: the same structure fitted to this record; verdict: by the fit "
      "that made the model\n",
      models.front().output_unit);
  out.text += sentences;
  add_to_do(out, changes, 0, "Use no such model for this record: fit one to it.");
  out.document = {{"schema", "eha-comparison/1"}, {"source", source.name}, {"models", std::move(entries)}};
  return out;
}

Compared described(const std::vector<ident::Model>& models, const std::vector<std::string>& files) {
  Compared out;
  Json entries = Json::array();
  const double level = ident::kFalseAlarm / static_cast<double>(models.size() - 1);
  const std::vector<std::string> titles = report::titles_of(files);
  out.models.emplace_back(titles.front(), &models.front());
  out.subjects.push_back({.label = titles.front(), .model = models.front()});
  out.findings.title = "Comparison of models";
  out.findings.is_alike = true;
  std::vector<ident::PlantChange> changes;
  std::string found;
  for (std::size_t i = 1; i < models.size(); ++i) {
    const ident::PlantChange change = ident::without_other_units(
        ident::compare_parameters(models.front(), models[i], level), models.front(), models[i]);
    out.models.emplace_back(titles[i], &models[i]);
    out.subjects.push_back({.label = titles[i], .model = models[i], .change = change});
    out.findings.is_alike = out.findings.is_alike && !change.changed;
    const bool are_of_one_record = is_one_record(record_of(models.front()), record_of(models[i]));
    const bool tells_plants = !are_of_one_record && models.front().name == models[i].name;
    const Shows shows = tells_plants ? Shows::change : Shows::difference;
    const std::string says = pair_text(out.subjects.front(), out.subjects.back(), are_of_one_record);
    add_changes(out.findings.sentences, titles[i], change, models[i], shows);
    if (are_of_one_record) {
      out.findings.sentences.push_back(titles[i] +
                                       ": of the same record as the first, so it describes the same plant.");
    }
    if (i == 1) out.findings.heading = says;
    if (models.size() > 2) found += fmt::format("{} and {}: {}\n", titles.front(), titles[i], says);
    if (!change.parameters.empty() || !change.other_unit.empty()) found += change_sentences(change, models[i], shows);
    if (!change.parameters.empty()) found += table_of(out.subjects.front(), out.subjects.back(), shows);
    entries.push_back({{"file", files[i]}, {"change", change_json(change, models[i])}});
    if (tells_plants) changes.push_back(change);
  }
  out.findings.is_one_plant = std::all_of(models.begin() + 1, models.end(), [&](const ident::Model& model) {
    return is_one_record(record_of(models.front()), record_of(model));
  });
  if (out.findings.is_one_plant) {
    out.findings.heading = "Models of one record, so of one plant";
    if (const auto ranked = ranked_on_unseen_data(models, titles)) {
      out.findings.heading +=
          fmt::format("; on unseen data {}", report::better_model(*ranked, models.front().output_unit));
    }
  } else if (models.size() > 2) {
    out.findings.heading = out.findings.is_alike ? "No difference of a parameter found" : "The parameters differ";
  }
  out.text = out.findings.heading + "\n";
  for (std::size_t i = 0; i < files.size(); ++i) {
    out.text += fmt::format("{} {}: {}\n", i == 0 ? "before" : "after ", files[i], fit_text(models[i]));
  }
  out.text += found;
  std::vector<const ident::PlantChange*> changed;
  for (const ident::PlantChange& change : changes) changed.push_back(&change);
  if (const std::string advice = report::advice_on(changed, report::MapCause::unknown, report::kUntilKnown);
      !advice.empty()) {
    out.text += "To do: " + wrapped(advice, 7) + "\n";
  }
  out.text += "Which describes a record better: name the record, too (eha compare MODEL MODEL RECORD).\n";
  out.document = {{"schema", "eha-comparison/1"}, {"first", files.front()}, {"models", std::move(entries)}};
  return out;
}

}  // namespace eha::cli
