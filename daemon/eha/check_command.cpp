// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "config/controller_config.hpp"
#include "config/experiment_config.hpp"
#include "config/file_kind.hpp"
#include "config/measured_check.hpp"
#include "config/needs_following.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/rig/limit_remarks.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

constexpr const char* kCheckFooter = R"(
Reports every fault of a rig.toml or an experiment.toml with its line and column, and of a rig what it leaves unprotected.
An experiment is also checked against
the rig that `eha run` would use (--rig, else that of a running service with the place of its rod, unless a run moves it,
else the default one; refused while the service has not read what the file says now): limits [V], slew [V/s], Nyquist frequency [Hz]. It is
then rehearsed with the rig's valve, and refused if half of the rehearsed rods reach a travel or velocity limit, or if the
rod stands beyond one.

Examples:
  eha check config/experiments/paper.toml
  eha check sweep.toml --rig /etc/ehad/rig.toml)";

struct CheckCommand {
  std::string file;
  std::optional<std::string> rig_file = {};
  std::optional<std::string> place = {};                     ///< position of the rod, a length with its unit
  std::filesystem::path socket = control::default_socket();  ///< of the service whose rig is used for the check
  bool accept_travel_risk = false;                           ///< only warn if the rehearsal refuses
};

/// How the rig of a named file is reached: a machine through the service only if that drives by this very file. Another
/// file may be of another machine, which a command of the service would not move.
suggest::RigAccess access_of_rig_file(const std::string& file, const config::RigConfig& rig,
                                      const std::optional<ServiceRig>& service, const std::filesystem::path& socket) {
  if (!hal::moves_machine(rig.backend)) return simulated_access(file);
  const std::filesystem::path driven = service ? std::filesystem::path(service->file) : default_rig_file().value_or("");
  std::error_code ignored;
  if (std::filesystem::equivalent(driven, file, ignored)) {
    return service ? access_of(*service, socket) : access_of(DriveOptions{.socket = socket});
  }
  return access_of(DriveOptions{.rig_file = file, .local = true});
}

/// Says that the file would bring another calibration into force than the service's.
void warn_of_other_calibration(const config::RigConfig& rig, const ServiceRig& service, const Console& console) {
  constexpr double kSame_in = 0.01;
  try {
    const config::RigConfig in_force = config::load_rig(service.file);
    const PlaceShift shift =
        greatest_shift(rig.limits, hal::conversion_of(in_force.backend), hal::conversion_of(rig.backend));
    if (!(std::abs(shift.by_in) > kSame_in)) return;
    const DisplayUnit unit = console.unit(rig.units);
    console.warning(
        fmt::format("its calibration of the sensor is not that of {}, in force now: with it places shift by up to "
                    "{:+.2g} {}, and the travel limits with them; if the newer calibration is the other one, take its "
                    "scale_in_per_V and offset_in over",
                    service.file, unit.factor("in") * shift.by_in, unit.of("in")));
  } catch (const Error& error) {  // the service's file need not be readable
    console.debug(error.what());
  }
}

void report_rig(const CheckCommand& command, const config::RigConfig& rig, Console& console) {
  const std::optional<ServiceRig> service = rig_of_service(command.socket, console);
  std::error_code ignored;
  const bool is_of_service = service && std::filesystem::equivalent(service->file, command.file, ignored);
  const bool is_same_rig = service && service->name == rig.name && service->moves == hal::moves_machine(rig.backend);
  const bool lacks_following = !rig.limits.following && !hal::moves_machine(rig.backend);
  const auto& following = rig.limits.following;
  const bool is_changed =
      following && following->measured_check && following->measured_rig_check && !config::is_as_measured(rig);
  console.set_rig(is_of_service || is_same_rig ? access_of(*service, command.socket)
                                               : access_of_rig_file(command.file, rig, service, command.socket));
  require_protecting_limits(rig);
  for (const std::string& sentence : arming_findings(rig).warnings) console.warning(sentence);
  for (const std::string& sentence : limit_remarks(rig)) console.warning(sentence);
  if (lacks_following) console.warning(std::string(config::kNotFollowed));
  if (is_same_rig && !is_of_service) warn_of_other_calibration(rig, *service, console);
  const std::string_view backend = hal::name_of(rig.backend);
  console.print_json(
      {{"schema", "eha-check/1"}, {"file", command.file}, {"kind", "rig"}, {"name", rig.name}, {"backend", backend}});
  const DisplayUnit unit = console.unit(rig.units);
  console.print(
      fmt::format("{}: a valid rig file, \"{}\": backend {}, {:g}..{:g} V, {:g} V/s, {:.6g}..{:.6g} {}, tick {:g} s",
                  command.file, rig.name, backend, rig.limits.command_min_V, rig.limits.command_max_V,
                  rig.limits.slew_V_per_s, unit.factor("in") * rig.limits.travel_min_in,
                  unit.factor("in") * rig.limits.travel_max_in, unit.of("in"), rig.realtime.sample_period_s));
  const bool is_of_another_rig =
      is_changed && *following->measured_rig_check != config::measured_rig_check_of(rig.backend);
  const bool is_new_file = !is_of_service && is_same_rig;
  if (is_of_another_rig) {
    // Of this file, not of the service's, which has another calibration.
    console.next_step(suggest::without_following(
        is_new_file ? access_of(DriveOptions{.rig_file = command.file, .local = true}) : console.rig()));
  } else if (is_changed && is_new_file) {  // measured through the service, once that has it
    console.next_step(put_in_force(command.file, service->file, command.socket));
  } else if (is_changed ||
             (lacks_following && !(service && service->change))) {  // to be measured before it is in force
    console.next_step(suggest::characterise(console.rig()));
  } else if (is_of_service && service->change) {
    console.next_step(through(command.socket, "eha disarm") + " && " + through(command.socket, "eha reload"));
  } else if (is_new_file) {
    console.next_step(put_in_force(command.file, service->file, command.socket));
  } else {
    console.next_step("eha check " + shell_word(an_experiment()) + " --rig " + shell_word(command.file));
  }
}

