// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/one_sided_map.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/criterion.hpp"

namespace eha::identify {
namespace {

/// Whether a map is refused for the sign of its gain below the dead band alone, which the record does not show: as of a
/// pump, whose input reaches that side with its noise.
bool may_be_one_sided(const ident::Model& model) {
  if (!model.verdict || model.verdict->accepted || !model.input_map) return false;
  const auto ratio = std::find_if(model.parameters.begin(), model.parameters.end(), [](const auto& p) {
    return p.role == ident::ParameterRole::negative_gain_ratio && !p.fixed;
  });
  if (ratio == model.parameters.end() || !(ratio->upper95 > 0.0)) return false;
  return std::none_of(model.verdict->criteria.begin(), model.verdict->criteria.end(), [](const ident::Criterion& c) {
    return c.judged && !c.passed && c.kind != ident::CriterionKind::gain_ratio &&
           ident::traits_of(c.kind).weight == ident::CriterionWeight::rejects;
  });
}

}  // namespace

void hold_one_sided_maps(const IdentificationTask& task, Identification& identification) {
  if (task.options.procedure == ident::Procedure::paper || is_loop_noted(identification)) return;
  std::optional<ident::PreparedRecord> prepared;
  bool any = false;
  for (IdentifiedModel& one : identification.models) {
    if (!may_be_one_sided(one.result.model)) continue;
    if (!prepared) prepared.emplace(task.record, task.options);
    ident::StructureOptions asked = one.structure;
    asked.parameters.push_back({.name = "negative_gain_ratio", .fixed = true, .start = 0.0, .lower = {}, .upper = {}});
    ident::FitOptions options = task.options;
    options.search = ident::Search::known;
    try {
      ident::FitResult result = ident::fit(*prepared, asked, options, thread_executor(), {one.result.model});
      judge(task, excited_by(task, result), result);
      if (!result.model.verdict->accepted) continue;
      one.structure = std::move(asked);
      one.result = std::move(result);
      any = true;
    } catch (const Error&) {  // the record does not allow it
      continue;
    }
  }
  if (any) choose(task, identification);
}

}  // namespace eha::identify
