// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/capitalised.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/change_text.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/simulated_start.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/identify/exchange_check.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/record_units.hpp"
#include "daemon/identify/scored_model.hpp"
#include "daemon/identify/silent_record.hpp"
#include "daemon/identify/size_hint.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/lags_note.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

constexpr const char* kValidateFooter = R"(
Scores a model on a record it has not seen: the verdict first, then the scores with its offset kept and with the offset
estimated anew, and the residual's correlations. SOURCE is a run folder or a file, as for `eha fit`; all of it after
--discard seconds is scored. A model that comes to rest begins at this record's own level. Input between rows: as the
model was estimated, or --intersample.
Fits the model's structure to the record as well, as `eha compare` does: a model whose parameters differ from that fit's
and whose error is more than 1.5 times its error, and that on its own record, is of another plant, and rejected.
Where the model errs more than on its own record and a straight line explains that, the line is taken out of the
record's output first, as `eha fit` does, and said.
Exit code 0: accepted; 3: rejected.

Examples:
  eha validate models/fo.json runs/latest
  eha validate models/io.json record.csv --decimate 40 --json)";

struct ValidateCommand {
  std::string model_file;
  std::string source;  ///< run folder or file with a record
  importer::Options import = {};
  std::optional<std::string> experiment_file = {};
  RecordOptions record;
};

std::string score_line(const char* what, const ident::Score& score, const ident::Model& model) {
  return fmt::format("  {:<20} R2 {} %  fit {} %  MSE {:.3g} {}^2  error {} .. {}\n", what,
                     ident::percent_text(score.r2_percent), ident::percent_text(score.fit_percent, 1), score.mse,
                     model.output_unit, ident::error_figure(score.error_min),
                     ident::error_text(score.error_max, model.output_unit));
}

std::string correlation_line(const char* what, const ident::Correlation& correlation, int first_lag) {
  double greatest = 0.0;
  std::size_t outside95 = 0;
  std::size_t outside99 = 0;
  std::size_t lags = 0;
  for (std::size_t i = 0; i < correlation.lags.size(); ++i) {
    if (correlation.lags[i] < first_lag) continue;
    const double value = std::abs(correlation.values[i]);
    greatest = std::max(greatest, value);
    outside95 += value > correlation.bound95 ? 1 : 0;
    outside99 += value > correlation.bound99 ? 1 : 0;
    ++lags;
  }
  return fmt::format(
      "{:<20} greatest {:.3f}; {} of {} lags outside the 95 % bound {:.3f} (by chance about {:.0f}), {} outside the "
      "99 % bound {:.3f}\n",
      what, greatest, outside95, lags, correlation.bound95, 0.05 * static_cast<double>(lags), outside99,
      correlation.bound99);
}

/// The `eha fit` that made a model, as its file says; empty where it does not.
std::string command_of(const ident::Model& model) {
  const auto command = model.provenance.find("command");
  return command == model.provenance.end() ? std::string() : command->second;
}

/// Says that the samples compared here are not of the step of those that estimated the model, which changes what the
/// tests see, and the command that compares alike.
/// @param step_s  between the samples compared here
void note_other_step(const ident::Model& model, const ValidateCommand& command, double step_s, int decimation,
                     const Console& console) {
  constexpr double kOther = 1.5;
  const double of_model_s = model.estimation ? model.estimation->compared_step_s.value_or(step_s) : step_s;
  if (std::max(of_model_s, step_s) < kOther * std::min(of_model_s, step_s)) return;
  const std::string found = fmt::format(
      "{} was estimated on samples every {:.4g} s and is scored on samples every {:.4g} s, so noise and tests differ",
      model.name, of_model_s, step_s);
  if (of_model_s > step_s) {
    const auto every = static_cast<int>(std::lround(decimation * of_model_s / step_s));
    console.info(
        fmt::format("{}; alike: `{}`", found,
                    importer::command_with(command.import, command.source, fmt::format("--decimate {}", every))));
  } else {
    const std::string record = record_of(model);
    console.info(fmt::format("{}; for a model of the longer step: `eha fit {}{} --decimate {} -o {}`", found,
                             record.empty() ? "RECORD" : shell_word(record),
                             importer::words_of_reading(command_of(model)),
                             static_cast<int>(std::lround(step_s / of_model_s)), shell_word(free_name("models"))));
  }
}

