// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "config/characterisation.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/commission_page.hpp"
#include "daemon/eha/commission_session.hpp"
#include "daemon/eha/commission_state.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/recorded_gain.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/place/explorer.hpp"
#include "daemon/precision/precision_watch.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/rig/calibration.hpp"
#include "hal/backends/backend.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kCommissionFooter = R"(
From a rig with nothing known of its valve to a verified axis, in steps: doctor, read, valve sheet (its numbers are
written into RIG), excitation within the measured limits, record with models, controller, trial, report of the whole.
Each step is a command of eha that you could type; it is shown before it begins, with what it does to the rod and how
long it takes, and asks first. Every run is an ordinary one in the runs' folder, under all limits of RIG.
The record ends after the repetition with which the gain is known to --precision; when it is not reached, a further run
follows, and the more precise one counts.
Answer no, or press Ctrl-C, at any step, and type the same command again to go on with that step: FOLDER/commission.json
says what is done, and a record that is whole is not played again. For another valve or load begin anew: -o NEW_FOLDER.
The text of each run and all models: -v, and its report. A machine is commissioned attended, through ehad or with --local; --yes is for simulated rigs.
Exit code 3: no model passed, or the axis does not keep the controller's promise.

Examples:
  eha commission rig.toml --yes --fast
  eha commission /etc/ehad/rig.toml --ruler 74mm)";

constexpr const char* kMeasuredFile = "rig.toml";
constexpr const char* kFileBefore = "rig_before.toml";
constexpr const char* kReport = "report.html";
constexpr const char* kControllerFile = "axis.toml";
constexpr int kRepetitions = 5;
constexpr int kFurtherRepetitions = 4;  // the whole commissioning stays within 10 min of rig time
constexpr int kAttempts = 2;
constexpr double kPeriod_s = 10.0;
constexpr double kLowest_Hz = 0.1;
constexpr double kHighest_Hz = 2.0;
constexpr double kTicksAPeriod = 20.0;

struct CommissionCommand : CommissionOptions {};

Recorded recorded_in(const fs::path& folder) {
  const record::Manifest manifest = record::read_manifest(folder);
  Recorded recorded{.folder = folder,
                    .outcome = std::string(record::outcome_text(manifest)),
                    .gain_percent = precision::gain_percent(folder),
                    .model = {}};
  if (manifest.identification && manifest.identification->recommendation &&
      !manifest.identification->recommendation->model.empty()) {
    recorded.model = manifest.identification->recommendation->model;
  }
  return recorded;
}

/// Replaces the file that a path leads to, not a link to it: its owner goes on to edit that one. Keeps who may read it.
void replace_rig_file(const fs::path& path, const std::string& text) {
  const fs::path file = fs::canonical(path);
  const fs::perms permissions = fs::status(file).permissions();
  os::write_file_atomically(file, text);
  fs::permissions(file, permissions);
}

/// The same with a folder that is not there yet.
CommissionOptions elsewhere(CommissionOptions command) {
  command.folder = free_name(command.folder.string());
  return command;
}

std::string anew_elsewhere(const CommissionOptions& command) {
  return "begin anew in another folder: " + again(elsewhere(command));
}

class Commissioning {
 public:
  Commissioning(const CommissionCommand& command, Console& console)
      : command_(command),
        console_(console),
        rig_(config::load_rig(command.rig_file)),
        session_(command, hal::moves_machine(rig_.backend), console),
        state_(command.folder, anew_elsewhere(command)) {}

  ExitCode execute() {
    refuse_what_does_not_fit();
    if (state_.has("track")) {
      console_.info(fmt::format("{} is finished; nothing is measured again, for that: {}", state_.folder().string(),
                                again(elsewhere(command_))));
    }
    try {
      prepare();
      measure_valve();
      install_numbers();
      record_motion();
      make_controller();
      try_controller();
    } catch (const Stopped& stopped) {
      session_.disarm();
      if (!stopped.why.empty()) console_.info(stopped.why);
      const bool leaks = stopped.code != ExitCode::interrupted && tell_leak();
      if (!leaks) console_.info(stopped.next.empty() ? "to go on with this step: " + again(command_) : stopped.next);
      console_.print_json({{"schema", "eha-commission/1"},
                           {"folder", state_.folder().string()},
                           {"steps", state_.document().at("steps")},
                           {"exit_code", static_cast<int>(stopped.code)}});
      return stopped.code;
    } catch (...) {
      session_.disarm();
      throw;
    }
    session_.disarm();
    return conclude();
  }

