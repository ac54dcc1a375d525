// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "config/rig_config.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/commission_state.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/precision/precision_watch.hpp"
#include "daemon/record/manifest.hpp"
#include "hal/backends/backend.hpp"

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
says what is done. A machine is commissioned attended, through ehad or with --local; --yes is for simulated rigs.
Exit code 3: no model passed, or the axis does not keep the controller's promise.

Examples:
  eha commission rig.toml --yes --fast
  eha commission /etc/ehad/rig.toml --ruler 74mm)";

constexpr int kRepetitions = 5;
constexpr int kFurtherRepetitions = 4;  // the whole stays within 10 min of rig time
constexpr double kPeriod_s = 10.0;
constexpr double kExploring_in_per_s = 0.028;  // see eha characterise
constexpr double kLowest_Hz = 0.1;
constexpr double kHighest_Hz = 2.0;

struct CommissionCommand {
  std::string rig_file;
  fs::path folder = "commission";
  fs::path socket = control::default_socket();
  bool local = false;
  bool fast = false;
  bool yes = false;
  bool allow_non_realtime = false;
  double precision_percent = 2.0;
  std::optional<std::string> ruler = {};
};

/// Stops the commissioning; what is done stays.
struct Stopped {
  ExitCode code;
  std::string why;
};

class Commissioning {
 public:
  Commissioning(const CommissionCommand& command, Console& console)
      : command_(command),
        console_(console),
        rig_(config::load_rig(command.rig_file)),
        moves_machine_(hal::moves_machine(rig_.backend)),
        // A simulated rig is driven here unless a service is named.
        is_local_(command.local || (!moves_machine_ && command.socket == control::default_socket())),
        state_(command.folder) {}

  ExitCode execute() {
    refuse_what_does_not_fit();
    try {
      prepare();
      measure_valve();
      record_motion();
      make_controller();
      return try_controller();
    } catch (const Stopped& stopped) {
      if (!stopped.why.empty()) console_.info(stopped.why);
      console_.info(fmt::format("to go on with this step: {}", again()));
      console_.print_json({{"schema", "eha-commission/1"},
                           {"folder", state_.folder().string()},
                           {"steps", state_.document().at("steps")},
                           {"exit_code", static_cast<int>(stopped.code)}});
      return stopped.code;
    }
  }

 private:
  void refuse_what_does_not_fit() const {
    if (moves_machine_ && command_.yes) {
      throw UsageError(fmt::format("--yes: {} moves a machine, which is commissioned attended", command_.rig_file));
    }
    const std::string known = state_.rig_sha256();
    if (!known.empty() && known != record::sha256_of_file(command_.rig_file)) {
      throw UsageError(fmt::format("{}: has changed since {} was begun; begin anew in another folder (-o)",
                                   command_.rig_file, state_.folder().string()));
    }
  }

  /// The command that goes on.
  [[nodiscard]] std::string again() const {
    std::string line = "eha commission " + shell_word(command_.rig_file);
    if (command_.folder != CommissionCommand{}.folder) line += " -o " + shell_word(command_.folder.string());
    if (command_.local) line += " --local";
    if (!is_local_ && command_.socket != control::default_socket()) {
      line += " --socket " + shell_word(command_.socket.string());
    }
    if (command_.fast) line += " --fast";
    if (command_.yes) line += " --yes";
    return line;
  }

  /// Says what comes and, where nothing else asks, asks.
  void announce(const std::string& step, const std::string& does) {
    console_.print(fmt::format("\n== {}: {}", step, does));
    console_.flush();
    if (command_.yes || (moves_machine_ && step != "doctor")) return;
    if (!console_.confirm("Go on?")) throw Stopped{ExitCode::interrupted, "not \"yes\": stopped"};
  }

  /// Executes a command line of eha in this process.
  /// @returns its document, and its exit code
  std::pair<Json, ExitCode> play(std::vector<std::string> words) {
    std::vector<std::string> quoted;
    for (const std::string& word : words) quoted.push_back(shell_word(word));
    console_.print(fmt::format("$ eha {}", fmt::join(quoted, " ")));
    console_.flush();
    words.insert(words.begin(), "eha");
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    const ParsedLine line = parse_command_line(static_cast<int>(arguments.size()), arguments.data());
    console_.keep_documents();
    ExitCode code = ExitCode::bug;
    try {
      code = line.command(console_);
    } catch (const Error& error) {
      static_cast<void>(console_.taken_documents());
      console_.end_progress();
      console_.error(error.what());
      throw Stopped{error.exit_code(), ""};
    }
    const Json documents = console_.taken_documents();
    return {documents.empty() ? Json::object() : documents.back(), code};
  }

  /// The same for a command that drives the rig.
  std::pair<Json, ExitCode> drive(std::vector<std::string> words) {
    if (is_local_) {
      words.insert(words.end(), {"--local", "--rig", command_.rig_file});
      if (command_.allow_non_realtime) words.emplace_back("--allow-non-realtime");
    } else {
      words.insert(words.end(), {"--socket", command_.socket.string()});
      static_cast<void>(play({"arm", "--socket", command_.socket.string()}));
    }
    if (command_.fast) words.emplace_back("--fast");
    if (!moves_machine_) words.emplace_back("--yes");
    return play(std::move(words));
  }

