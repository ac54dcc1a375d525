// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/model_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "config/experiment_config.hpp"
#include "core/error.hpp"
#include "ident/coordinates/parametrisation.hpp"
#include "ident/estimation/paper_procedure.hpp"

namespace eha::config {
namespace {

using ident::Freedom;
using ident::InitialState;

constexpr std::size_t kMostModels = 64;
constexpr auto kInitialStates = std::to_array<std::pair<std::string_view, InitialState>>(
    {{"auto", InitialState::automatic}, {"none", InitialState::none}, {"estimated", InitialState::estimated}});
constexpr auto kDelays = std::to_array<std::pair<std::string_view, Freedom>>({{"free", Freedom::free}});

/// A key of the model whose path is `path`.
std::string key_of(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

void read_parameters(Section& model, ident::StructureOptions& asked, Document& document) {
  for (Section& entry : model.sections("parameter", Need::optional)) {
    ident::ParameterRequest request;
    ParameterKeys::visit_keys(request, entry);
    entry.finish();
    if (request.lower && request.upper && !(*request.lower < *request.upper)) {
      add_fault(document, entry.path("upper"), fmt::format("more than lower = {}", *request.lower),
                fmt::format("{}", *request.upper));
    } else if (request.start && ((request.lower && *request.start < *request.lower) ||
                                 (request.upper && *request.start > *request.upper))) {
      add_fault(document, entry.path("start"), "a number within lower..upper", fmt::format("{}", *request.start));
    }
    const auto same_name = [&](const ident::ParameterRequest& other) { return other.name == request.name; };
    if (!request.name.empty() && std::any_of(asked.parameters.begin(), asked.parameters.end(), same_name)) {
      add_fault(document, entry.path("name"), "each parameter once", fmt::format("\"{}\" again", request.name));
    }
    asked.parameters.push_back(std::move(request));
  }
}

/// A value of `structure`: a family, or null for a structure given term by term.
using StructureChoice = std::pair<std::string_view, const ident::StructureFamily*>;

std::vector<StructureChoice> structure_choices() {
  std::vector<StructureChoice> choices;
  for (const ident::StructureFamily& family : ident::structure_families()) choices.emplace_back(family.name, &family);
  choices.emplace_back(ident::kTermsFamily, nullptr);
  return choices;
}

std::vector<ident::TermOptions> read_terms(Section& model, std::string_view key, Need need) {
  std::vector<ident::TermOptions> terms;
  for (Section& entry : model.sections(key, need)) {
    ident::TermOptions term;
    entry.number("order", term.order, Range::any());
    entry.boolean("free", term.free, Need::optional);
    entry.number("coefficient", term.coefficient, Range::any());
    entry.number("lower", term.lower, Range::any());
    entry.number("upper", term.upper, Range::any());
    entry.finish();
    terms.push_back(term);
  }
  return terms;
}

void read_term_lists(Section& model, ident::StructureOptions& asked, Document& document) {
  ident::TermLists lists;
  lists.denominator = read_terms(model, "denominator", Need::required);
  if (model.has("numerator")) lists.numerator = read_terms(model, "numerator", Need::required);
  if (!document.issues.clean(model.path("denominator")) || !document.issues.clean(model.path("numerator"))) return;
  const std::vector<ident::TermFault> faults = faults_in_terms(lists);
  for (const ident::TermFault& fault : faults) {
    add_fault(document, model.path(fault.place), fault.expected, fault.got);
  }
  if (faults.empty()) asked.structure = structure_of_terms(lists);
}

void read_degrees(Section& model, const ident::StructureFamily& family, ident::StructureOptions& asked,
                  Document& document) {
  ident::Degrees degrees;
  model.integer("poles", degrees.poles, 1, 10, Need::optional);
  model.integer("zeros", degrees.zeros, 0, 10, Need::optional);
  if (degrees.zeros > degrees.poles) {
    add_fault(document, model.path("zeros"), fmt::format("at most poles = {}", degrees.poles),
              fmt::format("{}", degrees.zeros));
    return;
  }
  asked.structure = family.make(degrees);
}

/// Returns the reason for which a structure without degrees refuses these keys.
std::string no_degrees() {
  std::vector<std::string> names;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    if (family.has_degrees) names.push_back(fmt::format("\"{}\"", family.name));
  }
  return fmt::format("structure is neither {}", fmt::join(names, " nor "));
}

void read_structure(Section& model, Need need, ident::StructureOptions& asked, Document& document) {
  StructureChoice chosen{ident::kTermsFamily, nullptr};
  const std::vector<StructureChoice> choices = structure_choices();
  model.choice("structure", chosen.second, choices, need);
  if (!document.issues.clean(model.path("structure"))) {
    for (const char* key : {"poles", "zeros", "numerator", "denominator"}) model.ignore(key);
    return;
  }
  const ident::StructureFamily* family = chosen.second;
  if (family != nullptr && family->has_degrees) {
    read_degrees(model, *family, asked, document);
  } else {
    for (const char* key : {"poles", "zeros"}) model.forbid(key, no_degrees());
    if (family != nullptr) asked.structure = family->make({});
  }
  if (family == nullptr) {
    read_term_lists(model, asked, document);
  } else {
    const std::string why = fmt::format("structure is not \"{}\"", ident::kTermsFamily);
    for (const char* key : {"numerator", "denominator"}) model.forbid(key, why);
  }
}

/// Reads the map before G.
void read_input_map(Section& model, ident::StructureOptions& asked, Document& document) {
  std::vector<std::pair<std::string_view, const ident::InputMapKind*>> kinds;
  for (const ident::InputMapKind& kind : ident::input_map_kinds()) kinds.emplace_back(kind.name, &kind);
  const ident::InputMapKind* chosen = nullptr;
  model.choice("input_map", chosen, kinds, Need::optional);
  if (chosen == nullptr) return;
  if (asked.structure.grey_box && !chosen->suffix.empty()) {
    add_fault(document, model.path("input_map"), fmt::format("none before {}", asked.structure.family),
              fmt::format("\"{}\"", chosen->name));
    return;
  }
  asked.structure = chosen->put_before(std::move(asked.structure));
}

/// Reads the keys that every structure has.
void read_rest(Section& model, ident::StructureOptions& asked, Document& document) {
  model.number("delay_s", asked.structure.delay.value, Range::between(0.0, kLongestRun_s), Need::optional);
  model.choice("delay", asked.structure.delay.freedom, kDelays, Need::optional);
  read_input_map(model, asked, document);
  model.choice("initial_state", asked.initial_state, kInitialStates, Need::optional);
  read_parameters(model, asked, document);
  model.finish();
}

ident::StructureOptions read_model(Section& section, Document& document) {
  ident::StructureOptions asked;
  asked.name.clear();
  section.file_stem("name", asked.name);
  read_structure(section, Need::required, asked, document);
  read_rest(section, asked, document);
  return asked;
}

/// Checks the names of parameters, and that a held one has a value.
void check_requests(const ident::StructureOptions& model, const std::string& path, Document& document) {
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    ident::StructureOptions alone = model;
    alone.parameters = {model.parameters[i]};
    alone.initial_state = InitialState::automatic;
    try {
      // These checks do not depend on the record's length and tick.
      (void)ident::Parametrisation::search(alone, {.duration_s = 1.0, .step_s = 0.001});
    } catch (const ConfigError& error) {
      const std::string parameter = key_of(path, fmt::format("parameter[{}]", i));
      document.issues.add_text(position_of(document.positions, parameter + ".name"), parameter, error.what());
    }
  }
}

void check_initial_state(const ident::StructureOptions& model, const std::string& path, Document& document) {
  if (model.initial_state == InitialState::estimated && !has_finite_state(model.structure) &&
      model.structure.numerator.size() > 1) {
    add_fault(document, key_of(path, "initial_state"),
              "\"auto\" or \"none\" (a past input is estimated for models without zeros)", "\"estimated\"");
  }
}

/// The paper's procedure has two structures and no options.
void check_paper(const ident::StructureOptions& model, const std::string& path, Document& document) {
  const ident::StructureParameter& delay = model.structure.delay;
  if (!ident::published_structure(model.structure)) {
    add_fault(document, path, "structure \"fo\", or \"io\" with 2 poles and no zero, for procedure = \"paper\"",
              "another one");
  } else if (!model.parameters.empty() || delay.freedom == Freedom::free || delay.value != 0.0) {
    add_fault(document, path, "neither a delay nor parameters for procedure = \"paper\"", "some");
  }
}

}  // namespace