 private:
  void refuse_what_does_not_fit() const {
    if (hal::moves_machine(rig_.backend) && command_.yes) {
      throw UsageError(fmt::format("--yes: {} moves a machine, which is commissioned attended", command_.rig_file));
    }
    if (const std::string file = fs::weakly_canonical(command_.rig_file).string();
        file.starts_with("/usr/") && !file.starts_with("/usr/local/")) {
      throw UsageError(
          fmt::format("{}: belongs to a package; the measured numbers are written into the rig file: cp {} . and "
                      "commission the copy",
                      command_.rig_file, shell_word(command_.rig_file)));
    }
    require_writable_rig_file();
    const std::string known = state_.rig_sha256();
    if (known.empty()) return;
    const std::string now = record::sha256_of_file(command_.rig_file);
    // The owner may have installed the measured numbers.
    const std::optional<std::string> measured = state_.files().read(kMeasuredFile);
    const bool is_measured =
        state_.has("sheet") && measured && now == record::sha256_of(std::as_bytes(std::span(*measured)));
    const bool is_same_file = fs::weakly_canonical(state_.rig_file()) == fs::weakly_canonical(command_.rig_file);
    if (is_same_file && (now == known || is_measured)) return;
    throw UsageError(fmt::format(
        "{}: {}; {}", command_.rig_file,
        is_same_file ? fmt::format("has changed since {} was begun", state_.folder().string())
                     : fmt::format("{} is of another rig file, {}", state_.folder().string(), state_.rig_file()),
        anew_elsewhere(command_)));
  }

  /// Where this process installs the measured numbers, before anything moves. A service's rig file is its owner's to
  /// replace. @throws PermissionError
  void require_writable_rig_file() const {
    if (!session_.is_local() || state_.has("rig file")) return;
    const fs::path folder = fs::weakly_canonical(command_.rig_file).parent_path();
    if (::access(folder.c_str(), W_OK) == 0) return;
    const fs::path copy = free_name(fs::path(command_.rig_file).filename().string());
    throw PermissionError(fmt::format(
        "{0}: the measured numbers are written into it at the end, and this user may not write into {1}; nothing was "
        "moved: commission a copy (cp {2} {3}), and put that in its place afterwards (sudo cp {3} {2})",
        command_.rig_file, folder.string(), shell_word(command_.rig_file), shell_word(copy.string())));
  }

  static void require(ExitCode code, const char* why) {
    if (code != ExitCode::ok) throw Stopped{code, why};
  }

  void prepare() {
    if (state_.has("prepare")) return;
    session_.announce("step 1 of 6, doctor",
                      "checks this machine and the rig file, reads the rod. Nothing moves; a few seconds.");
    session_.ask();
    const auto [checks, code] = session_.play({"doctor", "--rig", command_.rig_file});
    if (hal::moves_machine(rig_.backend)) require(code, "mend what doctor found first");
    std::vector<std::string> read{"read"};
    if (session_.is_local()) {
      read.insert(read.end(), {"--local", "--rig", command_.rig_file});
    } else {
      read.insert(read.end(), {"--socket", command_.socket.string()});
    }
    const auto [rod, read_code] = session_.play(read);
    require(read_code, "the rod cannot be read");
    state_.set_rig(fs::absolute(command_.rig_file).string(), record::sha256_of_file(command_.rig_file));
    state_.finish("prepare", {{"doctor_exit_code", static_cast<int>(code)},
                              {"checks", checks.value("checks", Json::array())},
                              {"rod", rod}});
  }

