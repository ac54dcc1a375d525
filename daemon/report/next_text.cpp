// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/next_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/report/html.hpp"
#include "ident/estimation/fit_rows.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::report {
namespace {

using nlohmann::ordered_json;

/// `eha run` of the experiment that the fit wrote, as the run was played; empty where it wrote none.
std::string run_of_next_experiment(const Subject& subject) {
  const ordered_json& next = subject.part("identification", "next_experiment", "file");
  if (!next.is_string()) return {};
  const std::string file = next.get<std::string>();
  const std::string command = suggest::run(subject.access().value_or(suggest::RigAccess{}),
                                           {subject.folder.empty() ? file : subject.folder + "/" + file});
  return "`" + on_one_line(command) + "`";
}

/// The record that judges more: of a run that ended early its whole experiment, whose file run.json does not name.
std::string longer_record(const Subject& subject) {
  const ordered_json& outcome = subject.part("outcome");
  const bool ended_early = outcome == "faulted" || outcome == "interrupted" || outcome == "deadline";
  if (!subject.manifest || !ended_early) return "a longer record of the same kind";
  const std::string command = suggest::run(subject.access().value_or(suggest::RigAccess{}), {"EXPERIMENT.toml"});
  return fmt::format("`{}`, with the file of this experiment, to its end", on_one_line(command));
}

/// What stands before the use of the models, after "Next: "; empty where nothing does.
std::string first_step(const Subject& subject) {
  const ident::NextStep next = subject.next_step();
  switch (next.first) {
    case ident::FirstStep::look_at_sensor:
      if (subject.folder.empty()) {
        return "look at the sensor, its wire and supply, and at the columns of the file (--input, --output); then "
               "record again.";
      }
      return "`eha read` shows whether the reading follows the rod; once it does, record again.";
    case ident::FirstStep::mend_input:
      return "first mend the input column as said above; no figure of these models holds.";
    case ident::FirstStep::take_rows_as_even:
      return "first fit the rows as sampled evenly, as said above.";
    case ident::FirstStep::cut:
      if (next.cut_options.empty()) return "first cut the record as said above, and fit the part that is left.";
      return subject.folder.empty()
                 ? fmt::format("first the same `eha fit` with `{}`, the part of the record that shows the plant.",
                               next.cut_options)
                 : fmt::format("first `{}`, the part of the record that shows the plant.",
                               fmt::format("eha fit {} {}", folder_word(subject), next.cut_options));
    case ident::FirstStep::against_lost_rows:
      return std::string(ident::kAgainstLateTicks) + ".";
    case ident::FirstStep::smaller_amplitude:
      return "first record with smaller amplitudes, or nearer to mid-travel; a longer record would come to an end of "
             "the output as well.";
    case ident::FirstStep::longer_record: {
      const std::string run = run_of_next_experiment(subject);
      return fmt::format("first {}, as this one is too short to judge what is named above; {}.",
                         run.empty() ? longer_record(subject) : run, ident::kControllerIsAGuess);
    }
    case ident::FirstStep::none:
      break;
  }
  return {};
}

}  // namespace

bool has_tripped(const Subject& subject) { return subject.part("outcome") == "faulted"; }

std::string first_after_trial(const Subject& subject) {
  if (subject.leak) return ident::kRepairFirst;
  if (!subject.trial_changes.empty() || !subject.trial_stood.empty()) return ident::kMeasureFirst;
  return "correct what ended the trial, then play it again with `eha track`";
}

namespace {

/// That the rig file has not the valve of the newest sheet, with the command that mends it; empty where it has.
std::string unused_sheet(const Subject& subject) {
  const ordered_json& null_V = subject.part("rig", "following", "null_V");
  const ordered_json& dead_band_V = subject.part("rig", "following", "dead_band_V");
  if (!subject.sheet || subject.leak || !null_V.is_number() || !dead_band_V.is_number()) return {};
  const double known_null_V = null_V.get<double>();
  const double known_dead_band_V = std::max(0.0, dead_band_V.get<double>() - record::kSpareOfFollowing_V);
  if (subject.sheet->is_one_with(known_null_V, known_dead_band_V)) return {};
  return fmt::format(
      "`{}` writes a rig file with the null of {:.3f} V and the dead band of {:.3f} V of the newest valve sheet, of "
      "which the one in use has {:.3f} and {:.3f} V; put it into use",
      on_one_line(suggest::sheet_into_rig_file(*subject.access(), subject.sheet->run.string())),
      subject.sheet->zone.null_V, subject.sheet->zone.dead_band_V, known_null_V, known_dead_band_V);
}

/// The run of the newest valve sheet, where a controller of this model is to take its numbers; else empty.
std::string sheet_for(const Subject& subject, const ident::Model& model) {
  if (!subject.sheet) return {};
  const auto& map = model.input_map;
  if (map && !subject.sheet->is_one_with(map->null, map->dead_band)) return {};
  return subject.sheet->run.string();
}

}  // namespace

