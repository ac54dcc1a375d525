// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/improvement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include "config/prepared_experiment.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/design_command.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/identify/design_choice.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/design/improvement.hpp"
#include "ident/model/model_file.hpp"

namespace eha::cli {
namespace {

constexpr double kLongest_s = 600.0;
constexpr double kDuration_s = 50.0;
constexpr double kDiscard_s = 10.0;

using ident::Model;
using identify::ChosenDesign;
using identify::DesignPredictor;

/// Interval of the samples that the model was compared at, in ticks of the rig.
int decimation_of(const Model& model, double tick_s) {
  if (!model.estimation || !model.estimation->compared_step_s) return 1;
  return std::max(1, static_cast<int>(std::lround(*model.estimation->compared_step_s / tick_s)));
}

/// Returns the simulated rig for trials of designs: the named one, or the rig itself if it is simulated.
std::optional<hal::SimOptions> twin_of(const DesignCommand& command, const config::RigConfig& rig) {
  const config::RigConfig named = command.twin_file ? load_rig_or_default(command.twin_file) : rig;
  if (const auto* simulated = std::get_if<hal::SimOptions>(&named.backend)) return *simulated;
  if (command.twin_file) {
    throw UsageError(
        fmt::format("{} drives a machine; --twin takes a simulated rig, as `eha replay RUN --calibrate` "
                    "writes it",
                    named.file_name));
  }
  return std::nullopt;
}

/// A design of at least the base's duration, and whether it reaches the wanted standard error.
struct DesignAnswer {
  ChosenDesign chosen;
  bool reached = true;
};

DesignAnswer answered(const DesignPredictor& predictor, const DesignCommand& command, ident::ImprovementTask& task) {
  DesignAnswer answer{choose_design(predictor, task)};
  if (!command.wanted_std) return answer;
  const double wanted = *command.wanted_std;
  const double compared_s = task.duration_s - task.options.discard_s;
  const double most = std::max(1.0, std::floor((kLongest_s - task.options.discard_s) / compared_s));
  // Twice the duration is equivalent to two records; a second round corrects for transient and drift.
  for (double times = 1.0; answer.chosen.design.std > wanted && times < most;) {
    const double longer = std::ceil(times * std::pow(answer.chosen.design.std / wanted, 2) - 1e-9);
    times = std::min(most, std::max(times + 1.0, longer));
    task.duration_s = task.options.discard_s + times * compared_s;
    answer.chosen = prolonged(predictor, answer.chosen.design, task);
  }
  answer.reached = answer.chosen.design.std <= wanted;
  return answer;
}

}  // namespace

ExitCode design_improvement(const DesignCommand& command, Console& console) {
  const config::RigConfig rig = load_rig_or_default(command.rig_file);
  const Model model = ident::model_from_text(os::read_file(*command.model_file), *command.model_file);
  ident::ImprovementTask task;
  task.limits = identify::excitation_limits(rig);
  task.duration_s = kDuration_s;
  task.options.discard_s = kDiscard_s;
  task.options.decimation = decimation_of(model, task.limits.step_s);
  const DesignPredictor predictor{
      model, command.parameter, twin_of(command, rig), identify::thread_executor(),
      [&](double share) { console.progress(share, "trying designs out on the simulated rig"); }};
  std::optional<double> with_base;
  if (command.experiment_file) {
    const config::PreparedExperiment base = config::load_prepared_experiment(*command.experiment_file, rig);
    task.duration_s = base.config.duration_s;
    task.options = base.config.fit;
    task.period_s = 0.5 * (task.duration_s - task.options.discard_s);
    with_base = predicted_by(predictor, base, task);
  }
  task.period_s = 0.5 * (task.duration_s - task.options.discard_s);
  const DesignAnswer answer = answered(predictor, command, task);
  console.end_progress();
  const ident::Improvement& found = answer.chosen.design;
  const std::filesystem::path path = command.output.value_or(fmt::format("improve-{}.toml", command.parameter));
  const std::string text = identify::experiment_text(
      {model, command.parameter,
       fmt::format("Made by `eha design --from {} --improve {}`", shell_word(*command.model_file), command.parameter)},
      task, found);
  // Does not write an experiment that the rig would refuse.
  (void)config::parse_prepared_experiment(text, path.string(), rig);
  os::write_file_atomically(path, text);

  const double now = identify::estimated_std(model, command.parameter);
  nlohmann::ordered_json document{{"schema", "eha-improvement/1"},
                                  {"model", *command.model_file},
                                  {"rig", rig.file_name},
                                  {"parameter", command.parameter},
                                  {"std", now},
                                  {"predicted_std", found.std},
                                  {"duration_s", task.duration_s},
                                  {"binding_limit", ident::text(found.binding)},
                                  {"peak_V", found.peak_V},
                                  {"max_slew_V_per_s", found.peak_slew_V_per_s},
                                  {"predicted_travel_in", {found.lowest_output, found.highest_output}}};
  document["predicted_by"] = predictor.twin ? "trials on the simulated rig" : "the model's residual";
  if (answer.chosen.trial)
    document["predicted_std_range"] = {answer.chosen.trial->lowest, answer.chosen.trial->highest};
  if (with_base) document["predicted_std_of_experiment"] = *with_base;
  if (command.wanted_std) {
    document["wanted_std"] = *command.wanted_std;
    document["reachable"] = answer.reached;
  }
  document["file"] = path.string();
  console.print_json(document);

  console.print(fmt::format("{}: standard error of {} now {:.3g}, predicted {:.3g} after {:g} s", model.name,
                            command.parameter, now, found.std, task.duration_s));
  if (const auto& trial = answer.chosen.trial) {
    console.print(fmt::format("by fits to simulated records of {}, between {:.3g} and {:.3g}",
                              command.twin_file.value_or(rig.name), trial->lowest, trial->highest));
  } else {
    console.warning(
        "predicted for a residual like the model's own. Friction and dead band may leave another residual at other "
        "tones: the achieved error may be a third or five times the predicted one. A simulated rig predicts better: "
        "`eha replay RUN --calibrate KEY...`, then --twin FILE");
  }
  if (with_base) {
    console.print(fmt::format("{} would give {:.3g} in {:g} s", *command.experiment_file, *with_base,
                              task.options.discard_s + 2.0 * task.period_s));
  }
  console.print(fmt::format(
      "{} tones, peak {:.3g} V, fastest change {:.3g} V/s, predicted travel {:.3g} to {:.3g} in; the {} limit binds",
      found.tones.size(), found.peak_V, found.peak_slew_V_per_s, found.lowest_output, found.highest_output,
      ident::text(found.binding)));
  if (!answer.reached) {
    console.print(fmt::format("{:g} is not reachable within these limits and {:g} s", *command.wanted_std, kLongest_s));
  }
  console.print(fmt::format("written: {}", path.string()));
  console.next_step(simulated_run(path.string(), command.rig_file));
  return ExitCode::ok;
}

}  // namespace eha::cli
