// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/improved_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/error.hpp"
#include "ident/structure/structures.hpp"

namespace eha::identify {
namespace {

using ident::Model;
using ident::ParameterEstimate;
using ident::ParameterRole;

constexpr double kWorthIt = 0.8;  // of the standard error

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

ident::ImprovementTask task_within(const Source& source) {
  const ident::Record& record = source.record;
  ident::ImprovementTask task;
  task.duration_s = source.experiment->duration_s;
  task.options = source.experiment->fit;
  task.period_s = 0.5 * (task.duration_s - task.options.discard_s);
  const Eigen::Index rest = record.input.size() - 1;
  task.limits = {
      .lowest_V = record.input.minCoeff(),
      .highest_V = record.input.maxCoeff(),
      .slew_V_per_s = (record.input.tail(rest) - record.input.head(rest)).cwiseAbs().maxCoeff() / record.step_s,
      .lowest_output = record.output.minCoeff(),
      .highest_output = record.output.maxCoeff(),
      .step_s = record.step_s};
  return task;
}

double std_of(const Model& model, const std::string& parameter) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name == parameter) return p.std;
  }
  return std::nan("");
}

}  // namespace

std::string experiment_text(const Improved& improved, const ident::ImprovementTask& task,
                            const ident::Improvement& found) {
  std::string text = fmt::format(
      "# {}: the standard error of {}\n# is predicted as {:.3g}; the {} limit keeps the excitation from being larger.\n"
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

std::optional<NextExperiment> improved_experiment(const Source& source, const std::vector<const Model*>& models) {
  if (!source.experiment || source.record.input.size() < 2) return {};
  const Model* best = nullptr;
  for (const Model* model : models) {
    if (!undetermined(*model)) continue;
    if (best == nullptr || model->estimation->information->ar_bic < best->estimation->information->ar_bic) best = model;
  }
  if (best == nullptr) return {};
  const std::string parameter = *undetermined(*best);
  const double now = std_of(*best, parameter);
  const ident::ImprovementTask task = task_within(source);
  try {
    const ident::Improvement found = ident::improve(*best, parameter, task);
    if (!(found.std <= kWorthIt * now)) return {};
    NextExperiment next;
    next.text =
        experiment_text({*best, parameter, fmt::format("For {} after {}", best->name, source.name)}, task, found);
    (void)config::parse_experiment(next.text, std::string(kNextExperimentFile), config::NamedFiles::leave);
    next.reason = fmt::format(
        "within the voltage and travel of this record it shrinks the standard error of {} of {} most, from {:.3g} to a "
        "predicted {:.3g}",
        parameter, best->name, now, found.std);
    return next;
  } catch (const ConfigError&) {
    return {};  // a parameter that no tones improve, or no room for any
  }
}

}  // namespace eha::identify