void report_controller(const CheckCommand& command, const config::ControllerConfig& controller, Console& console) {
  const ident::AxisSettings& s = controller.settings;
  const std::string_view kind = ident::text(s.kind);
  std::string on_rig;
  if (command.rig_file) {
    const config::RigConfig rig = config::load_rig(*command.rig_file);
    if (s.command_min < rig.limits.command_min_V || s.command_max > rig.limits.command_max_V ||
        s.reference.lowest < rig.limits.travel_min_in || s.reference.highest > rig.limits.travel_max_in ||
        s.reference.velocity > rig.limits.velocity_limit_in_per_s || s.slew_per_s > rig.limits.slew_V_per_s) {
      throw ConfigError(
          fmt::format("{}: its travel, velocity, command or slew exceeds that of {}; tune it for this rig: `{}`",
                      command.file, *command.rig_file,
                      suggest::tune({.rig_file = *command.rig_file, .new_controller = free_name("controller.toml")},
                                    controller.provenance.model)));
    }
    if (s.tick_s < rig.realtime.sample_period_s || s.tick_s > rig.realtime.sample_period_s) {
      throw ConfigError(fmt::format("{}: tick_s: expected {:g} s as {} has it, got {:g}", command.file,
                                    rig.realtime.sample_period_s, *command.rig_file, s.tick_s));
    }
    on_rig = fmt::format(", within the limits of {}", *command.rig_file);
  }
  console.print_json({{"schema", "eha-check/1"},
                      {"file", command.file},
                      {"kind", "controller"},
                      {"name", controller.name},
                      {"feedback", kind}});
  console.print(fmt::format("{}: a valid controller file, \"{}\": {} for {}, to {}, tick {:g} s{}", command.file,
                            controller.name, kind, controller.provenance.rig, controller.purpose, s.tick_s, on_rig));
  console.next_step("eha report " + shell_word(command.file));
}

void report_experiment(const CheckCommand& command, const config::ExperimentConfig& experiment,
                       const std::optional<Rehearsed>& rehearsed, Console& console) {
  const config::RigConfig* rig = rehearsed ? &rehearsed->rig : nullptr;
  const std::optional<Rehearsal> rehearsal = rehearsed ? rehearsed->rehearsal : std::nullopt;
  nlohmann::ordered_json document{
      {"schema", "eha-check/1"}, {"file", command.file}, {"kind", "experiment"}, {"name", experiment.name}};
  document["duration_s"] = experiment.duration_s * experiment.repetitions;
  if (rig) {
    document["rig"] = rig->file_name;
    document["rehearsal"] = rehearsal ? to_json(*rehearsal) : nlohmann::ordered_json(nullptr);
  }
  console.print_json(document);
  const std::size_t count = experiment.models.size();
  const std::string models = experiment.characterises() ? "the valve sheet"
                             : count == 0               ? "the ladder of models"
                                                        : fmt::format("{} model{}", count, count == 1 ? "" : "s");
  console.print(fmt::format("{}: a valid experiment, \"{}\": {:g} s, {} repetition{}, {}{}", command.file,
                            experiment.name, experiment.duration_s, experiment.repetitions,
                            experiment.repetitions == 1 ? "" : "s", models,
                            rig ? fmt::format(", volts and slew within the limits of {}", rig->file_name) : ""));
  if (rehearsal) console.print(sentence_on(*rehearsal, *rig, console));
  if (const auto sentence = config::off_grid_tones(experiment)) console.warning(*sentence);
  if (rig) {
    warn_if_not_fittable(experiment, *rig, command.file, console);
    if (warn_if_not_rehearsed(experiment, *rig, command.file, console)) {
      console.next_step(suggest::characterise(console.rig()));
      return;
    }
  }
  if (!rig) console.warning("no rig file to check the experiment against; name one with --rig");
  if (is_at_risk(rehearsal)) {  // to be checked again from elsewhere, or with another file, before it is played
    const std::string check = "eha check " + shell_word(command.file);
    const std::string move = move_before(*rehearsed, console);
    if (!move.empty() && rehearsed->player == Player::service) {
      console.next_step(fmt::format("{} && {} && {}", through(command.socket, "eha arm"), through(command.socket, move),
                                    through(command.socket, check)));
    } else if (!move.empty()) {
      console.next_step(move);
    }
    return;
  }
  console.next_step(rig ? run_of(experiment, *rig, console.rig(), console)
                        : suggest::run(simulated_access(command.rig_file), {command.file}));
}

