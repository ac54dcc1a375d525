// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/improved_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/model_text.hpp"
#include "core/toml_text.hpp"
#include "daemon/identify/multisine_text.hpp"

namespace eha::identify {
namespace {

using ident::Model;
using ident::ParameterEstimate;

/// Returns the parameter for which the model is rejected; nothing if it is rejected for another reason, or not
/// rejected.
std::optional<std::string> undetermined(const Model& model) {
  if (!model.verdict || model.verdict->accepted || !model.estimation || !model.estimation->information) return {};
  std::optional<std::string> first;
  for (const ident::Criterion& criterion : model.verdict->criteria) {
    if (criterion.passed) continue;
    switch (criterion.kind) {
      case ident::CriterionKind::order_error:
      case ident::CriterionKind::left_out:
      case ident::CriterionKind::coefficient_interval:
        if (!first) first = criterion.parameter;
        break;
      default:
        if (traits_of(criterion.kind).weight == ident::CriterionWeight::rejects) return {};
    }
  }
  return first;
}

bool has_standard_error(const Model& model, const std::string& parameter) {
  const double std = estimated_std(model, parameter);
  return std::isfinite(std) && std > 0.0;
}

}  // namespace

double estimated_std(const Model& model, const std::string& parameter) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name == parameter && !p.fixed) return p.std;
  }
  return std::nan("");
}

std::string experiment_text(const Improved& improved, const ident::ImprovementTask& task,
                            const ident::Improvement& found) {
  std::string text = fmt::format(
      "# {}: the standard error of {}\n# is predicted as {:.3g}; the {} limit binds.\n"
      "schema = 1\nname = \"improve-{}\"\nduration_s = {:#}\n\n{}\n\n[record]\ndiscard_s = {:#}\ndecimation = "
      "{}\nsplit = {:#}\n\n",
      toml_comment(improved.made_by), improved.parameter, found.std, ident::text(found.binding), improved.parameter,
      task.duration_s, multisine_table(found.offset_V, found.tones), task.options.discard_s, task.options.decimation,
      task.options.split);
  if (improved.model.structure) text += config::model_table(*improved.model.structure);
  return text;
}

std::optional<WeakParameter> weak_parameter(const std::vector<const Model*>& models) {
  const Model* best = nullptr;
  std::string parameter;
  for (const Model* model : models) {
    if (model->grey_box) continue;  // an experiment is designed for a linear plant
    const std::optional<std::string> weak = undetermined(*model);
    if (!weak || !has_standard_error(*model, *weak)) continue;
    if (best != nullptr && best->estimation->information->ar_bic <= model->estimation->information->ar_bic) continue;
    best = model;
    parameter = *weak;
  }
  if (best == nullptr) return {};
  return WeakParameter{best->name, parameter};
}

}  // namespace eha::identify