std::vector<ident::StructureOptions> read_models(Section& root, Document& document) {
  std::vector<ident::StructureOptions> models;
  for (Section& section : root.sections("model", Need::optional)) {
    ident::StructureOptions model = read_model(section, document);
    const auto same_name = [&](const ident::StructureOptions& other) { return other.name == model.name; };
    if (!model.name.empty() && std::any_of(models.begin(), models.end(), same_name)) {
      add_fault(document, section.path("name"), "a name that no other model has", fmt::format("\"{}\"", model.name));
    }
    models.push_back(std::move(model));
  }
  return models;
}

ident::StructureOptions read_single_model(Section& root, Document& document) {
  ident::StructureOptions asked;
  asked.name = ident::kTermsFamily;
  const bool is_named = root.has("name");
  if (is_named) root.file_stem("name", asked.name);
  root.ignore("name");
  int schema = 1;
  root.integer("schema", schema, 1, 1, Need::optional);
  read_structure(root, Need::optional, asked, document);
  read_rest(root, asked, document);
  if (!is_named) asked.name += ident::input_map_kind_of(asked.structure).suffix;
  return asked;
}

void check_model(const ident::StructureOptions& model, const std::string& path, Document& document) {
  check_requests(model, path, document);
  check_initial_state(model, path, document);
}

void check_models(const std::vector<ident::StructureOptions>& models, ident::Procedure procedure, Document& document) {
  if (models.size() > kMostModels) {
    return add_fault(document, "model", fmt::format("at most {} tables", kMostModels), std::to_string(models.size()));
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    const std::string path = fmt::format("model[{}]", i);
    if (!document.issues.clean(path)) continue;
    check_model(models[i], path, document);
    if (procedure == ident::Procedure::paper) check_paper(models[i], path, document);
  }
}

}  // namespace eha::config