std::string against_end(const Subject& subject) {
  if (std::string unused = unused_sheet(subject); !unused.empty()) return unused;
  return subject.cause ? identify::remedy_of(*subject.cause) : "correct what ended the run";
}

std::string folder_word(const Subject& subject) {
  return subject.folder.empty() ? std::string("RUN") : on_one_line(shell_word(subject.folder));
}

std::string fit_of_part(const Subject& subject) {
  if (!subject.record || subject.is_constant()) return {};
  const ordered_json& record = subject.part("experiment", "record");
  const auto number = [&](const char* key, double otherwise) {
    const auto found = record.is_object() ? record.find(key) : record.end();
    return record.is_object() && found != record.end() && found->is_number() ? found->get<double>() : otherwise;
  };
  ident::FitOptions options;
  options.decimation = static_cast<int>(number("decimation", options.decimation));
  options.split = number("split", options.split);
  options.discard_s = number("discard_s", 0.0);
  try {
    static_cast<void>(ident::fit_rows(*subject.record, options));
    return "eha fit " + folder_word(subject);
  } catch (const DataError&) {  // too few rows are left
    return {};
  }
}

std::string next_steps(const Subject& subject, const ReportedModel& reported, bool has_changed) {
  std::string file = reported.file.empty() ? "MODEL.json" : reported.file;
  if (!reported.file.empty() && !subject.folder.empty()) file = subject.folder + "/" + file;
  file = on_one_line(shell_word(file));
  std::string text = "Next: ";
  std::string first = first_step(subject);
  if (has_tripped(subject)) {
    text += against_end(subject) + "; ";
    constexpr std::string_view kFirst = "first ";
    if (first.starts_with(kFirst)) first.replace(0, kFirst.size(), "then ");
  }
  if (subject.leak && reported.model.input_map) {
    text += std::string(ident::kRepairFirst) + "; ";
  } else if (has_changed) {
    text += "`eha characterise` measures the valve anew; before that no controller should rest on either. Then ";
  } else if (!first.empty()) {
    text += first + " Then ";
  } else if (subject.manifest && subject.sheet_says == ident::SheetSays::nothing && ident::map_shift(reported.model)) {
    text +=
        "`eha characterise` measures the valve, which this record does not show well enough for a controller. Then ";
  } else if (subject.manifest && !reported.model.grey_box) {
    text += fmt::format("`{}` makes a controller of it and says what the rod will do; ",
                        on_one_line(suggest::tune(*subject.access(), subject.folder.empty() ? "RUN" : subject.folder,
                                                  sheet_for(subject, reported.model))));
  }
  if (reported.model.grey_box) {
    return text + fmt::format(
                      "`eha simulate`, with {0} and another input, says what the plant does under it; `eha "
                      "validate`, with {0} and another record, scores the model there.",
                      file);
  }
  return text +
         fmt::format(
             "`eha export {} --format octave -o plant.m` writes it for another program; `eha validate`, with that "
             "file and another record, scores it there.",
             file);
}

std::string next_of_none(const Subject& subject) {
  if (const std::string first = first_step(subject); !first.empty()) return paragraph("Next: " + first);
  const std::string run = run_of_next_experiment(subject);
  if (run.empty()) return {};
  const ordered_json& reason = subject.part("identification", "next_experiment", "reason");
  return paragraph(fmt::format("Next: what the reasons ask for; {} plays the experiment that the fit wrote{}.", run,
                               reason.is_string() ? ": " + reason.get<std::string>() : std::string()));
}

}  // namespace eha::report
