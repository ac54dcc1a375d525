// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/improved_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "ident/structure/structures.hpp"

namespace eha::identify {
namespace {

using ident::Model;
using ident::ParameterEstimate;
using ident::ParameterRole;

std::string base_name(const Model& model) {
  std::string name = model.name;
  for (const ident::InputMapKind& kind : ident::input_map_kinds()) {
    if (!kind.suffix.empty() && name.ends_with(kind.suffix)) name.resize(name.size() - kind.suffix.size());
  }
  return name;
}

/// The family that a model is of: by its name, or by what is estimated.
std::string family_of(const Model& model) {
  const std::string name = base_name(model);
  for (const ident::StructureFamily& family : ident::structure_families()) {
    if (family.name == name) return name;
  }
  const auto estimates = [&](ParameterRole role) {
    return std::any_of(model.parameters.begin(), model.parameters.end(),
                       [&](const ParameterEstimate& p) { return p.role == role && !p.fixed; });
  };
  if (estimates(ParameterRole::base_order)) return "commensurate";
  if (!estimates(ParameterRole::denominator_order)) return "io";
  return model.transfer_function.denominator.size() > 2 ? "fo" : "lag";
}

/// The model's [[model]] table.
std::string model_table(const Model& model) {
  const std::string family = family_of(model);
  std::string text = fmt::format("[[model]]\nname = \"{}\"\nstructure = \"{}\"\n", model.name, family);
  if (ident::structure_family(family).has_degrees) {
    text += fmt::format("poles = {}\nzeros = {}\n", model.transfer_function.denominator.size() - 1,
                        model.transfer_function.numerator.size() - 1);
  }
  if (model.input_map) text += "input_map = \"valve\"\n";
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role == ParameterRole::delay && !p.fixed) text += "delay = \"free\"\n";
    if (p.role == ParameterRole::delay && p.fixed && p.value > 0.0) text += fmt::format("delay_s = {}\n", p.value);
  }
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role != ParameterRole::numerator_order || p.fixed) continue;
    text += fmt::format("[[model.parameter]]\nname = \"{}\"\nfixed = false\n", p.name);
  }
  return text;
}

std::string with_decimal_point(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// The parameter for which the model is rejected; nothing where something else rejects it, or nothing does.
std::optional<std::string> undetermined(const Model& model) {
  if (!model.verdict || model.verdict->accepted || !model.estimation || !model.estimation->information) return {};
  std::optional<std::string> first;
  for (const ident::Criterion& criterion : model.verdict->criteria) {
    if (criterion.passed) continue;
    const std::string_view name = criterion.name;
    for (const std::string_view kind : {"std_", "left_out_", "interval_"}) {
      if (name.starts_with(kind) && !first) first = name.substr(kind.size());
    }
    const bool rejects = name.ends_with("r2_percent") || name.ends_with("max_abs_error") || name == "converged" ||
                         name == "stability_margin_rad" || name == "interpolated_percent";
    if (rejects) return {};
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
      "schema = 1\nname = \"improve-{}\"\nduration_s = {}\n\n[excitation]\nkind = \"multisine\"\noffset_V = {}\n"
      "tones = [\n",
      improved.made_by, improved.parameter, found.std, ident::text(found.binding), improved.parameter,
      with_decimal_point(task.duration_s), with_decimal_point(found.offset_V));
  for (const ident::Tone& tone : found.tones) {
    text += fmt::format("  {{ frequency_Hz = {}, amplitude_V = {}, phase_rad = {} }},\n",
                        with_decimal_point(tone.frequency_Hz), with_decimal_point(tone.amplitude_V),
                        with_decimal_point(tone.phase_rad));
  }
  text += fmt::format("]\n\n[record]\ndiscard_s = {}\ndecimation = {}\nsplit = {}\n\n",
                      with_decimal_point(task.options.discard_s), task.options.decimation,
                      with_decimal_point(task.options.split));
  return text + model_table(improved.model);
}

std::optional<WeakParameter> weak_parameter(const std::vector<const Model*>& models) {
  const Model* best = nullptr;
  std::string parameter;
  for (const Model* model : models) {
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