ExitCode execute(const CheckCommand& command, Console& console) {
  const std::string text = config::read_config_file(command.file);
  const config::FileKind kind = config::kind_of(text, command.file);
  if (kind == config::FileKind::controller) {
    report_controller(command, config::parse_controller(text, command.file), console);
    return ExitCode::ok;
  }
  if (kind == config::FileKind::rig) {
    if (command.rig_file)
      throw UsageError(fmt::format("{}: is itself a rig file; --rig is for experiments", command.file));
    if (command.place) throw UsageError(fmt::format("{}: is a rig file; --at is for experiments", command.file));
    report_rig(command, config::parse_rig(text, command.file), console);
    return ExitCode::ok;
  }
  std::optional<std::string> rig_file = command.rig_file;
  std::optional<ServiceRig> service;
  if (!rig_file) {
    service = rig_of_service(command.socket, console);
    if (service) require_as_read(*service);
    if (service && access(service->file.c_str(), R_OK) != 0) service.reset();  // it checks again at the submission
    if (service) rig_file = service->file;
  }
  if (!rig_file) {
    if (const auto found = default_rig_file()) rig_file = found->string();
  }
  if (!rig_file) {
    if (command.place) throw UsageError("--at: no rig file to check the experiment against; name one with --rig");
    report_experiment(command, config::parse_experiment(text, command.file, config::NamedFiles::read), std::nullopt,
                      console);
    return ExitCode::ok;
  }
  const config::RigConfig rig = config::load_rig(*rig_file);
  console.set_rig(service ? access_of(*service, command.socket)
                  : command.rig_file
                      ? access_of_rig_file(*rig_file, rig, rig_of_service(command.socket, console), command.socket)
                      : access_of_rig(rig, {}));
  const config::PreparedExperiment prepared =
      config::parse_prepared_experiment(text, command.file, rig, config::NamedFiles::read);
  const double here_in = service && service->place_in ? *service->place_in : start_of(rig);
  const auto place_in = command.place ? inches_of(*command.place) : here_in;
  if (!place_in)
    throw UsageError(fmt::format("--at {}: expected a length with its unit, such as 2.95in or 75mm", *command.place));
  if (service) {
    const DisplayUnit unit = console.unit(rig.units);
    console.info(fmt::format("checked with the rig of the service ({}), the rod at {:.3f} {}{}", rig.file_name,
                             unit.factor("in") * *place_in, unit.of("in"),
                             service->is_moving && !command.place
                                 ? " at this moment, as a run is on and moves it; --at PLACE names where it will stand"
                                 : ""));
  }
  // --at says where a rod stands that this process does not simulate.
  const bool is_simulated_here = !service && !command.place && !hal::moves_machine(rig.backend);
  const Player player = is_simulated_here ? Player::local : Player::service;
  require_within_travel(prepared.config, rig, *place_in, command.file, console, player);
  if (command.place) require_place_to_begin(prepared.config, *place_in, command.file, console.unit(rig.units));
  const std::optional<Rehearsal> rehearsal = rehearse(prepared, rig, *place_in);
  const Rehearsed rehearsed{prepared, rig, *place_in, rehearsal, player};
  if (rehearsal && rehearsal->chance_of_trip >= kRefusedChanceOfTrip && !command.accept_travel_risk) {
    console.info(fmt::format("{}: {}", command.file, sentence_on(*rehearsal, rig, console)));  // why it is refused
  }
  judge_travel(rehearsed, command.file, command.accept_travel_risk ? TravelRisk::accept : TravelRisk::refuse, console);
  warn_of_little_motion(rehearsed, command.file, console);
  report_experiment(command, prepared.config, rehearsed, console);
  return ExitCode::ok;
}

}  // namespace

void add_check(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("check", "Check a rig, experiment or controller file and report every fault");
  sub->footer(kCheckFooter);
  auto& check = options_of<CheckCommand>(*sub, line);
  sub->add_option("file", check.file, "rig.toml, experiment.toml or controller.toml")
      ->required()
      ->type_name("RIG|EXPERIMENT|CONTROLLER");
  CLI::Option* rig =
      sub->add_option("--rig", check.rig_file, "Rig file to check an experiment against")->type_name("RIG");
  sub->add_option("--at", check.place,
                  "Where the rod stands, such as 2.95in or 75mm (default: where the service sees it, else mid-travel)")
      ->type_name("LENGTH");
  add_socket_option(*sub, check.socket)->excludes(rig);
  sub->add_flag("--accept-travel-risk", check.accept_travel_risk,
                "Only warn if half of the rehearsed rods reach a limit");
}

}  // namespace eha::cli
