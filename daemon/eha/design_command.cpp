// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/design_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/designed_improvement.hpp"
#include "daemon/eha/flat_design.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::cli {
namespace {

constexpr const char* kDesignFooter = R"(
Shows what an experiment would play: peak [V], RMS [V], crest factor, fastest change [V/s], excited lines [Hz].
The rig is that of --rig, else a running service's, else the default one; the answer names its file.
With -o the table of volts is written as CSV (time_s,voltage_V), one row a tick.
--from with --improve writes the experiment that minimises the standard error of a model's parameter within the rig's
limits of voltage, slew and travel. It shows the predicted standard error, the duration and the limit that binds. On a
simulated rig, or with --twin, each design is tried out: played there and fitted like the real record. --to makes the
experiment as long as the wanted standard error needs, at most 600 s; a message says if that is not enough.
--band writes an experiment (default band.toml) with tones of equal amplitude spread over a band. Their phases keep the
peaks of volts, slew and travel low, their amplitude is the largest within the rig's limits, and the rod is held. With
--odd-random the tones are three of each four odd multiples of 1/period, with other random phases in each realisation:
distortion then shows beside the lines, and at the lines in the spread of the realisations.

Examples:
  eha design config/experiments/paper.toml
  eha design sweep.toml -o sweep.csv
  eha design --from models/fo.json --improve n2 --to 0.05
  eha design --band 0.05:1.5 --tones 30 -o band.toml
  eha design --band 0.1:2 --period 10 --odd-random --realisations 6)";

/// The table as CSV; each time is the nearest double to a whole number of ticks.
std::string table_csv(const Eigen::VectorXd& table_V, double step_s) {
  std::vector<double> time_s(static_cast<std::size_t>(table_V.size()));
  // A tick is a decimal fraction of a second. If its reciprocal is a whole number, dividing by it prints 0.003 instead
  // of 0.0030000000000000001.
  const double rate_Hz = std::round(1.0 / step_s);
  const bool whole = std::abs(rate_Hz * step_s - 1.0) < 1e-12;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    time_s[k] = whole ? static_cast<double>(k) / rate_Hz : static_cast<double>(k) * step_s;
  }
  return record::series_csv(time_s, {"voltage", "V"}, table_V);
}

/// The command with the rig file of the service where it names none.
DesignCommand with_rig(DesignCommand command, const Console& console) {
  if (command.rig_file) return command;
  const auto service = rig_of_service(command.socket, console);
  if (!service) return command;
  if (access(service->file.c_str(), R_OK) != 0) {
    console.warning(fmt::format("{}, the rig file of the service: you may not read it, so that another one is taken",
                                service->file));
    return command;
  }
  require_as_read(*service);
  command.rig_file = service->file;
  command.of_service = access_of(*service, command.socket);
  return command;
}

}  // namespace

suggest::RigAccess access_of_design(const DesignCommand& command, const config::RigConfig& rig) {
  return command.of_service ? *command.of_service : access_of_rig(rig, command.rig_file);
}

std::string limits_of_design(const DesignCommand& command, const config::RigConfig& rig) {
  return fmt::format("for the limits of {}{}", rig.file_name,
                     command.of_service ? ", the rig of the service; --rig names another rig file"
                     : command.rig_file ? ""
                                        : "; --rig names another rig file");
}

std::string written_for(const std::filesystem::path& file, const DesignCommand& command, const config::RigConfig& rig) {
  return fmt::format("written: {}, {}", file.string(), limits_of_design(command, rig));
}

ExitCode execute(const DesignCommand& given, Console& console) {
  const DesignCommand command = with_rig(given, console);
  if (command.model_file) return design_improvement(command, console);
  if (command.band) return design_flat(command, console);
  if (!command.experiment_file) {
    throw UsageError(
        "expected an experiment to show, a band to fill: --band LOW:HIGH, or a model to improve: --from MODEL "
        "--improve NAME");
  }
  const std::string& experiment_file = *command.experiment_file;
  if (command.output && command.output->extension() != ".csv" && command.output->extension() != ".txt") {
    const std::string csv = shell_word(std::filesystem::path(*command.output).replace_extension(".csv").string());
    throw UsageError(
        fmt::format("-o {0}: the volts are written as CSV; a picture of them: eha design {1} -o {2} && eha plot {2} "
                    "-o {3}",
                    command.output->string(), shell_word(experiment_file), csv,
                    shell_word(std::filesystem::path(*command.output).replace_extension(".png").string())));
  }
  const config::RigConfig rig = load_rig_or_default(command.rig_file);
  const config::PreparedExperiment prepared = config::load_prepared_experiment(experiment_file, rig);
  const config::ExperimentConfig& experiment = prepared.config;
  const double step_s = rig.realtime.sample_period_s;
  const Eigen::VectorXd& table_V = prepared.table_V;
  const auto samples = static_cast<std::size_t>(table_V.size());
  const std::vector<double> lines_Hz = experiment.played()
                                           ? ident::excited_lines(experiment.played()->excitation, step_s, samples)
                                           : std::vector<double>();
  const double peak_V = table_V.cwiseAbs().maxCoeff();
  const double rms_V = std::sqrt(table_V.squaredNorm() / static_cast<double>(samples));
  const double slew_V_per_s =
      samples < 2
          ? 0.0
          : (table_V.tail(table_V.size() - 1) - table_V.head(table_V.size() - 1)).cwiseAbs().maxCoeff() / step_s;
  const bool constant = table_V.maxCoeff() - table_V.minCoeff() <= 0.0;
  if (command.output) os::write_file_atomically(*command.output, table_csv(table_V, step_s));

  nlohmann::ordered_json document{{"schema", "eha-design/1"},
                                  {"experiment", experiment_file},
                                  {"rig", rig.file_name},
                                  {"samples", samples},
                                  {"step_s", step_s},
                                  {"duration_s", experiment.duration_s},
                                  {"peak_V", peak_V},
                                  {"rms_V", rms_V},
                                  {"max_slew_V_per_s", slew_V_per_s}};
  if (!constant) document["crest_factor"] = ident::crest_factor(table_V);
  document["lines_Hz"] = lines_Hz;
  if (command.output) document["file"] = command.output->string();
  console.print_json(document);

  console.print(fmt::format("{}: {} samples of {:g} s ({:g} s), {} repetition{}", experiment.name, samples, step_s,
                            experiment.duration_s, experiment.repetitions, experiment.repetitions == 1 ? "" : "s"));
  console.print(limits_of_design(command, rig));
  console.print(
      fmt::format("peak {:.4g} V (rig: {:g}..{:g} V), RMS {:.4g} V{}, fastest change {:.4g} V/s (rig: {:g} V/s)",
                  peak_V, rig.limits.command_min_V, rig.limits.command_max_V, rms_V,
                  constant ? "" : fmt::format(", crest factor {:.4g}", ident::crest_factor(table_V)), slew_V_per_s,
                  rig.limits.slew_V_per_s));
  if (!lines_Hz.empty()) {
    constexpr std::size_t kShown = 12;
    const std::vector<double> shown(lines_Hz.begin(),
                                    lines_Hz.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, lines_Hz.size())));
    console.print(fmt::format("{} lines: {:.6g}{} Hz", lines_Hz.size(), fmt::join(shown, ", "),
                              lines_Hz.size() > kShown ? fmt::format(", ..., {:.6g}", lines_Hz.back()) : ""));
  }
  if (const auto sentence = config::off_grid_tones(experiment)) console.warning(*sentence);
  if (command.output) console.print(fmt::format("written: {}", command.output->string()));
  console.next_step(run_of(experiment, rig, access_of_design(command, rig), console));
  return ExitCode::ok;
}