  /// Describes the motion of the valve's measurement.
  [[nodiscard]] std::string way_of_sheet() const {
    const config::Centring centring = config::centring_of(rig_.limits);
    const double null_V = rig_.limits.following ? rig_.limits.following->null_V : rig_.limits.safe_V;
    const double most_V = (config::characterisation_plan(rig_).table_V.array() - null_V).abs().maxCoeff();
    const std::string volts =
        fmt::format("with up to {:.1f} V about the null, and what keeps it there: fast on a fast rod", most_V);
    if (!centring.window_in) {
      return fmt::format(
          "the rod moves about the middle of its travel, {}. 2 to 3 min; record and trial then take 3 to 5.", volts);
    }
    const DisplayUnit unit = console_.unit(rig_.units);
    const auto length = [&](double in) { return fmt::format("{:.3g}", unit.factor("in") * in); };
    return fmt::format(
        "nothing is known of the valve, so the rod first explores {} to {} {} of its travel, at {:.2g} {}; then it "
        "moves about the middle, {}. 4 to 6 min; record and trial then take 3 to 5.",
        length(centring.middle_in - *centring.window_in), length(centring.middle_in + *centring.window_in),
        unit.of("in"), unit.factor("in/s") * place::kExploring_in_per_s, unit.of("in/s"), volts);
  }

  /// Path of the rig file with the measured numbers.
  [[nodiscard]] fs::path measured_file() const { return state_.file(kMeasuredFile); }

  void measure_valve() {
    if (state_.has("sheet")) return;
    session_.announce("step 2 of 6, valve sheet", way_of_sheet());
    session_.ask_before_motion();
    state_.files().make();
    state_.files().remove(kMeasuredFile);  // remains of an unfinished step
    state_.files().require_own(kMeasuredFile);
    std::vector<std::string> words{"characterise", "-o", measured_file().string()};
    if (command_.ruler) words.insert(words.end(), {"--ruler", *command_.ruler});
    auto [sheet, code] = session_.drive(std::move(words));
    if (code == ExitCode::safety_trip && rig_.limits.following && is_of_table(sheet.value("run", ""))) {
      throw Stopped{code, fmt::format("the valve was not measured; if rod, sensor and hydraulics are sound, comment "
                                      "[following] out in {}, then {}",
                                      command_.rig_file, anew_elsewhere(command_))};
    }
    require(code, "the valve was not measured");
    state_.finish("sheet", std::move(sheet));
  }

  /// Whether a wrong [following] can have ended a run.
  [[nodiscard]] bool is_of_table(const std::string& run) const {
    try {
      const record::Manifest manifest = record::read_manifest(run);
      return may_be_of_following(trip_of(manifest));
    } catch (const Error& error) {
      console_.debug(error.what());
      return false;
    }
  }

  /// Refuses a measured file that differs from the rig file in more than the valve's numbers: limits are the owner's.
  void require_owners_limits(const std::string& text) const {
    const config::RigConfig measured = config::parse_rig(text, measured_file().string());
    if (measured.limits.following && rig_text_with(rig_, *measured.limits.following) == text) return;
    throw DataError(fmt::format("{}: differs from {} in more than the valve's numbers, and is not installed; {}",
                                measured_file().string(), command_.rig_file, anew_elsewhere(command_)));
  }

  /// Writes the measured numbers into the rig file.
  void install_numbers() {
    if (!state_.has("rig file")) {
      const std::optional<std::string> measured = state_.files().read(kMeasuredFile);
      if (!measured) {
        throw DataError(fmt::format("{}: is missing; {}", measured_file().string(), anew_elsewhere(command_)));
      }
      const std::string& text = *measured;
      const fs::path before = state_.file(kFileBefore);
      if (os::read_file(command_.rig_file) != text) {
        require_owners_limits(text);
        if (!session_.is_local()) {
          throw Stopped{ExitCode::interrupted, "install the measured rig file: " +
                                                   put_in_force(measured_file(), command_.rig_file, command_.socket)};
        }
        session_.announce("step 3 of 6, rig file",
                          fmt::format("the valve's numbers are written into {}; the file as it was is kept as {}. "
                                      "Nothing moves.",
                                      command_.rig_file, before.string()));
        session_.ask();
        refuse_what_does_not_fit();  // checked again: it may have been changed meanwhile
        state_.files().write(kFileBefore, os::read_file(command_.rig_file));
        replace_rig_file(command_.rig_file, text);
      }
      state_.set_rig(fs::absolute(command_.rig_file).string(), record::sha256_of_file(command_.rig_file));
      state_.finish("rig file", {{"file", command_.rig_file}, {"before", before.string()}});
    }
    rig_ = config::load_rig(command_.rig_file);
  }