/// A model follows the record that it was fitted to, whatever it would do on another one.
void warn_of_own_record(const ident::Model& model, const std::string& source, const Console& console) {
  std::error_code not_there;
  const std::string record = record_of(model);
  if (record.empty() || !std::filesystem::equivalent(record, source, not_there)) return;
  console.warning(fmt::format(
      "{} was estimated on this record, which proves nothing of it: score it on a record that it has not seen",
      model.name));
}

/// The nonlinear effect that a model's own record shows, where another record shows another one; else empty.
std::string effect_beside(const ident::Model& model, const ident::ValidationReport& other) {
  const auto shown = [](const std::optional<ident::ValidationReport>& validation) {
    const auto test = validation && validation->tests ? validation->tests->nonlinearity : std::nullopt;
    return test && test->test.degrees > 0 && test->test.p < ident::kNonlinearLevel ? test : std::nullopt;
  };
  const auto own = shown(model.validation);
  const auto here = shown(other);
  if (!own || !here) return {};
  // A record that does not tell two effects apart names both: one of them may be that of the other record.
  const bool is_named = here->kind == own->kind || here->or_kind == own->kind || own->or_kind == here->kind;
  return is_named ? std::string() : ident::effect_of(model);
}

constexpr double kClearlyLess = 0.7;  // of the error

/// Whether a model errs more on a record than on the unseen data of its own, or that is not known.
bool errs_more_than_at_home(const ident::Model& model, const identify::ScoredModel& scored) {
  constexpr double kMore = 1.3;
  return !model.validation || !(scored.rms_error <= kMore * std::sqrt(model.validation->score.mse));
}