void add_design(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand(
      "design", "Show or write the excitation of an experiment, or design one that improves a model");
  sub->footer(kDesignFooter);
  auto& design = options_of<DesignCommand>(*sub, line);
  sub->add_option("experiment", design.experiment_file,
                  "Experiment file (TOML); with --from it sets duration and [record] and is compared with the design")
      ->type_name("EXPERIMENT");
  CLI::Option* rig = sub->add_option("--rig", design.rig_file,
                                     "Rig file whose tick and limits apply (default: the service's, else the default "
                                     "one)")
                         ->type_name("RIG");
  add_socket_option(*sub, design.socket)->excludes(rig);
  sub->add_option("-o,--output", design.output,
                  "CSV file to write the table of volts to; with --from the experiment (default improve-NAME.toml)")
      ->type_name("FILE");
  CLI::Option* from =
      sub->add_option("--from", design.model_file, "Model file to improve, as `eha fit` wrote it")->type_name("MODEL");
  CLI::Option* improve =
      sub->add_option("--improve", design.parameter, "Parameter whose standard error is to become small")
          ->type_name("NAME")
          ->needs(from);
  from->needs(improve);
  CLI::Option* band = sub->add_option_function<std::string>(
                             "--band", [&design](const std::string& text) { design.band = band_of(text); },
                             "Write an experiment with tones of equal amplitude in this band [Hz]")
                          ->type_name("LOW:HIGH")
                          ->excludes(from);
  CLI::Option* odd_random = sub->add_flag_callback(
                                   "--odd-random", [&design] { design.realisations = design.realisations.value_or(6); },
                                   "Fill the band with odd lines of random phases, which separate noise and distortion")
                                ->needs(band);
  sub->add_option("--realisations", design.realisations, "Realisations of other phases, 2 to 50 (default 6)")
      ->type_name("M")
      ->needs(odd_random)
      ->check(CLI::Range(2, 50).description(""));
  sub->add_option("--tones", design.tones, "Tones in the band, 2 to 500 (default 30)")
      ->type_name("N")
      ->needs(band)
      ->excludes(odd_random)
      ->check(CLI::Range(2, 500).description(""));
  sub->add_option("--repetitions", design.repetitions,
                  "With --band: play the period so often, each a repetition (default three periods as one)")
      ->type_name("N")
      ->needs(band)
      ->excludes(odd_random)
      ->check(CLI::Range(2, 1000).description(""));
  sub->add_option("--precision", design.precision_percent,
                  "With --band and --repetitions: end the run once the gain's 95 % interval is +- this [%]")
      ->type_name("PERCENT")
      ->needs("--repetitions")
      ->check(finite_number("a positive number", [](double x) { return x > 0.0; }));
  sub->add_option("--period", design.period_s, "Period of the tones, 1 to 1000 s (default 20); 1/period is their grid")
      ->type_name("SECONDS")
      ->needs(band)
      ->check(finite_number("seconds from 1 to 1000", [](double s) { return s >= 1.0 && s <= 1000.0; }));
  sub->add_option("--twin", design.twin_file,
                  "Simulated rig that predicts, as `eha replay --calibrate` writes it (default: --rig where simulated)")
      ->type_name("RIG")
      ->needs(from);
  sub->add_option("--to", design.wanted_std, "Wanted standard error; the experiment becomes as long as that takes")
      ->type_name("STD")
      ->needs(from)
      ->check(finite_number("a number above 0", [](double s) { return s > 0.0; }));
}

}  // namespace eha::cli