  /// Returns the upper end of the excited band: a quarter of the corner frequency of the sheet's lag, with enough ticks
  /// a period.
  [[nodiscard]] double highest_Hz() const {
    const Json& lag = state_.result("sheet").value("lag_s", Json());
    const double corner_Hz =
        lag.is_number() && lag.get<double>() > 0.0 ? 0.5 / (std::numbers::pi * lag.get<double>()) : 10.0;
    return std::min({kHighest_Hz, std::max(0.25 * corner_Hz, 0.5 * kHighest_Hz),
                     1.0 / (kTicksAPeriod * rig_.realtime.sample_period_s)});
  }

  [[nodiscard]] static std::string excitation_file(int attempt) {
    return attempt == 1 ? "excitation.toml" : fmt::format("excitation_{}.toml", attempt);
  }

  /// Designs the excitation, and plays it after a question.
  fs::path played(int attempt) {
    const std::string file = state_.file(excitation_file(attempt)).string();
    state_.files().remove(excitation_file(attempt));
    state_.files().require_own(excitation_file(attempt));
    const int repetitions = attempt == 1 ? kRepetitions : kFurtherRepetitions;
    session_.announce(
        fmt::format("step 4 of 6, record, run {} of at most {}", attempt, kAttempts),
        fmt::format(
            "the rod follows tones up to {:.1f} Hz about the middle of its travel, the way is "
            "below. At most {:g} min; it ends early when the gain is known to {:g} %. Then the trial, 2 to 3 min.",
            highest_Hz(), std::ceil(repetitions * kPeriod_s / 60.0), command_.precision_percent));
    const Played design = session_.play(
        {"design", "--rig", command_.rig_file, "--band", fmt::format("{:g}:{:.4g}", kLowest_Hz, highest_Hz()),
         "--tones", "20", "--period", fmt::format("{:g}", kPeriod_s), "--repetitions", fmt::format("{}", repetitions),
         "--precision", fmt::format("{:g}", command_.precision_percent), "-o", file});
    require(design.code, "no excitation fits the rig");
    session_.ask_before_motion();
    state_.files().require_own(excitation_file(attempt));
    const auto [run, code] = session_.drive({"run", file}, Results::hide);
    if (code != ExitCode::ok && code != ExitCode::model_rejected && code != ExitCode::not_converged) {
      throw Stopped{code, code == ExitCode::interrupted ? "" : "the record is not whole"};
    }
    return run.at("run").get<std::string>();
  }

  /// Returns a run that an earlier attempt recorded completely before the commissioning was stopped; fits it if
  /// necessary.
  std::optional<fs::path> recorded_before(int attempt) {
    const std::optional<std::string> text = state_.files().read(excitation_file(attempt));
    if (!text) return std::nullopt;
    const fs::path sheet = state_.result("sheet").at("run").get<std::string>();
    std::optional<fs::path> found;
    bool is_fitted = false;
    for (const fs::path& run : record::list_runs(sheet.parent_path())) {
      if (run.filename() <= sheet.filename()) continue;
      const record::Manifest manifest = record::read_manifest(run);
      const Json& header = manifest.other;
      const bool is_own = header.contains("experiment") && header.at("experiment").value("text", "") == *text;
      if (!is_own || !acquisition::is_whole(record::outcome_text(manifest))) continue;
      found = run;
      is_fitted = manifest.identification.has_value();
    }
    if (!found) return std::nullopt;
    console_.info(fmt::format("recorded before, and not played again: {}", found->string()));
    if (!is_fitted && !session_.is_local()) {
      throw Stopped{ExitCode::interrupted, "the service is still fitting it; `eha status` shows when it is done"};
    }
    if (!is_fitted) static_cast<void>(session_.play({"fit", found->string()}, Results::hide));
    return found;
  }

