// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/designed_improvement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/design_command.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/identify/design_choice.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/rehearsal/rehearsal.hpp"
#include "ident/design/improvement.hpp"
#include "ident/model/model_file.hpp"

namespace eha::cli {
namespace {

constexpr double kLongest_s = 600.0;
constexpr double kDuration_s = 50.0;
constexpr double kDiscard_s = 10.0;
constexpr double kHardly = 0.9;         // of the present standard error: a run that leaves more hardly helps
constexpr double kWorthAChange = 1.05;  // standard error of a given experiment over the design's that replaces it

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
    ident::ImprovementTask prolonging = task;
    prolonging.duration_s = task.options.discard_s + times * compared_s;
    ChosenDesign prolonged_one = prolonged(predictor, answer.chosen.design, prolonging);
    // A rod that drifts reaches its limits in a long experiment.
    if (!(prolonged_one.design.std < answer.chosen.design.std)) break;
    answer.chosen = std::move(prolonged_one);
    task.duration_s = prolonging.duration_s;
  }
  answer.reached = answer.chosen.design.std <= wanted;
  return answer;
}

/// Whether a model has a parameter of a name.
bool has_parameter(const Model& model, const std::string& name) {
  return std::any_of(model.parameters.begin(), model.parameters.end(), [&](const auto& p) { return p.name == name; });
}

/// The parameter that a figure of the answer stands for: T of a lag, with or without an integrator, is the one
/// estimated coefficient of its denominator. Other names are returned as they are.
/// @throws UsageError  the figure is made of several parameters
std::string parameter_of_figure(const Model& model, const std::string& name) {
  constexpr std::array<std::string_view, 4> kFigures{"T", "TD", "f0", "D"};
  if (has_parameter(model, name) || std::find(kFigures.begin(), kFigures.end(), name) == kFigures.end()) return name;
  std::vector<std::string> of_denominator;
  std::vector<std::string> estimated;
  std::ptrdiff_t terms = 0;
  for (const ident::ParameterEstimate& p : model.parameters) {
    const bool is_below = p.role == ident::ParameterRole::denominator_coefficient;
    if (is_below && (!p.fixed || std::abs(p.value) > 0.0)) ++terms;
    if (p.fixed || (!is_below && p.role != ident::ParameterRole::numerator_coefficient)) continue;
    if (is_below) of_denominator.push_back(p.name);
    estimated.push_back(p.name);
  }
  if (name == "T" && of_denominator.size() == 1 && terms == 2) return of_denominator.front();
  throw UsageError(
      fmt::format("--improve {}: no single parameter of {}, whose figures are made of {}; name one of them", name,
                  model.name, fmt::join(estimated, ", ")));
}

/// What may improve a parameter that a design does not.
struct BetterDesign {
  std::string sentence;
  std::optional<std::string> command = {};
};

/// @param std  of the best design of task.duration_s
BetterDesign better_design(const DesignCommand& command, const ident::ImprovementTask& task, double std, double now) {
  constexpr double kShare = 0.7;  // of the present standard error, worth a run
  const double compared_s = task.duration_s - task.options.discard_s;
  const double longest = std * std::sqrt(compared_s / (kLongest_s - task.options.discard_s));
  if (command.wanted_std || longest > kShare * now) {
    return {"nor would a longer one, by much; wider limits of the rig or less noise of the sensor would"};
  }
  std::string design = "eha design";
  if (command.experiment_file) design += " " + shell_word(*command.experiment_file);
  design += fmt::format(" --from {} --improve {} --to {:.2g}", shell_word(*command.model_file), command.parameter,
                        kShare * now);
  if (command.rig_file) design += " --rig " + shell_word(*command.rig_file);
  if (command.twin_file) design += " --twin " + shell_word(*command.twin_file);
  if (command.output) design += " -o " + shell_word(command.output->string());
  return {"a longer one may, which --to designs", design};
}

/// Warns of an experiment whose rehearsed rods reach a limit. @returns whether `eha run` does not refuse it for that
bool is_playable(const std::filesystem::path& file, const config::RigConfig& rig, const Console& console) {
  const config::PreparedExperiment experiment = config::load_prepared_experiment(file.string(), rig);
  const double place_in = start_of(rig);
  const std::optional<Rehearsal> rehearsal = rehearse(experiment, rig, place_in);
  judge_travel({experiment, rig, place_in, rehearsal}, file.string(), TravelRisk::accept, console);
  return !rehearsal || rehearsal->chance_of_trip < kRefusedChanceOfTrip;
}

}  // namespace

ExitCode design_improvement(const DesignCommand& given, Console& console) {
  const config::RigConfig rig = load_rig_or_default(given.rig_file);
  const Model model = ident::model_from_text(os::read_file(*given.model_file), *given.model_file);
  DesignCommand command = given;
  command.parameter = parameter_of_figure(model, given.parameter);
  if (command.parameter != given.parameter) {
    console.info(fmt::format("{} is the parameter {} of {}", given.parameter, command.parameter, model.name));
  }
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
  const bool suffices = with_base && (!command.wanted_std || !answer.reached || *with_base <= *command.wanted_std);
  const bool keeps_given = suffices && *with_base <= kWorthAChange * found.std;
  const std::filesystem::path path = keeps_given
                                         ? std::filesystem::path(*command.experiment_file)
                                         : command.output.value_or(fmt::format("improve-{}.toml", command.parameter));
  if (!keeps_given) {
    const std::string text =
        identify::experiment_text({model, command.parameter,
                                   fmt::format("Made by `eha design --from {} --improve {}`",
                                               shell_word(*command.model_file), command.parameter)},
                                  task, found);
    // Does not write an experiment that the rig would refuse.
    (void)config::parse_prepared_experiment(text, path.string(), rig);
    os::write_file_atomically(path, text);
  }

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
  const double offered = keeps_given ? *with_base : found.std;
  document["improves"] = offered < now;
  document["keeps_experiment"] = keeps_given;
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
  const DisplayUnit unit = console.unit(rig.units);
  console.print(fmt::format(
      "{} tones, peak {:.3g} V, fastest change {:.3g} V/s, predicted travel {:.3g} to {:.3g} {}; the {} limit binds",
      found.tones.size(), found.peak_V, found.peak_slew_V_per_s, unit.factor("in") * found.lowest_output,
      unit.factor("in") * found.highest_output, unit.of("in"), ident::text(found.binding)));
  if (!answer.reached) {
    console.print(fmt::format("{:g} is not reachable within these limits and {:g} s", *command.wanted_std, kLongest_s));
  }
  const bool improves = offered < now;
  const bool hardly = improves && offered > kHardly * now;
  BetterDesign better;
  if (!improves || hardly) {
    better = better_design(command, task, offered, now);
    const std::string gain = hardly ? fmt::format("hardly improves {}, by {:.2g} % of its standard error",
                                                  command.parameter, 100.0 * (1.0 - offered / now))
                                    : fmt::format("does not improve {}", command.parameter);
    console.print(fmt::format("this experiment {}: {}", gain, better.sentence));
  }
  console.print(keeps_given ? fmt::format("{} is kept, no design is better by 5 %: nothing is written", path.string())
                            : written_for(path, command, rig));
  if (improves && is_playable(path, rig, console) && !(hardly && better.command)) {
    console.next_step(suggest::run(access_of_design(command, rig), {path.string()}));
  }
  if (better.command) console.next_step(*better.command);
  return ExitCode::ok;
}

}  // namespace eha::cli
