// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/last_round.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/shell_word.hpp"
#include "daemon/identify/designed_experiment.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "daemon/identify/rounds.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {
namespace {

/// Names the command that designs an experiment on a rig that the record does not know, after a semicolon; empty where
/// the rig is known, as the command would be refused as well.
std::string by_hand(const Source& source, const std::filesystem::path& folder, const WeakParameter& weak) {
  if (!source.rig_text.empty()) return {};
  const std::string file = weak.model + ".json";
  return fmt::format("; `eha design --from {} --improve {}`, with --rig and the rig file of the record, designs them{}",
                     folder.empty() ? "DIR/" + shell_word(file) : shell_word((folder / file).string()),
                     shell_quoted(weak.parameter), folder.empty() ? ", once -o DIR has written the model" : "");
}

/// Length that is asked for of a record that is too short to judge a model; 0: none is.
double asked_for_s(const IdentificationTask& task) { return task.piece ? task.piece->enough_s : 0.0; }

/// The verdict on the recommended model; null without one.
const ident::Verdict* verdict_on_recommended(const Identification& identification) {
  for (const IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    if (model.name == identification.recommendation.model && model.verdict) return &*model.verdict;
  }
  return nullptr;
}

}  // namespace

void end_with_experiment(const Source& source, const IdentificationTask& task, const Progress& progress,
                         Identification& identification) {
  if (source.outcome == acquisition::Outcome::faulted) return;  // the same excitation would end as this one did
  std::string reason = identification.recommendation.reason;
  const auto end_round = [&](std::string what) {
    identification.rounds.push_back({.what = std::move(what), .reason = reason, .kind = Round::Kind::experiment});
  };
  std::vector<const ident::Model*> models;
  for (const IdentifiedModel& identified : identification.models) models.push_back(&identified.result.model);
  identification.next_experiment = longer_experiment(source, asked_for_s(task));
  const std::optional<WeakParameter> weak = weak_parameter(models);
  // Tones for one parameter would give a record that is as short.
  if (!weak || (task.piece && identification.next_experiment)) {
    if (identification.next_experiment) end_round(identification.next_experiment->what);
    return;
  }
  const auto model = std::find_if(models.begin(), models.end(), [&](const auto* m) { return m->name == weak->model; });
  DesignedExperiment designed = designed_experiment(source, **model, weak->parameter, task.options, progress);
  if (designed.next) {
    identification.next_experiment = std::move(designed.next);
    end_round(fmt::format("an experiment designed for {} of {}", weak->parameter, weak->model));
    return;
  }
  const std::string why = fmt::format("; no tones could be designed for {} of {}: {}{}", weak->parameter, weak->model,
                                      designed.refusal, by_hand(source, task.models_folder, *weak));
  if (reason.ends_with('.')) reason.pop_back();
  reason += why;
  if (identification.next_experiment) identification.next_experiment->reason += why;
  end_round(identification.next_experiment ? identification.next_experiment->what : "a new experiment");
}

void add_longer_experiment(const Source& source, const IdentificationTask& task, Identification& identification) {
  const ident::Verdict* verdict = verdict_on_recommended(identification);
  if (verdict == nullptr || source.outcome == acquisition::Outcome::faulted) return;
  const ident::FirstStep first = next_step_of(identification).first;
  const bool asks_nothing_else = first == ident::FirstStep::none || first == ident::FirstStep::longer_record;
  if (!asks_nothing_else || !(verdict->judging_part_rests || first == ident::FirstStep::longer_record)) return;
  identification.next_experiment = longer_experiment(source, asked_for_s(task));
  if (auto& next = identification.next_experiment) {
    next->reason = fmt::format("{} judge {}; {}",
                               verdict->judging_part_rests ? "nothing in the record can" : "the record is too short to",
                               identification.recommendation.model, next->reason);
  }
}

}  // namespace eha::identify