  void record_motion() {
    if (state_.has("record")) return;
    std::optional<Recorded> best;
    for (int attempt = 1; attempt <= kAttempts; ++attempt) {
      std::optional<fs::path> run = recorded_before(attempt);
      if (!run) run = played(attempt);
      Recorded recorded = recorded_in(*run);
      const std::optional<Recorded> before = best;
      if (recorded.model && (!best || recorded.gain_percent < best->gain_percent)) best = recorded;
      if (before) console_.info(why_taken(*best, best->folder == recorded.folder ? *before : recorded));
      if (best && best->gain_percent <= command_.precision_percent) break;
      if (attempt < kAttempts) {
        console_.info(best ? fmt::format("{} and {:g} % are wanted: a further run follows, the last one",
                                         gain_known(*best), command_.precision_percent)
                           : std::string("no model passes: a further run follows, the last one"));
      }
    }
    if (!best) {
      for (int attempt = 1; attempt <= kAttempts; ++attempt) state_.files().remove(excitation_file(attempt));
      throw Stopped{ExitCode::model_rejected, "no model of the records passes; their reports say why"};
    }
    Json record{{"run", best->folder.string()},
                {"outcome", best->outcome},
                {"wanted_percent", command_.precision_percent},
                {"gain_percent", std::isfinite(best->gain_percent) ? Json(best->gain_percent) : Json(nullptr)},
                {"model", *best->model}};
    if (const std::string missed = missed_precision(record); !missed.empty()) console_.warning(missed);
    console_.print(
        answer_text(answer_of_run(best->folder, record::read_manifest(best->folder)), console_.unit(rig_.units)));
    state_.finish("record", std::move(record));
  }

  void make_controller() {
    if (state_.has("tune")) return;
    session_.announce("step 5 of 6, controller",
                      "a controller is designed from the model and tried on 50 simulated rigs. Nothing moves; some "
                      "seconds.");
    session_.ask();
    const std::string file = state_.file(kControllerFile).string();
    state_.files().remove(kControllerFile);  // remains of an unfinished step
    state_.files().require_own(kControllerFile);
    auto [tuned, code] =
        session_.play({"tune", state_.result("record").at("run").get<std::string>(), "--sheet",
                       state_.result("sheet").at("run").get<std::string>(), "--rig", command_.rig_file, "-o", file});
    require(code, "no controller was made");
    state_.finish("tune", std::move(tuned));
  }

  /// Says what comes before everything else on a rig whose valve sheet shows a leak. @returns whether it does
  bool tell_leak() {
    const auto leak = leak_in_sheet();
    if (!leak) return false;
    console_.warning(fmt::format("the rig leaks: {}. Repair that first, then commission it anew, into another folder:",
                                 ident::leak_text(*leak, console_.unit(rig_.units))));
    console_.next_step(again(elsewhere(command_)));
    return true;
  }

  [[nodiscard]] std::optional<ident::Leak> leak_in_sheet() const {
    if (!state_.has("sheet")) return std::nullopt;
    return record::leak_in(state_.result("sheet").at("run").get<std::string>());
  }

  void try_controller() {
    if (state_.has("track")) return;
    if (const Json trips = state_.result("tune").value("trips", Json()); trips.is_string()) {
      throw Stopped{ExitCode::model_rejected,
                    fmt::format("the trial is left out, nothing moved: it would trip on this rig ({}), as step 5 says",
                                trips.get<std::string>()),
                    "once that is mended, " + anew_elsewhere(command_)};
    }
    session_.announce("step 6 of 6, trial",
                      "the rod follows a step, trapezoids, a sweep and a sine, and rests for 60 s, in closed loop, "
                      "under every limit of the rig file. 2 to 3 min.");
    session_.ask_before_motion();
    state_.files().require_own(kControllerFile);
    auto [track, code] = session_.drive({"track", state_.file(kControllerFile).string()});
    if (code != ExitCode::ok && code != ExitCode::model_rejected) throw Stopped{code, "the trial is not whole"};
    state_.finish("track", std::move(track));
  }

