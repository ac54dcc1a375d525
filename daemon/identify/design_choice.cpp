// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/design_choice.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "config/experiment_config.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::identify {
namespace {

constexpr int kScreened = 4;               // records of each design, each searched from the known model alone
constexpr int kConfirmed = 6;              // records of the best ones, each fitted like the real one
constexpr std::size_t kFinalists = 2;      // always confirmed
constexpr std::size_t kMostFinalists = 4;  // confirmed while none of them is predictable
constexpr double kPredictable = 2.25;  // highest over lowest error of the trials: either is within 1.5 of their middle
constexpr double kShareOfScreening = 0.2;  // of the time

/// A design in the form of its file: structure and volts.
struct Written {
  replay::TrialTask task;
  Eigen::VectorXd volts;
};

replay::TrialTask trial_task(const DesignPredictor& predictor, const config::ExperimentConfig& written,
                             const ident::ImprovementTask& task) {
  return {.structure = written.models.at(0),
          .options = task.options,
          .parameter = predictor.parameter,
          .step_s = task.limits.step_s};
}

config::ExperimentConfig experiment_of(const DesignPredictor& predictor, const ident::ImprovementTask& task,
                                       const ident::Improvement& design) {
  const std::string text = experiment_text({predictor.model, predictor.parameter, "trial"}, task, design);
  return config::parse_experiment(text, "the designed experiment", config::NamedFiles::refuse);
}

Written written(const DesignPredictor& predictor, const ident::ImprovementTask& task,
                const ident::Improvement& design) {
  const config::ExperimentConfig experiment = experiment_of(predictor, task, design);
  const auto samples = static_cast<std::size_t>(std::llround(task.duration_s / task.limits.step_s));
  return {trial_task(predictor, experiment, task),
          ident::excitation(experiment.played()->excitation, task.limits.step_s, samples)};
}

ChosenDesign tried_out(const DesignPredictor& predictor, const ident::ImprovementTask& task,
                       const ident::Improvement& design, int records, ident::Search search) {
  Written experiment = written(predictor, task, design);
  experiment.task.records = records;
  experiment.task.options.search = search;
  if (search == ident::Search::known) experiment.task.known = {predictor.model};
  ChosenDesign chosen{design, replay::trial(*predictor.twin, experiment.volts, experiment.task, predictor.executor)};
  chosen.design.std = chosen.trial->std;
  return chosen;
}

double worst_trial(const ChosenDesign& design) { return design.trial.value_or(replay::Trial{}).highest; }

bool is_predictable(const ChosenDesign& design) {
  const replay::Trial trial = design.trial.value_or(replay::Trial{});
  return std::isfinite(trial.highest) && trial.highest <= kPredictable * trial.lowest;
}

bool is_better(const ChosenDesign& a, const ChosenDesign& b) {
  if (is_predictable(a) != is_predictable(b)) return is_predictable(a);
  return worst_trial(a) < worst_trial(b);
}

}  // namespace

ident::ExcitationLimits excitation_limits(const config::RigConfig& rig) {
  return {.lowest_V = rig.limits.command_min_V,
          .highest_V = rig.limits.command_max_V,
          .slew_V_per_s = rig.limits.slew_V_per_s,
          .lowest_output = rig.limits.travel_min_in,
          .highest_output = rig.limits.travel_max_in,
          .step_s = rig.realtime.sample_period_s};
}

ChosenDesign choose_design(const DesignPredictor& predictor, const ident::ImprovementTask& task) {
  const std::vector<ident::Improvement> designs = ident::improvements(predictor.model, predictor.parameter, task);
  if (!predictor.twin) return {designs.front()};
  double done = 0.0;
  const auto advance = [&](double share) {
    if (predictor.progress) predictor.progress(done += share);
  };
  std::vector<ChosenDesign> tried;
  for (const ident::Improvement& design : designs) {
    tried.push_back(tried_out(predictor, task, design, kScreened, ident::Search::known));
    advance(kShareOfScreening / static_cast<double>(designs.size()));
  }
  std::sort(tried.begin(), tried.end(),
            [](const ChosenDesign& a, const ChosenDesign& b) { return worst_trial(a) < worst_trial(b); });
  std::optional<ChosenDesign> best;
  for (std::size_t k = 0; k < std::min(kMostFinalists, tried.size()); ++k) {
    if (k >= kFinalists && is_predictable(*best)) break;
    ChosenDesign finalist = tried_out(predictor, task, tried[k].design, kConfirmed, task.options.search);
    if (!best || is_better(finalist, *best)) best = std::move(finalist);
    advance((1.0 - kShareOfScreening) / static_cast<double>(kMostFinalists));
  }
  return *std::move(best);
}

ChosenDesign prolonged(const DesignPredictor& predictor, const ident::Improvement& design,
                       const ident::ImprovementTask& longer) {
  if (!predictor.twin) return choose_design(predictor, longer);
  return tried_out(predictor, longer, design, kConfirmed, ident::Search::known);
}

double predicted_by(const DesignPredictor& predictor, const config::PreparedExperiment& experiment,
                    const ident::ImprovementTask& task) {
  if (!predictor.twin) {
    return ident::predicted_std(predictor.model, predictor.parameter, experiment.table_V, task);
  }
  // Uses the model's structure, not one of the experiment's.
  const ident::Improvement none{.tones = {{1.0 / task.period_s, 1.0, 0.0}}};
  replay::TrialTask trial = trial_task(predictor, experiment_of(predictor, task, none), task);
  trial.records = kConfirmed;
  return replay::trial(*predictor.twin, experiment.table_V, trial, predictor.executor).std;
}

}  // namespace eha::identify
