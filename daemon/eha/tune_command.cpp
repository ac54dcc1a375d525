// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/tune_command.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "config/file_kind.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/tune_next.hpp"
#include "daemon/eha/tune_origin.hpp"
#include "daemon/eha/tuned_rig.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/resolved_path.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/tune/controller_answer.hpp"
#include "daemon/tune/controller_page.hpp"
#include "daemon/tune/expected_trip.hpp"
#include "daemon/tune/kind_table.hpp"
#include "daemon/tune/promised_plant.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/backends/backend.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

constexpr const char* kTuneFooter = R"(
Makes a controller of the axis from a model: reference generator within limits, feed-forward, inverse of the valve map,
feedback with limits on margin and noise. Margins hold for 95 % of 200 draws of the model's parameters. The controller is
tried on 50 drawn simulated rigs (step, trapezoids, sine, hold of 60 s); one that hunts on any of them is not offered. The
figures of these trials are its promise. Writes controller.toml, eha-controller(5), and its report beside it (.html).
Without --kind the least feedback within a fifth of the best is taken, and what the others would gain is shown.
--twin names a simulated rig that was fitted to a record (`eha replay --calibrate`). Without it a simulated rig is its own
twin; for another rig one is estimated from model and valve. --sheet takes null, dead band, gains and noise of a run of
`eha characterise`; without it [following] of the rig file gives them where the model has no valve map, or one that a leak
past the piston has bent.
With RUN, the model that the run recommends is meant. Nothing moves.

Examples:
  eha tune runs/latest --sheet runs/20260101T120000Z-characterise -o axis.toml
  eha tune runs/latest/models/integrator_lag_valve.json
  eha tune models/cylinder_valve.json --rig rig.toml --twin twin.toml --for hold -o hold.toml
  eha export controller.toml --format st -o axis.st)";

constexpr std::array<Choice<ident::AxisPurpose>, 2> kPurposes{
    {{"track", ident::AxisPurpose::track}, {"hold", ident::AxisPurpose::hold}}};

constexpr std::array<Choice<std::optional<ident::FeedbackKind>>, 6> kKinds{{{"p", ident::FeedbackKind::p},
                                                                            {"pi", ident::FeedbackKind::pi},
                                                                            {"pd", ident::FeedbackKind::pd},
                                                                            {"pid", ident::FeedbackKind::pid},
                                                                            {"fopid", ident::FeedbackKind::fopid},
                                                                            {"auto", std::nullopt}}};

Json json_of(const config::PromisedFigure& f) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"value", number(f.value)}, {"lower", number(f.lower)}, {"upper", number(f.upper)}};
}

Json json_of(const tune::Candidate& c) {
  return {{"kind", ident::text(c.kind)},
          {"kp_per_s", c.design.settings.feedback.kp},
          {"ki_per_s2", c.design.settings.feedback.ki},
          {"kd", c.design.settings.feedback.kd},
          {"following_rms_in", c.following_rms_in},
          {"rest_error_in", c.rest_error_in},
          {"standing_in", c.standing_in},
          {"hunts", c.hunts}};
}

Json json_of(const tune::ComparedKind& k) {
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  return {{"kind", ident::text(k.kind)},
          {"following_rms_in", number(k.following_rms_in)},
          {"rest_error_in", number(k.rest_error_in)},
          {"load_error_of_pid", number(k.load_error_of_pid)},
          {"lasting_error_s", k.lasting_error_s}};
}

tune::TuneChoices choices_of(const TuneCommand& command, const config::RigConfig& rig) {
  tune::TuneChoices choices{.purpose = command.purpose,
                            .kind = command.kind,
                            .sensitivity = command.sensitivity.value_or(tune::usual_sensitivity(command.purpose)),
                            .tick_s = command.tick_s};
  if (command.twin_file) choices.twin = twin_of(*command.twin_file);
  if (command.sheet_run) {
    const sheet::RunSheet sheet = sheet::sheet_of_run(*command.sheet_run);
    if (sheet.rig.name != rig.name) {
      throw UsageError(fmt::format("--sheet {}: the valve of {}, where the rig is {}; name the rig file with --rig",
                                   *command.sheet_run, sheet.rig.name, rig.name));
    }
    choices.sheet = sheet.sheet;
  }
  return choices;
}