  static void require(ExitCode code, const char* why) {
    if (code != ExitCode::ok) throw Stopped{code, why};
  }

  void prepare() {
    if (state_.has("prepare")) return;
    announce("doctor", "checks this machine and the rig file, reads the rod. Nothing moves; a few seconds.");
    const auto [checks, code] = play({"doctor", "--rig", command_.rig_file});
    if (moves_machine_) require(code, "mend what doctor found first");
    std::vector<std::string> read{"read"};
    if (is_local_) {
      read.insert(read.end(), {"--local", "--rig", command_.rig_file});
    } else {
      read.insert(read.end(), {"--socket", command_.socket.string()});
    }
    const auto [rod, read_code] = play(read);
    require(read_code, "the rod cannot be read");
    state_.finish("prepare", {{"doctor_exit_code", static_cast<int>(code)}, {"rod", rod}});
  }

  void measure_valve() {
    const std::string measured = state_.file("rig.toml").string();
    if (!state_.has("sheet")) {
      const DisplayUnit unit = console_.unit(rig_.units);
      announce("valve sheet",
               rig_.limits.following
                   ? std::string("the rod moves about the middle of its travel, in small slow motions. 2 to 3 min.")
                   : fmt::format("the rod explores the middle of its travel at {:.2g} {}, then moves about it in small "
                                 "slow motions. Some 5 min.",
                                 unit.factor("in/s") * kExploring_in_per_s, unit.of("in/s")));
      std::error_code ignored;
      fs::remove(measured, ignored);  // of a step that was not finished
      os::create_folders(state_.folder());
      std::vector<std::string> words{"characterise", "-o", measured};
      if (command_.ruler) words.insert(words.end(), {"--ruler", *command_.ruler});
      auto [sheet, code] = drive(std::move(words));
      require(code, "the valve was not measured");
      state_.finish("sheet", std::move(sheet));
    }
    if (state_.has("rig file")) {
      rig_ = config::load_rig(command_.rig_file);
      return;
    }
    const std::string text = os::read_file(measured);
    if (os::read_file(command_.rig_file) != text) install(text, measured);
    rig_ = config::load_rig(command_.rig_file);
    state_.set_rig(command_.rig_file, record::sha256_of_file(command_.rig_file));
    state_.finish("rig file", {{"file", command_.rig_file}, {"before", state_.file("rig_before.toml").string()}});
  }

  /// Writes the measured numbers into the rig file, after a question.
  void install(const std::string& text, const std::string& measured) {
    if (!is_local_) {
      throw Stopped{ExitCode::interrupted,
                    fmt::format("install the measured rig file: eha disarm && sudo cp {} {} && eha reload",
                                shell_word(measured), shell_word(command_.rig_file))};
    }
    const std::string does = fmt::format("the valve's numbers are written into {}; the file as it was is kept as {}.",
                                         command_.rig_file, state_.file("rig_before.toml").string());
    console_.print("\n== rig file: " + does);
    console_.flush();
    if (!command_.yes && !console_.confirm("Go on?")) throw Stopped{ExitCode::interrupted, "not \"yes\": stopped"};
    os::write_file_atomically(state_.file("rig_before.toml"), os::read_file(command_.rig_file));
    os::write_file_atomically(command_.rig_file, text);
  }

  /// Upper end of the excited band: a quarter of the corner that the sheet's lag makes, and no more than twenty ticks
  /// a period.
  [[nodiscard]] double highest_Hz() const {
    const Json& lag = state_.result("sheet").value("lag_s", Json());
    const double corner_Hz = lag.is_number() && lag.get<double>() > 0.0 ? 1.0 / (6.2832 * lag.get<double>()) : 10.0;
    return std::clamp(0.25 * corner_Hz, 0.5 * kHighest_Hz, std::min(kHighest_Hz, 0.05 / rig_.realtime.sample_period_s));
  }