  /// Whether the record was long enough to judge the recommended model.
  [[nodiscard]] bool is_model_judged() const {
    const Json& record = state_.result("record");
    const fs::path run = record.at("run").get<std::string>();
    const std::vector<ident::Model> models = answer_of_run(run, record::read_manifest(run)).models;
    const auto model = std::find_if(models.begin(), models.end(), [&](const ident::Model& one) {
      return one.name == record.at("model").get<std::string>();
    });
    return model == models.end() || !model->verdict || !needs_longer_record(*model->verdict);
  }

  ExitCode conclude() {
    const fs::path page = state_.file(kReport);
    state_.files().write(kReport,
                         commission_page(state_, rig_.name, again(elsewhere(command_)), console_.unit(rig_.units)));
    const bool is_kept = state_.result("track").at("kept").get<bool>();
    const std::string verdict = !is_kept
                                    ? "the axis does not keep the controller's promise"
                                    : std::string("the axis keeps the controller's promise: the trial measured it") +
                                          (is_model_judged() ? "" : ", which the short record alone could not");
    const ExitCode code = is_kept ? ExitCode::ok : ExitCode::model_rejected;
    const auto leak = leak_in_sheet();
    console_.print(fmt::format("\n{}: {}{}. Report of the whole: {}", rig_.name, verdict,
                               leak ? ", and the rig leaks" : "", page.string()));
    const fs::path before = state_.result("rig file").value("before", "");
    std::error_code ignored;
    if (fs::exists(before, ignored)) {
      console_.print(
          fmt::format("{} has the valve's measured numbers; as it was before: {}", command_.rig_file, before.string()));
    }
    console_.print_json({{"schema", "eha-commission/1"},
                         {"folder", state_.folder().string()},
                         {"steps", state_.document().at("steps")},
                         {"kept", is_kept},
                         {"report", page.string()},
                         {"exit_code", static_cast<int>(code)}});
    if (!tell_leak()) console_.next_step("xdg-open " + shell_word(page.string()));
    return code;
  }

  const CommissionCommand& command_;
  Console& console_;
  config::RigConfig rig_;
  CommissionSession session_;
  CommissionState state_;
};

ExitCode execute(const CommissionCommand& command, Console& console) {
  try {
    return Commissioning(command, console).execute();
  } catch (const Json::exception& error) {
    throw DataError(
        fmt::format("{}: its commission.json or a file that it names is damaged ({}); begin anew in another "
                    "folder with -o",
                    command.folder.string(), error.what()));
  }
}

}  // namespace

void add_commission(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("commission", "From an unknown rig to a verified axis, step by step");
  sub->footer(kCommissionFooter);
  auto& commission = options_of<CommissionCommand>(*sub, line);
  sub->add_option("rig", commission.rig_file, "Rig file (TOML); the valve's numbers are written into it")
      ->required()
      ->type_name("RIG");
  sub->add_option("-o,--output", commission.folder, "Folder for the files of the commissioning (default commission)")
      ->type_name("FOLDER");
  sub->add_option("--precision", commission.precision_percent,
                  "Wanted 95 % interval of the gain: +- this (default 2 %)")
      ->type_name("PERCENT")
      ->check(finite_number("a positive number", [](double x) { return x > 0.0; }));
  sub->add_option("--ruler", commission.ruler,
                  "Where a ruler shows the rod, such as 2.95in or 75mm; a machine without [following] asks for it")
      ->type_name("LENGTH");
  CLI::Option* local =
      sub->add_flag("--local", commission.local, "Drive a machine in this process instead of through ehad");
  add_socket_option(*sub, commission.socket)->excludes(local);
  sub->add_flag("--fast", commission.fast, "Virtual time: as fast as this machine computes; simulated rigs only");
  sub->add_flag("--yes", commission.yes, "Ask nothing; simulated rigs only");
  sub->add_flag("--allow-non-realtime", commission.allow_non_realtime,
                "Run even without real-time privileges, for test benches");
}

}  // namespace eha::cli
