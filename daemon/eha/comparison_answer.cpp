// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/comparison_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/capitalised.hpp"
#include "daemon/eha/change_text.hpp"
#include "daemon/eha/compared_parts.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/change_causes.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/input_error.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

/// That the sensor's noise is another one, from row to row; empty where it is not shown. [output unit of the model]
std::string other_noise(const identify::Source& before, const identify::Source& after, const DisplayUnit& unit) {
  constexpr double kOther = 1.5;
  const std::string& length = before.record.output_channel.unit;
  if (length != after.record.output_channel.unit) return {};
  const auto noise_of = [&](const ident::Record& record) {
    const Eigen::VectorXd rows = record.output(Eigen::seq(0, Eigen::last, record.parts));
    return unit.factor(length) * ident::white_noise(rows);
  };
  const double from = noise_of(before.record);
  const double to = noise_of(after.record);
  if (!(std::min(from, to) > 0.0) || std::max(from, to) < kOther * std::min(from, to)) return {};
  return fmt::format(
      "the noise of the output from row to row changed by a factor of {}, from {:.3g} to {:.3g}{} (rms): look at the "
      "sensor, its wire and its shield",
      ident::figure_text(to / from), from, to, ident::after_number(unit.of(length)));
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

bool is_tight_by_sheet(const identify::Source& source) {
  return source.run_folder && record::sheet_says_beside(*source.run_folder) == ident::SheetSays::is_tight;
}

/// Builds the answer on runs that were compared with the first.
class RunsAnswer {
 public:
  RunsAnswer(const identify::RunComparison& comparison, const std::vector<identify::Source>& sources)
      : comparison_(comparison), sources_(sources) {
    std::vector<std::string> names;
    for (const identify::Source& source : sources) names.push_back(source.name);
    titles_ = report::titles_of(names);
  }

  [[nodiscard]] Compared made() {
    for (std::size_t i = 0; i < sources_.size(); ++i) add_run(i);
    look_for_a_leak();
    if (!leak_.empty()) found_ = "\n" + leak_ + "\n";
    for (std::size_t i = 1; i < sources_.size(); ++i) judge(i);
    put_together();
    say_what_to_do();
    out_.document = {{"schema", "eha-comparison/1"},
                     {"structure", comparison_.structure},
                     {"false_alarm", ident::kFalseAlarm},
                     {"runs", std::move(runs_)},
                     {"notes", comparison_.notes}};
    return std::move(out_);
  }

 private:
  void add_run(std::size_t i) {
    const identify::ComparedRun& run = comparison_.runs[i];
    const ident::Model& model = run.fit.model;
    const ident::Score& score = model.estimation->score;
    out_.models.emplace_back(titles_[i], &model);
    out_.subjects.push_back({.label = titles_[i],
                             .model = model,
                             .change = run.change,
                             .left_over = run.left_over,
                             .first_model_error = run.first_model_error,
                             .first_model_holds = i == 0 || identify::first_model_holds(run),
                             .time_s = run.fit.time_s,
                             .measured = run.fit.measured,
                             .simulated = run.fit.simulated,
                             .of_first_model = run.of_first_model});
    out_.subjects.back().input_range = input_range(sources_[i].record);
    out_.subjects.back().rig = for_a_page(access_of_record(sources_[i]));
    out_.text +=
        fmt::format("{} {}: {} fitted, R2 {} %, rms error {:.3g} {}, {} samples\n", i == 0 ? "before" : "after ",
                    of_rig(sources_[i]), model.name, ident::percent_text(score.r2_percent, 3), std::sqrt(score.mse),
                    model.output_unit, score.samples);
    Json entry{{"source", sources_[i].name}, {"model", Json::parse(ident::to_text(model))}};
    if (run.change) entry["change"] = change_json(*run.change, model);
    if (i > 0) {
      entry["left_over"] = {
          {"rms_before", run.left_over.before}, {"rms_after", run.left_over.after}, {"changed", run.left_over.changed}};
      entry["first_model"] = {{"rms_error", run.first_model_error}, {"holds", identify::first_model_holds(run)}};
    }
    if (run.unfit) entry["unfit"] = {{"source", sources_[run.unfit->is_first ? 0 : i].name}, {"why", run.unfit->why}};
    if (!run.cannot_tell.empty()) entry["cannot_tell"] = run.cannot_tell;
    if (run.sudden) {
      entry["error_jump"] = {{"source", sources_[run.sudden->is_first ? 0 : i].name},
                             {"time_s", run.sudden->jump.time_s},
                             {"change", run.sudden->jump.change}};
    }
    runs_.push_back(std::move(entry));
  }

  void look_for_a_leak() {
    std::vector<double> told_in_per_s;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const identify::Source& source = sources_[i];
      out_.findings.sentences.push_back(fmt::format("{}: {}.", i == 0 ? "Before" : "After", of_rig(source)));
      const auto seen = source.run_folder ? record::leak_beside(*source.run_folder) : std::nullopt;
      // Runs beside one sheet have one leak.
      if (!seen || std::find(told_in_per_s.begin(), told_in_per_s.end(), seen->creep_in_per_s) != told_in_per_s.end()) {
        continue;
      }
      told_in_per_s.push_back(seen->creep_in_per_s);
      const DisplayUnit unit(comparison_.runs.front().fit.model.output_unit);
      // The next step is for the rig that leaks; the other one may be sound.
      const std::string finding = titles_[i] + ": " + ident::leak_finding(*seen, unit);
      leak_ += (leak_.empty() ? "" : "\n") + with_commands(finding, sources_, {i});
      out_.findings.sentences.push_back(with_commands(finding, sources_, {i}, true));
    }
  }

  /// Judges a run beside the first.
  void judge(std::size_t i) {
    const identify::ComparedRun& run = comparison_.runs[i];
    const ident::PlantChange& change = *run.change;
    const ident::Model& model = run.fit.model;
    report::ComparedSubject& subject = out_.subjects[i];
    const report::ComparedSubject& first = out_.subjects.front();
    subject.unfit = run.unfit;
    subject.drift = run.drift;
    subject.cannot_tell = run.cannot_tell;
    if (subject.cannot_tell.empty() && (change.changed || !subject.first_model_holds) && run.has_other_input) {
      subject.has_other_input = true;
      subject.cannot_tell = fmt::format("the inputs differ, which alone can change {} of a plant that is not linear",
                                        change.changed ? "the parameters" : "the error of a model");
    }
    subject.judges_left_over = !run.has_other_input;
    subject.is_tight = is_tight_by_sheet(sources_.front()) && is_tight_by_sheet(sources_[i]);
    if (run.sudden) {
      subject.jumps = fmt::format("on {} the {}", titles_[run.sudden->is_first ? 0 : i],
                                  ident::jump_text(run.sudden->jump, model.output_unit));
      subject.cut_beside_jump = ident::cut_options(run.sudden->cut);
      subject.has_other_input = false;
      subject.cannot_tell = subject.jumps;
    }
    const std::string left_over = report::left_over_sentence(first, subject);
    const std::string holds = report::first_model_sentence(first, subject);
    // A leak that shifts null and dead band by less than they changed is not all of it.
    const bool explains = run.bent_map && run.bent_map->explains;
    if (!leak_.empty()) {
      subject.map_cause = run.bent_map && !explains ? report::MapCause::leak_and_valve : report::MapCause::leak;
    }
    const bool is_tight = explains && is_tight_by_sheet(sources_[run.bent_map->is_first ? 0 : i]);
    const bool is_bent_by_leak = explains && !is_tight && run.bent_map->appeared;
    if (explains && leak_.empty() && (is_tight || is_bent_by_leak)) {
      subject.map_cause = is_bent_by_leak ? report::MapCause::leak : report::MapCause::friction;
    }
    // Of two runs the first line says it.
    found_ += sources_.size() > 2 ? fmt::format("\n{}: {}\n", sources_[i].name, report::outcome(first, subject)) : "\n";
    if (subject.unfit) {
      out_.findings.sentences.push_back(report::unfit_sentence(first, subject));
      out_.findings.sentences.push_back(holds);
      found_ += fmt::format("  {}\n  {}\n", report::unfit_sentence(first, subject), holds);
      return;
    }
    if (!subject.cannot_tell.empty()) {
      found_ += fmt::format("  cannot tell: {}{}\n", subject.cannot_tell,
                            subject.has_other_input ? "; compare two runs of one experiment" : "");
      out_.findings.sentences.push_back(fmt::format("{}: cannot tell: {}.", titles_[i], subject.cannot_tell));
    }
    const Shows shows = subject.cannot_tell.empty() ? Shows::change : Shows::difference;
    found_ += with_commands(change_lines(change, model, shows), sources_, {i});
    add_changes(out_.findings.sentences, titles_[i], change, model, shows);
    if (subject.map_cause == report::MapCause::leak_and_valve && report::changes_valve(change)) {
      const std::string both = fmt::format(
          "a leak shifts null and dead band of such a fit by up to {:.2g} {}, and they changed by more: the valve is "
          "another one, too",
          run.bent_map->shift, model.input_unit);
      found_ += "  " + both + "\n";
      out_.findings.sentences.push_back(titles_[i] + ": " + both + ".");
    }
    if (explains && leak_.empty()) {
      const std::string bent = fmt::format(
          "on {} the rod moves within the dead band, {}: null and dead band of that fit may be up to {:.2g} {} off the "
          "valve's, so that {} and the valve may be the same; {}",
          titles_[run.bent_map->is_first ? 0 : i],
          is_tight ? "and by the valve sheet too slowly for a leak that explains it"
                   : "as where oil leaks past the piston",
          run.bent_map->shift, model.input_unit,
          is_bent_by_leak ? "a leak alone explains their change"
          : is_tight      ? "dry friction or another load alone explains their change"
                          : "friction or a leak alone may explain their change, where they are other ones now,",
          is_bent_by_leak
              ? "`eha characterise` of the rig shows the drift inside the dead band, and the valve's own null"
              : "two valve sheets (`eha characterise`) compare the valve alone");
      const std::vector<std::size_t> spoken_of =
          is_bent_by_leak ? std::vector{run.bent_map->is_first ? 0 : i} : std::vector<std::size_t>{0, i};
      found_ += "  " + with_commands(bent, sources_, spoken_of) + "\n";
      out_.findings.sentences.push_back(with_commands(capitalised(bent) + ".", sources_, spoken_of, true));
    }
    if (subject.left_over.changed && subject.judges_left_over) {
      found_ += "  " + left_over + "\n";
      out_.findings.sentences.push_back(titles_[i] + ": " + left_over);
    }
    subject.noise = other_noise(sources_.front(), sources_[i], DisplayUnit(model.output_unit));
    if (!subject.noise.empty()) {
      found_ += "  " + subject.noise + "\n";
      out_.findings.sentences.push_back(titles_[i] + ": " + subject.noise + ".");
    }
    if (const std::string cause = report::cause_sentence(subject); !cause.empty()) {
      // Of two runs it is what to do.
      if (out_.subjects.size() > 2) found_ += "  " + with_commands(cause, sources_, {i}) + "\n";
    }
    found_ += "  " + holds + "\n  " + report::tested_sentence(change, {&subject, 1}) + "\n" + table_of(first, subject);
    out_.findings.sentences.push_back(holds);
  }

  void put_together() {
    out_.findings.title =
        fmt::format("Comparison of {} and {}", titles_.front(),
                    titles_.size() == 2 ? titles_.back() : fmt::format("{} others", titles_.size() - 1));
    out_.findings.heading = report::outcome_of_all(out_.subjects);
    out_.findings.is_alike = std::all_of(out_.subjects.begin() + 1, out_.subjects.end(), report::is_alike);
    out_.text = out_.findings.heading + "\n" + out_.text + found_;
    if (const ident::PlantChange& change = *comparison_.runs[1].change; !out_.subjects[1].unfit) {
      out_.findings.sentences.push_back(report::tested_sentence(change, out_.subjects));
    }
    out_.findings.sentences.push_back(
        fmt::format("At most {:g} % false alarms for all parameters and runs together.", 100.0 * ident::kFalseAlarm));
    for (const std::string& note : comparison_.notes) out_.findings.sentences.push_back(note);
    const bool has_table =
        std::any_of(out_.subjects.begin() + 1, out_.subjects.end(), [](const auto& s) { return !s.unfit; });
    if (has_table) add_legend();
  }

  void add_legend() {
    out_.text += fmt::format(
        "joint +-: a difference within it is not shown to be a change; at most {:g} % false alarms for all parameters "
        "and runs together\n"
        "left over: what the model fitted to each record does not explain; a change from a factor of {:g} on\n"
        "of the first model: what it leaves over here beyond the known errors of its parameters and of a noisy input; "
        "it holds up to a factor of {:g} over the model fitted here\n"
        "{}: {}, alike for all records{}\n"
        "{}K/a0: gain at rest; T: time constant; K, b: gain; a: poles, in the denominator (eha(1))\n",
        100.0 * ident::kFalseAlarm, identify::kOtherLeftOver, ident::kGreatestErrorOverRefit, comparison_.structure,
        comparison_.structure == "io1" ? "one pole, no zero and a dead time (delay_s)"
        : comparison_.has_dead_time    ? "two poles, no zero and a dead time (delay_s)"
                                       : "two poles and no zero (gain K)",
        comparison_.structure == "io1" ? "" : "; a model of that name from `eha fit` may have a zero (gains b0, b1)",
        comparison_.runs.front().fit.model.input_map ? "null, dead_band, negative_gain_ratio: of the valve; " : "");
    if (comparison_.runs.front().fit.model.input_map) out_.text += fmt::format("{}\n", ident::kDeadBandIs);
  }

  void say_what_to_do() {
    std::vector<const ident::PlantChange*> changes;
    std::vector<std::size_t> changed;
    report::MapCause map_cause = report::MapCause::unknown;
    for (std::size_t i = 1; i < out_.subjects.size(); ++i) {
      const report::ComparedSubject& subject = out_.subjects[i];
      const bool is_claimed = subject.change && !subject.unfit && subject.cannot_tell.empty();
      if (!is_claimed || !subject.change->changed) continue;
      changes.push_back(&*subject.change);
      if (map_cause == report::MapCause::unknown) map_cause = subject.map_cause;
      changed.push_back(i);
    }
    add_to_do(out_, changes, changed.empty() ? 0 : changed.back(), report::kUntilKnown, map_cause,
              [&](const std::string& advice) { return with_commands(advice, sources_, changed); });
    // Where no parameter is shown to have changed: of the last run that differs.
    for (std::size_t i = out_.subjects.size() - 1; i > 0 && changes.empty(); --i) {
      const report::ComparedSubject& subject = out_.subjects[i];
      if (report::is_alike(subject) && sources_.size() > 2) continue;
      out_.text += "To do: " + wrapped(with_commands(report::to_do_of(subject), sources_, {i}), 7) + "\n";
      if (report::cause_sentence(subject).empty()) break;
      out_.changed_source = i;
      out_.changes_valve = !subject.is_tight;  // else its sheet is there
      break;
    }
  }

  const identify::RunComparison& comparison_;
  const std::vector<identify::Source>& sources_;
  std::vector<std::string> titles_ = {};
  Compared out_ = {};
  Json runs_ = Json::array();
  std::string leak_ = {};   ///< findings of the rigs that leak by their valve sheets, a line each
  std::string found_ = {};  ///< of each run, on the terminal
};

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

Compared described(const identify::RunComparison& comparison, const std::vector<identify::Source>& sources) {
  return RunsAnswer(comparison, sources).made();
}

}  // namespace eha::cli
