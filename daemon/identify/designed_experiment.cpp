// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/designed_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/identify/design_choice.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "daemon/identify/thread_executor.hpp"

namespace eha::identify {
namespace {

constexpr double kLongest_s = 60.0;  // limits the duration of the trials
constexpr double kDuration_s = 50.0;
constexpr double kDiscard_s = 10.0;

ident::ImprovementTask task_on(const config::RigConfig& rig, const Source& source, const ident::FitOptions& options) {
  ident::ImprovementTask task;
  task.limits = excitation_limits(rig);
  task.options = options;
  // The model is known; its neighbourhood is searched.
  task.options.search = ident::Search::known;
  task.duration_s = source.experiment ? source.experiment->duration_s : kDuration_s;
  if (task.duration_s > kLongest_s) {
    task.duration_s = kDuration_s;
    task.options.discard_s = std::min(task.options.discard_s, kDiscard_s);
  }
  task.period_s = 0.5 * (task.duration_s - task.options.discard_s);
  return task;
}

}  // namespace

DesignedExperiment designed_experiment(const Source& source, const ident::Model& model, const std::string& parameter,
                                       const ident::FitOptions& options, const Progress& progress) {
  if (source.rig_text.empty()) {
    return {.refusal = "the record does not name its rig file, so it is unknown which limits apply"};
  }
  try {
    const config::RigConfig rig = config::parse_rig(source.rig_text, source.name + "/run.json (rig)");
    const ident::ImprovementTask task = task_on(rig, source, options);
    DesignPredictor predictor{.model = model, .parameter = parameter, .executor = thread_executor()};
    if (progress) {
      predictor.progress = [&](double share) { progress(share, "trying designs out on the simulated rig"); };
    }
    if (const auto* simulated = std::get_if<hal::SimOptions>(&rig.backend)) predictor.twin = *simulated;
    const ident::Improvement design = choose_design(predictor, task).design;
    const double now = estimated_std(model, parameter);
    if (!(design.std < now)) {
      return {.refusal =
                  fmt::format("no tones within the limits of {} are predicted to lower its standard error of {:.3g}",
                              rig.name, now)};
    }
    DesignedExperiment designed;
    NextExperiment& next = designed.next.emplace();
    next.text = experiment_text({model, parameter, fmt::format("Made by the fit of {}", source.name)}, task, design);
    // Does not write an experiment that the rig would refuse.
    (void)config::parse_prepared_experiment(next.text, std::string(kNextExperimentFile), rig);
    next.reason = fmt::format(
        "tones designed for {} of {} within the limits of {}: its standard error falls from {:.3g} to {:.3g} in {:g} "
        "s, predicted by {}",
        parameter, model.name, rig.name, now, design.std, task.duration_s,
        predictor.twin ? "the simulated rig" : "the model's residual");
    return designed;
  } catch (const Error& error) {
    return {.refusal = error.what()};
  }
}

}  // namespace eha::identify