  void record_motion() {
    if (state_.has("record")) return;
    int repetitions = kRepetitions;
    Json best;
    for (int attempt = 1;; ++attempt, repetitions = kFurtherRepetitions) {
      const std::string experiment =
          state_.file(attempt == 1 ? "excitation.toml" : fmt::format("excitation_{}.toml", attempt)).string();
      announce("record",
               fmt::format("the rod moves about the middle of its travel, tones up to {:.1f} Hz, at most {:g} "
                           "min; it ends early when the gain is known to {:g} %.",
                           highest_Hz(), std::ceil(repetitions * kPeriod_s / 60.0), command_.precision_percent));
      std::vector<std::string> words{"design",
                                     "--rig",
                                     command_.rig_file,
                                     "--band",
                                     fmt::format("{:g}:{:.4g}", kLowest_Hz, highest_Hz()),
                                     "--tones",
                                     "20",
                                     "--period",
                                     fmt::format("{:g}", kPeriod_s),
                                     "--repetitions",
                                     fmt::format("{}", repetitions),
                                     "--precision",
                                     fmt::format("{:g}", command_.precision_percent),
                                     "-o",
                                     experiment};
      require(play(std::move(words)).second, "no excitation fits the rig");
      const auto [run, code] = drive({"run", experiment});
      Json result = summary_of(run);
      const bool is_usable = code == ExitCode::ok && result.value("model", "") != "";
      if (code != ExitCode::ok && code != ExitCode::model_rejected && code != ExitCode::not_converged) {
        throw Stopped{code, "the record is not whole"};
      }
      const bool is_precise = result.at("gain_percent").is_number() &&
                              result.at("gain_percent").get<double>() <= command_.precision_percent;
      // The more precise one of two.
      const auto percent_of = [](const Json& record) {
        return record.at("gain_percent").is_number() ? record.at("gain_percent").get<double>()
                                                     : std::numeric_limits<double>::infinity();
      };
      if (is_usable && (best.is_null() || percent_of(result) < percent_of(best))) best = std::move(result);
      if (!best.is_null() && (is_precise || attempt == 2)) {
        if (!is_precise) {
          console_.warning(
              fmt::format("the gain is known to +-{:.2g} % by {}, {:g} % were wanted: it goes on with this "
                          "record",
                          percent_of(best), best.value("run", ""), command_.precision_percent));
        }
        state_.finish("record", std::move(best));
        return;
      }
      if (attempt == 2) {
        throw Stopped{ExitCode::model_rejected,
                      fmt::format("no model of {} passes; its report says why", run.value("run", ""))};
      }
      console_.info(is_usable ? "the gain is not known well enough: a further run follows"
                              : "no model passes: a further run follows");
    }
  }

  /// What the later steps need of a run, by its document and folder.
  [[nodiscard]] Json summary_of(const Json& run) const {
    const std::string folder = run.value("run", "");
    Json result{{"run", folder}, {"outcome", run.value("outcome", "")}, {"wanted_percent", command_.precision_percent}};
    const fs::path precise = fs::path(folder) / precision::kPrecisionFolder / "integrator_lag_valve.json";
    std::error_code ignored;
    const double percent =
        fs::exists(precise, ignored) ? precision::gain_percent(precise) : std::numeric_limits<double>::infinity();
    result["gain_percent"] = std::isfinite(percent) ? Json(percent) : Json(nullptr);
    const record::Manifest manifest = record::read_manifest(folder);
    if (manifest.identification && manifest.identification->recommendation) {
      result["model"] = manifest.identification->recommendation->model;
      result["reason"] = manifest.identification->recommendation->reason;
    }
    return result;
  }

  void make_controller() {
    if (state_.has("tune")) return;
    announce("controller",
             "a controller is designed from the model and tried on 50 simulated rigs. Nothing moves; some "
             "seconds.");
    const std::string file = state_.file("axis.toml").string();
    std::error_code ignored;
    fs::remove(file, ignored);  // of a step that was not finished
    auto [tuned, code] =
        play({"tune", state_.result("record").at("run").get<std::string>(), "--sheet",
              state_.result("sheet").at("run").get<std::string>(), "--rig", command_.rig_file, "-o", file});
    require(code, "no controller was made");
    state_.finish("tune", std::move(tuned));
  }

  ExitCode try_controller() {
    if (!state_.has("track")) {
      announce("trial",
               "the rod follows a step, trapezoids, a sine and rests for 60 s, in closed loop, under every limit "
               "of the rig file. Some 2 min.");
      auto [track, code] = drive({"track", state_.file("axis.toml").string()});
      if (code != ExitCode::ok && code != ExitCode::model_rejected) throw Stopped{code, "the trial is not whole"};
      state_.finish("track", std::move(track));
    }
    const fs::path page = state_.file("report.html");
    os::write_file_atomically(page, commission_page(state_, rig_.name, console_.unit(rig_.units)));
    const bool is_kept = state_.result("track").at("kept").get<bool>();
    const ExitCode code = is_kept ? ExitCode::ok : ExitCode::model_rejected;
    console_.print(fmt::format(
        "\n{}: {}. Report of the whole: {}", rig_.name,
        is_kept ? "the axis keeps the controller's promise" : "the axis does not keep the controller's promise",
        page.string()));
    console_.print_json({{"schema", "eha-commission/1"},
                         {"folder", state_.folder().string()},
                         {"steps", state_.document().at("steps")},
                         {"kept", is_kept},
                         {"report", page.string()},
                         {"exit_code", static_cast<int>(code)}});
    console_.next_step("xdg-open " + shell_word(page.string()));
    return code;
  }

  const CommissionCommand& command_;
  Console& console_;
  config::RigConfig rig_;
  bool moves_machine_;
  bool is_local_;
  CommissionState state_;
};

ExitCode execute(const CommissionCommand& command, Console& console) {
  return Commissioning(command, console).execute();
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