void refuse_existing(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return;
  throw UsageError(
      fmt::format("{}: exists already, and no controller is overwritten; name another one with -o", file.string()));
}

/// How the trial of the controller reaches its rig. @param rig_file  or run
suggest::RigAccess access_for(const TuneCommand& command, const ident::Model& model, const config::RigConfig& rig,
                              const fs::path& rig_file) {
  suggest::RigAccess access = access_of_rig(rig, command.rig_file ? *command.rig_file : rig_name_of(rig_file),
                                            run_of(command, model).value_or("").string());
  access.controller = command.output.string();
  access.model = command.model_file;
  return access;
}

}  // namespace

ExitCode execute(const TuneCommand& given, Console& console) {
  TuneCommand command = given;
  if (record::is_run_folder(command.model_file)) {
    const auto model_file = recommended_model(command.model_file);
    if (!model_file) throw DataError(why_no_model(command.model_file));
    command.model_file = model_file->string();
  }
  refuse_existing(command.output);
  const ident::Model model = read_model(command.model_file);
  // A model of no run is of the twin of its record, if of any rig that is simulated here.
  if (command.twin_file && !command.rig_file && !run_of(command, model) &&
      !hal::moves_machine(load_rig_or_default(std::nullopt).backend)) {
    command.rig_file = command.twin_file;
  }
  const fs::path rig_file = record::resolved_path(rig_path(command, model, console));
  const config::RigConfig rig = rig_of(rig_file);
  console.set_rig(access_for(command, model, rig, rig_file));
  if (model.verdict && !model.verdict->accepted && !model.verdict->reasons.empty()) {
    console.warning(fmt::format("{}: the model is {}: {}", command.model_file, ident::verdict_word(*model.verdict),
                                model.verdict->reasons.front()));
  }
  const auto sheet = command.sheet_run ? valve_of_sheet(*command.sheet_run, console.rig()) : std::nullopt;
  std::optional<std::string> valve_first;  // where the valve is not that of [following], with which no trial is played
  const std::string changed = changed_since_run(command, model);
  if (changed.empty() && (sheet || model.input_map) &&
      !leak_of(command, model)) {  // a leak is said below, with what comes first
    const bool is_another = warn_if_following_differs(
        rig, sheet ? *sheet : valve_of_model(model, command.model_file, std::nullopt, console.rig()), console);
    if (is_another) valve_first = sheet ? sheet->remedy : suggest::characterise(console.rig());
  }
  tune::TuneInputs inputs;
  tune::Tuned tuned;
  std::vector<std::string> plant;
  try {
    inputs = tune::tune_inputs(model, rig, choices_of(command, rig));
    inputs.task.unit = console.unit(rig.units);
    if (command.twin_file) inputs.twin = *command.twin_file;
    plant = plant_sentences(command, model, rig, inputs, rig_file);
    if (!changed.empty()) plant.insert(plant.begin(), changed);
    if (const auto leak = leak_of(command, model)) {
      plant.insert(plant.begin(), ident::leak_finding(*leak, inputs.task.unit) + " The promise may not be kept.");
    }
    tuned = tune::tune(inputs.plant, inputs.task, identify::thread_executor());
  } catch (const DataError& error) {
    // A model that no cylinder is has a reason of its own for which every feedback fails on the trials' cylinders.
    const std::string other = plant.empty() ? std::string() : tune::why_another_plant(inputs);
    throw DataError(fmt::format("{}: {}{}{}", command.model_file, other.empty() ? "" : other + ": ", error.what(),
                                command.kind && !plant.empty() ? "; without --kind the kinds that do are tried" : ""));
  }

  const std::string record = record_of(model);
  tuned.remarks.insert(tuned.remarks.begin(), plant.begin(), plant.end());
  config::ControllerProvenance provenance{
      .model = record::resolved_path(command.model_file).string(),
      .model_sha256 = record::sha256_of_file(command.model_file),
      .rig = rig.name,
      .rig_file = rig_file.string(),
      .rig_sha256 = record::sha256_of(std::as_bytes(std::span(rig.text))),
      .twin = command.twin_file ? record::resolved_path(*command.twin_file).string() : inputs.twin,
      .run = named_record(model.provenance),
      .sheet = command.sheet_run ? record::resolved_path(*command.sheet_run).string() : "",
      .made_by = fmt::format("eha {}", EHA_VERSION)};
  config::ControllerConfig controller =
      tune::controller_of(tuned, inputs, std::move(provenance), command.output.stem().string());
  const auto trial = trial_on(rig, controller);
  const auto trip = trial ? tune::expected_trip(*trial, rig.limits, inputs.task.twin) : std::nullopt;
  if (trip) {
    const std::string sentence = tune::sentence_of(*trip, rig.limits);
    plant.insert(plant.begin(), sentence);
    tuned.remarks.insert(tuned.remarks.begin(), sentence);
    controller.promise.remarks = fmt::format("{}\n{}", sentence, controller.promise.remarks);
  }
  os::write_file_atomically(command.output, config::controller_text(controller));
  fs::path page_file = command.output;
  page_file.replace_extension(".html");
  tune::ControllerSubject subject{.controller = controller, .inputs = inputs, .trace = tuned.trace};
  subject.unit = console.unit(rig.units);
  subject.dated = written_words(command.output);
  subject.kinds = tuned.kinds;
  subject.rig = for_a_page(console.rig());
  const report::Page page = tune::controller_page(subject);
  os::write_file_atomically(page_file, page.html);
  for (const std::string& sentence : page.missing) console.warning(sentence);

  Json candidates = Json::array();
  for (const tune::Candidate& c : tuned.candidates) candidates.push_back(json_of(c));
  Json kinds = Json::array();
  for (const tune::ComparedKind& k : tuned.kinds) kinds.push_back(json_of(k));
  const config::ControllerPromise& p = controller.promise;
  console.print_json({{"schema", "eha-tune/1"},
                      {"model", command.model_file},
                      {"rig", rig_file.string()},
                      {"twin", controller.provenance.twin},
                      {"plant", plant},
                      {"trips", trip ? Json(acquisition::to_text(trip->breach.fault)) : Json(nullptr)},
                      {"file", command.output.string()},
                      {"report", page_file.string()},
                      {"kind", ident::text(controller.settings.kind)},
                      {"kp_per_s", controller.settings.feedback.kp},
                      {"ki_per_s2", controller.settings.feedback.ki},
                      {"kd", controller.settings.feedback.kd},
                      {"promise",
                       {{"twins", p.twins},
                        {"following_rms_in", json_of(p.following_rms_in)},
                        {"following_worst_in", json_of(p.following_worst_in)},
                        {"sine_rms_in", json_of(p.sine_rms_in)},
                        {"overshoot_in", json_of(p.overshoot_in)},
                        {"settling_s", json_of(p.settling_s)},
                        {"rest_error_in", json_of(p.rest_error_in)},
                        {"standing_in", json_of(p.standing_in)},
                        {"ms", json_of(p.ms)},
                        {"mt", json_of(p.mt)},
                        {"phase_margin_deg", json_of(p.phase_margin_deg)},
                        {"gain_margin", json_of(p.gain_margin)},
                        {"delay_margin_s", json_of(p.delay_margin_s)}}},
                      {"candidates", candidates},
                      {"kinds", kinds},
                      {"remarks", tuned.remarks}});
  std::string text =
      tune::headline(subject) + "\n" +
      fmt::format("{}: {} controller for {} ({}), to {}, tick {:g} s; tried on {} drawn rigs ({})\n",
                  command.output.string(), ident::text(controller.settings.kind), rig.name, rig_file.string(),
                  controller.purpose, controller.settings.tick_s, p.twins, inputs.twin);
  for (const std::string& sentence : plant) text += sentence + "\n";
  text += "\n";
  text += text_table({{"promise"}, {"value", Align::right}, {"from", Align::right}, {"to", Align::right}, {"unit"}},
                     tune::promise_rows(p, console.unit(rig.units)));
  text += tune::promise_note(controller.settings, console.unit(rig.units)) + "\n\n";
  for (std::size_t i = plant.size(); i < tuned.remarks.size(); ++i) text += tuned.remarks[i] + "\n";
  if (const auto rows = tune::kind_rows(tuned.kinds, subject.unit); !rows.empty()) {
    std::vector<Column> columns;
    for (const std::string& title : tune::kind_titles(subject.unit)) {
      columns.push_back({title, columns.empty() ? Align::left : Align::right});
    }
    text += fmt::format("\n{}{}\n", text_table(columns, rows), tune::kKindNote);
  }
  const std::string file = shell_word(command.output.string());
  text += fmt::format(
      "\nReport: {}\n"
      "Step as a picture: eha plot {} -o step.png\n"
      "Table: eha export {} --format csv -o {}\n",
      page_file.string(), file, file, shell_word(command.output.stem().string() + ".csv"));
  if (!leak_of(command, model)) {  // else the repair comes first
    text += fmt::format("PLC, C, MATLAB: eha export {} --format st -o {} (or c, simulink)\n", file,
                        shell_word(command.output.stem().string() + "_control.st"));
  }
  console.print(text);
  for (const std::string& step :
       next_steps(command, model, rig, controller, console.rig(), trip, valve_first, !changed.empty(), page_file))
    console.next_step(step);
  return ExitCode::ok;
}

