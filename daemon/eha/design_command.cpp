// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/flat_design.hpp"
#include "daemon/eha/improvement.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/record/record_csv.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::cli {
namespace {

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

}  // namespace

ExitCode execute(const DesignCommand& command, Console& console) {
  if (command.model_file) return design_improvement(command, console);
  if (command.band) return design_flat(command, console);
  if (!command.experiment_file) {
    throw UsageError(
        "expected an experiment to show, a band to fill: --band LOW:HIGH, or a model to improve: --from MODEL "
        "--improve NAME");
  }
  const std::string& experiment_file = *command.experiment_file;
  const config::RigConfig rig = load_rig_or_default(command.rig_file);
  const config::PreparedExperiment prepared = config::load_prepared_experiment(experiment_file, rig);
  const config::ExperimentConfig& experiment = prepared.config;
  const double step_s = rig.realtime.sample_period_s;
  const Eigen::VectorXd& table_V = prepared.table_V;
  const auto samples = static_cast<std::size_t>(table_V.size());
  const std::vector<double> lines_Hz = ident::excited_lines(experiment.excitation, step_s, samples);
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
  for (const std::string& sentence : config::off_grid_tones(experiment)) console.warning(sentence);
  if (command.output) console.print(fmt::format("written: {}", command.output->string()));
  console.next_step(simulated_run(experiment_file, command.rig_file));
  return ExitCode::ok;
}

}  // namespace eha::cli