ExitCode execute(const ValidateCommand& command, Console& console) {
  ident::Model model = read_model(command.model_file);
  identify::Source source =
      identify::load_source(command.source, command.experiment_file, command.import, console.progress_callback());
  console.end_progress();
  suggest::RigAccess rig = source.run_folder ? access_of_run(*source.run_folder) : access_of_file();
  rig.fit = "eha fit " + shell_word(command.source) + importer::words_of_reading(command.import.command);
  console.set_rig(std::move(rig));
  const bool is_asked = command.record.intersample == ident::Intersample::straight;
  std::optional<identify::Source> other_way;  ///< the input between the rows as the model's was not
  if (!command.record.intersample && !source.run_folder) other_way = source;
  if (is_asked || (!source.run_folder &&
                   intersample_for(command.record.intersample, model, console) == ident::Intersample::straight)) {
    identify::take_input_as_straight(source);
  } else if (other_way) {
    identify::take_input_as_straight(*other_way);
  }
  print_import(source.guess, source.remarks, source.repairs, console);
  warn_of_own_record(command.model_file, source, console);
  if (const std::string same = identify::unit_taken_as_same(source, model); !same.empty()) console.warning(same);
  model = identify::in_units_of(source, std::move(model), command.model_file);
  const ident::FitOptions of_experiment = source.experiment ? source.experiment->fit : ident::FitOptions{};
  ident::FitOptions options = with(of_experiment, command.record, source.record.parts);
  const int decimation = options.decimation / source.record.parts;  // of the record's own rows
  const auto with_decimation = [&](int every) {
    return importer::command_with(command.import, command.source, fmt::format("--decimate {}", every));
  };
  if (const auto hint = identify::size_hint(source, decimation, with_decimation)) console.info(hint->sentence);
  warn_of_own_record(model, command.source, console);
  note_other_step(model, command, options.decimation * source.record.step_s, decimation, console);
  identify::ScoredModel scored_here;
  try {
    scored_here = identify::score_model(model, source, options, console.progress_callback());
    if (other_way && errs_more_than_at_home(model, scored_here)) {
      const ident::FitOptions others = with(of_experiment, command.record, other_way->record.parts);
      identify::ScoredModel scored = identify::score_model(model, *other_way, others, console.progress_callback());
      if (scored.rms_error < kClearlyLess * scored_here.rms_error) {
        const bool is_held = other_way->record.parts == 1;
        console.info(fmt::format(
            "{} errs {} times as much where the input of {} is {} between its rows, and so it is taken here "
            "(--intersample {}: as {})",
            model.name, ident::figure_text(scored.rms_error / scored_here.rms_error), command.source,
            is_held ? "held" : "straight", is_held ? "foh" : "zoh", is_held ? "straight" : "held"));
        scored_here = std::move(scored);
        source = std::move(*other_way);
        options = others;
      }
    }
    console.end_progress();
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", command.model_file, error.what()));
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", command.source, error.what()));
  }
  if (!scored_here.drift.empty()) console.warning(scored_here.drift);
  const ident::ValidationReport& validation = scored_here.validation;
  // One statement of one model: what its own record shows is said with what this one does.
  const bool beside_ladder = model.verdict && model.verdict->beside_ladder;
  const std::string own_effect = effect_beside(model, validation);
  if (!model.stability) model.stability = ident::stability(model.transfer_function);
  model.validation = validation;
  identify::note_record(identify::task_of(source), model);
  const ident::OutputOfModel& output = scored_here.output;
  if (!scored_here.of_another_plant) {
    identify::note_sudden_change(output.time_s, output.measured, output.simulated, model);
  }
  if (!own_effect.empty()) model.provenance[ident::kEffectOnOwnRecord] = own_effect;
  // Another record starts at another position, so the model's offset does not apply to it.
  ident::Model judged = model;
  if (validation.offset_reestimated) judged.validation->score = *validation.offset_reestimated;
  const ident::AcceptanceLimits limits = source.experiment ? source.experiment->acceptance : ident::AcceptanceLimits{};
  // The band belongs to the record that the model was estimated on.
  const auto band = model.verdict ? model.verdict->usable_band : std::nullopt;
  ident::RecordFacts facts{.unmeasured = source.unmeasured, .row_s = source.record.step_s * source.record.parts};
  facts.beside_ladder = beside_ladder;
  const bool can_tell = scored_here.cannot_tell.empty();
  if (can_tell && scored_here.of_another_plant && scored_here.refit_rms_error > 0.0) {
    facts.error_over_refit = scored_here.rms_error / scored_here.refit_rms_error;
  }
  model.verdict = ident::judge(judged, limits, facts);
  model.verdict->usable_band = band;

  // Of an output that stands at an end its verdict says no such thing.
  const bool is_another =
      scored_here.of_another_plant && ident::fails_any(*model.verdict, {ident::CriterionKind::error_over_refit});
  const auto exchanged = model.verdict->accepted ? std::nullopt : identify::exchanged_fit(source, options, scored_here);

  const double shown_factor = console.unit(source.units).factor(model.output_unit);
  const std::string shown_unit = ident::after_number(console.unit(source.units).of(model.output_unit));
  const std::string silent = model.verdict->accepted || exchanged
                                 ? std::string()
                                 : identify::why_silent(model, source.record, scored_here, shown_factor, shown_unit);

  nlohmann::ordered_json document{{"schema", "eha-validation/1"}, {"source", command.source}};
  document["model"] = nlohmann::ordered_json::parse(ident::to_text(model));
  if (scored_here.refit) document["refit_rms_error"] = scored_here.refit_rms_error;
  if (scored_here.change) document["change"] = change_json(*scored_here.change, model);
  if (exchanged) document["exchanged"] = {{"model", exchanged->name}, {"r2_percent", exchanged->r2_percent}};
  if (!silent.empty()) document["cannot_judge"] = silent;
  if (!scored_here.drift.empty()) document["drift"] = scored_here.drift;
  if (!can_tell) document["cannot_tell"] = scored_here.cannot_tell;
  const auto& gain = scored_here.other_gain;
  if (gain) document["other_gain"] = {{"ratio", gain->ratio}, {"rms_error", gain->rms_error}};
  console.print_json(document);

  const ident::Model shown = in_unit(model, console.unit(source.units));
  const ident::ValidationReport& scored = *shown.validation;
  // The verdict first, then what it rests on.
  std::string text = fmt::format("{} on {}: {}\n", model.name, command.source,
                                 can_tell || exchanged ? std::string(ident::text(model.verdict->grade))
                                                       : "cannot tell whether it is of this plant");
  if (exchanged) {
    // What the checks of exchanged columns say is of no plant.
    text += fmt::format("  {}.\n", capitalised(identify::exchange_sentence(*exchanged, scored_here)));
  } else if (!silent.empty()) {
    text += fmt::format("  {}.\n", silent);
  } else {
    if (!can_tell) {
      const std::string why = fmt::format("Cannot tell: {}. By its checks alone: {}.", scored_here.cannot_tell,
                                          ident::text(model.verdict->grade));
      text += "  " + wrapped(why, 2) + "\n";
    }
    if (gain && !scored_here.of_another_plant) {
      const std::string explained = identify::other_gain_text(scored_here, shown_factor, shown_unit);
      text += "  " + wrapped(capitalised(explained) + ".", 2) + "\n";
    }
    for (const std::string& reason : shown.verdict->reasons) text += "  " + wrapped(reason, 2) + "\n";
  }
  if (is_another && !exchanged && silent.empty()) {
    for (const std::string& sentence :
         change_sentences(ident::in_output_unit(*scored_here.change, shown_factor), shown)) {
      text += "  " + wrapped(sentence, 4) + "\n";
    }
  }
  text += fmt::format("On {} samples:\n", validation.score.samples);
  text += score_line("offset kept", scored.score, shown);
  if (scored.offset_reestimated) {
    text += score_line("offset re-estimated", *scored.offset_reestimated, shown);
    text += fmt::format("  {:<20} judged by the latter: another record begins at another place\n", "");
  }
  text += "  " + correlation_line("residual with itself", validation.acf, 1);
  text += "  " + correlation_line("residual with input", validation.ccf, 0);
  ident::Model judged_as_shown = shown;
  if (scored.offset_reestimated) judged_as_shown.validation->score = *scored.offset_reestimated;
  if (const std::string note = ident::lags_note(judged_as_shown, *model.verdict);
      !note.empty() && !exchanged && silent.empty()) {
    text += wrapped(note, 0) + "\n";
  }
  console.print(text);
  if (is_another && source.run_folder) warn_of_leak(*source.run_folder, console, source.units);
  if (exchanged) {
    console.next_step(importer::command_with(command.import, command.source, source.exchange));
    return ExitCode::model_rejected;
  }
  const std::string picture =
      fmt::format("eha plot {}{} -o {}", shell_word(command.source), importer::words_of_reading(command.import.command),
                  shell_word(free_name("record.svg")));
  if (!silent.empty()) {
    console.next_step(picture);
    return ExitCode::model_rejected;
  }
  if (const auto& stop = validation.end_stop; stop && !model.verdict->accepted && !is_another) {
    const std::string part = ident::cut_options(*stop);
    console.next_step(part.empty() ? picture : importer::command_with(command.import, command.source, part));
    return ExitCode::model_rejected;
  }
  if (!model.verdict->accepted) {
    const std::string record = record_of(model);
    std::error_code ignored;
    const bool is_of_file = !source.run_folder && std::filesystem::is_regular_file(record, ignored);
    // The comparison of the model with this record is told already; the record's own report does not show this model.
    importer::ReadAlike before{{}, command.model_file};
    if (is_another && is_of_file) {
      before = importer::read_alike(command_of(model), record);
    }
    const importer::ReadAlike now =
        importer::read_alike(source.run_folder ? std::string() : command.import.command, command.source, before.name);
    console.next_step(fmt::format("{}{}eha compare {} {}{} -o {}", before.import, now.import, shell_word(before.name),
                                  shell_word(now.name), intersample_words(command.record.intersample),
                                  shell_word(free_name("comparison.html"))));
    if (is_another && source.run_folder && record::is_run_folder(record)) {
      console.next_step(fmt::format("eha compare {} {}", shell_word(record), shell_word(command.source)));
    }
    return ExitCode::model_rejected;
  }
  const auto input = !importer::says_how_to_read(command.import)
                         ? input_words_of_record(command.source, model.input_unit)
                         : std::nullopt;
  if (const auto start = simulated_start(model, shown_factor, shown_unit); input && start) console.info(*start);
  console.next_step(fmt::format("eha simulate {} {} -o {}", shell_word(command.model_file), input.value_or("INPUT.csv"),
                                shell_word(free_name("output.csv"))));
  return ExitCode::ok;
}

}  // namespace

void add_validate(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("validate", "Score a model on a record it has not seen");
  sub->footer(kValidateFooter);
  auto& validate = options_of<ValidateCommand>(*sub, line);
  takes_run_name(sub->add_option("model", validate.model_file, "Model file (JSON)"), line)
      ->required()
      ->type_name("MODEL");
  takes_run_name(sub->add_option("source", validate.source, "Run folder or its name, or file with a record"), line)
      ->required()
      ->type_name("SOURCE");
  sub->add_option("--experiment", validate.experiment_file, "Experiment file whose record and acceptance apply")
      ->type_name("EXPERIMENT");
  add_record_options(*sub, validate.record);
  add_import_options(*sub, line, validate.import, ImportedColumns::record);
}

}  // namespace eha::cli