void add_tune(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("tune", "Make a controller from a model, and say what it will do");
  sub->footer(kTuneFooter);
  auto& command = options_of<TuneCommand>(*sub, line);
  takes_run_name(sub->add_option("model", command.model_file,
                                 "Model file, as `eha fit` wrote it, or the run whose recommended model is meant"),
                 line)
      ->required()
      ->type_name("MODEL|RUN");
  add_choice(*sub, "--for", command.purpose, kPurposes, "Follow references, or stay in a place (default track)");
  add_choice(*sub, "--kind", command.kind, kKinds, "Kind of the feedback (default auto)");
  sub->add_option("--margin", command.sensitivity, "Greatest max(Ms, Mt), 1.1 to 3 (default 1.4, with --for hold 1.2)")
      ->type_name("M")
      ->check(finite_number("a number from 1.1 to 3", [](double m) { return m >= 1.1 && m <= 3.0; }));
  sub->add_option(
         "--rig", command.rig_file,
         "Rig file whose limits and sensor apply (default that of the model's run as it is now, else as `eha run "
         "--local` for the same rig, else as the run has it)")
      ->type_name("RIG");
  sub->add_option("--twin", command.twin_file, "Rig file of a simulated rig fitted to a record")->type_name("RIG");
  takes_run_name(sub->add_option("--sheet", command.sheet_run, "Run of `eha characterise` whose valve sheet applies"),
                 line)
      ->type_name("RUN");
  sub->add_option("--tick", command.tick_s, "Period of the controller, 0.0002 to 0.1 s (default the rig's)")
      ->type_name("SECONDS")
      ->check(finite_number("seconds from 0.0002 to 0.1", [](double s) { return s >= 0.0002 && s <= 0.1; }));
  sub->add_option("-o,--output", command.output, "File to write (default controller.toml)")->type_name("FILE");
}

}  // namespace eha::cli
