// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/experiment_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <utility>

#include "config/experiment_check.hpp"
#include "config/file_kind.hpp"
#include "config/toml_section.hpp"
#include "core/error.hpp"
#include "ident/estimation/parametrisation.hpp"

namespace eha::config {
namespace {

using ident::ExcitationKind;
using ident::InitialState;
using ident::Procedure;
using ident::StructureKind;

constexpr auto kKinds = std::to_array<std::pair<std::string_view, ExcitationKind>>(
    {{"multisine", ExcitationKind::multisine},
     {"odd_random_multisine", ExcitationKind::odd_random_multisine},
     {"prms", ExcitationKind::prms},
     {"chirp", ExcitationKind::chirp},
     {"gaussian", ExcitationKind::gaussian},
     {"step", ExcitationKind::step},
     {"sine", ExcitationKind::sine}});
constexpr auto kProcedures = std::to_array<std::pair<std::string_view, Procedure>>(
    {{"default", Procedure::standard}, {"paper", Procedure::paper}});
constexpr auto kStructures =
    std::to_array<std::pair<std::string_view, StructureKind>>({{"io", StructureKind::io},
                                                               {"fo", StructureKind::fo},
                                                               {"commensurate", StructureKind::commensurate},
                                                               {"lag", StructureKind::lag}});
constexpr auto kInitialStates = std::to_array<std::pair<std::string_view, InitialState>>(
    {{"auto", InitialState::automatic}, {"none", InitialState::none}, {"estimated", InitialState::estimated}});
constexpr auto kDelays = std::to_array<std::pair<std::string_view, bool>>({{"free", true}});

constexpr std::int64_t kAnySeed = std::numeric_limits<std::int64_t>::max();
/// A day; what is longer is a slip of the unit.
constexpr double kLongestRun_s = 86400.0;

void read_tones(Section& section, ident::ExcitationOptions& excitation) {
  for (Section& entry : section.sections("tones")) {
    ident::Tone tone;
    entry.number("frequency_Hz", tone.frequency_Hz, Range::above(0.0));
    entry.number("amplitude_V", tone.amplitude_V, Range::above(0.0));
    entry.number("phase_rad", tone.phase_rad, Range::any(), Need::optional);
    entry.finish();
    excitation.tones.push_back(tone);
  }
}

/// Reads the keys that the kind has and refuses those that it would ignore.
class ExcitationReader {
 public:
  ExcitationReader(Section& section, ident::ExcitationOptions& options, Document& document)
      : section_(section), options_(options), document_(document) {}

  void read() {
    section_.choice("kind", options_.kind, kKinds);
    section_.number("offset_V", options_.offset_V, Range::any(), Need::optional);
    if (!is_clean("kind")) {
      for (const char* key :
           {"tones", "amplitude_V", "frequency_min_Hz", "frequency_max_Hz", "levels", "hold_s", "seed"}) {
        section_.ignore(key);
      }
      return;
    }
    const bool has_tones = is(ExcitationKind::multisine) || is(ExcitationKind::sine);
    if (wanted("tones", has_tones)) read_tones(section_, options_);
    if (is(ExcitationKind::sine) && options_.tones.size() > 1) {
      const std::string path = section_.path("tones");
      document_.faults.add(position_of(document_.positions, path), path, "one tone for kind = \"sine\"",
                           fmt::format("{}", options_.tones.size()));
    }
    if (wanted("amplitude_V", !has_tones)) section_.number("amplitude_V", options_.amplitude_V, Range::above(0.0));
    const bool has_lines = is(ExcitationKind::odd_random_multisine) || is(ExcitationKind::gaussian);
    read_band(has_lines || is(ExcitationKind::chirp));
    if (wanted("levels", is(ExcitationKind::prms))) section_.integer("levels", options_.levels, 3, 1000);
    if (wanted("hold_s", is(ExcitationKind::prms) || is(ExcitationKind::step))) {
      section_.number("hold_s", options_.hold_s, Range::above(0.0));
    }
    if (wanted("seed", has_lines || is(ExcitationKind::prms))) {
      section_.integer("seed", options_.seed, 0, kAnySeed, Need::optional);
    }
  }

 private:
  [[nodiscard]] bool is(ExcitationKind kind) const { return options_.kind == kind; }
  [[nodiscard]] bool is_clean(std::string_view key) const { return document_.faults.clean(section_.path(key)); }

  /// Whether the kind has the key; refuses it where not.
  bool wanted(std::string_view key, bool kind_has_it) {
    if (!kind_has_it) section_.forbid(key, fmt::format("kind = \"{}\"", kind_name()));
    return kind_has_it;
  }
  [[nodiscard]] std::string_view kind_name() const {
    return std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& kind) { return kind.second == options_.kind; })
        ->first;
  }

  void read_band(bool kind_has_it) {
    const bool has_min = wanted("frequency_min_Hz", kind_has_it);
    const bool has_max = wanted("frequency_max_Hz", kind_has_it);
    if (!has_min || !has_max) return;
    section_.number("frequency_min_Hz", options_.frequency_min_Hz, Range::at_least(0.0));
    section_.number("frequency_max_Hz", options_.frequency_max_Hz, Range::above(0.0));
    if (is_clean("frequency_min_Hz") && is_clean("frequency_max_Hz") &&
        !(options_.frequency_min_Hz < options_.frequency_max_Hz)) {
      const std::string path = section_.path("frequency_max_Hz");
      document_.faults.add(position_of(document_.positions, path), path,
                           fmt::format("more than frequency_min_Hz = {}", options_.frequency_min_Hz),
                           fmt::format("{}", options_.frequency_max_Hz));
    }
  }

  Section& section_;
  ident::ExcitationOptions& options_;
  Document& document_;
};

void add_fault(Document& document, const std::string& path, std::string_view expected, std::string_view got) {
  document.faults.add(position_of(document.positions, path), path, expected, got);
}

void read_parameters(Section& model, ident::StructureOptions& structure, Document& document) {
  for (Section& entry : model.sections("parameter", Need::optional)) {
    ident::ParameterRequest request;
    entry.text("name", request.name);
    entry.boolean("fixed", request.fixed);
    entry.number("start", request.start, Range::any());
    entry.number("lower", request.lower, Range::any());
    entry.number("upper", request.upper, Range::any());
    entry.finish();
    if (request.lower && request.upper && !(*request.lower < *request.upper)) {
      add_fault(document, entry.path("upper"), fmt::format("more than lower = {}", *request.lower),
                fmt::format("{}", *request.upper));
    } else if (request.start && ((request.lower && *request.start < *request.lower) ||
                                 (request.upper && *request.start > *request.upper))) {
      add_fault(document, entry.path("start"), "a number within lower..upper", fmt::format("{}", *request.start));
    }
    const auto same_name = [&](const ident::ParameterRequest& other) { return other.name == request.name; };
    if (!request.name.empty() && std::any_of(structure.parameters.begin(), structure.parameters.end(), same_name)) {
      add_fault(document, entry.path("name"), "each parameter once", fmt::format("\"{}\" again", request.name));
    }
    structure.parameters.push_back(std::move(request));
  }
}

ident::StructureOptions read_model(Section& section, Document& document) {
  ident::StructureOptions structure;
  structure.name.clear();
  section.file_stem("name", structure.name);
  section.choice("structure", structure.kind, kStructures);
  if (!document.faults.clean(section.path("structure"))) {
    section.ignore("poles");
    section.ignore("zeros");
  } else if (structure.kind == StructureKind::io || structure.kind == StructureKind::commensurate) {
    section.integer("poles", structure.poles, 1, 10, Need::optional);
    section.integer("zeros", structure.zeros, 0, 10, Need::optional);
    if (structure.zeros > structure.poles) {
      add_fault(document, section.path("zeros"), fmt::format("at most poles = {}", structure.poles),
                fmt::format("{}", structure.zeros));
    }
  } else {
    section.forbid("poles", "structure is neither \"io\" nor \"commensurate\"");
    section.forbid("zeros", "structure is neither \"io\" nor \"commensurate\"");
  }
  section.number("delay_s", structure.delay_s, Range::between(0.0, kLongestRun_s), Need::optional);
  section.choice("delay", structure.delay_free, kDelays, Need::optional);
  section.choice("initial_state", structure.initial_state, kInitialStates, Need::optional);
  read_parameters(section, structure, document);
  section.finish();
  return structure;
}

/// What the estimator would refuse after the experiment: names of parameters, values without which they cannot be
/// fixed.
void check_requests(const ident::StructureOptions& structure, const std::string& path, Document& document) {
  for (std::size_t i = 0; i < structure.parameters.size(); ++i) {
    ident::StructureOptions alone = structure;
    alone.parameters = {structure.parameters[i]};
    try {
      // What is asked of the parameters does not depend on the record's length and tick.
      (void)ident::Parametrisation::search(alone, {.duration_s = 1.0, .step_s = 0.001});
    } catch (const ConfigError& error) {
      const std::string parameter = fmt::format("{}.parameter[{}]", path, i);
      document.faults.add_text(position_of(document.positions, parameter + ".name"), parameter, error.what());
    }
  }
}

void check_initial_state(const ident::StructureOptions& structure, const std::string& path, Document& document) {
  if (structure.initial_state == InitialState::estimated && structure.kind == ident::StructureKind::commensurate &&
      structure.zeros > 0) {
    add_fault(document, path + ".initial_state",
              "\"auto\" or \"none\" (a past input is estimated for models without zeros)", "\"estimated\"");
  }
}

/// The paper's procedure has two structures and nothing to ask for.
void check_paper(const ident::StructureOptions& structure, const std::string& path, Document& document) {
  const bool known = structure.kind == StructureKind::fo ||
                     (structure.kind == StructureKind::io && structure.poles == 2 && structure.zeros == 0);
  if (!known) {
    add_fault(document, path, "structure \"fo\", or \"io\" with 2 poles and no zero, for procedure = \"paper\"",
              "another one");
  } else if (!structure.parameters.empty() || structure.delay_free || structure.delay_s != 0.0) {
    add_fault(document, path, "neither a delay nor parameters for procedure = \"paper\"", "some");
  }
}

void check_models(const ExperimentConfig& experiment, Document& document) {
  for (std::size_t i = 0; i < experiment.models.size(); ++i) {
    const std::string path = fmt::format("model[{}]", i);
    if (!document.faults.clean(path)) continue;
    check_requests(experiment.models[i], path, document);
    check_initial_state(experiment.models[i], path, document);
    if (experiment.fit.procedure == Procedure::paper) check_paper(experiment.models[i], path, document);
  }
}

void read_models(Section& root, ExperimentConfig& experiment, Document& document) {
  for (Section& section : root.sections("model")) {
    ident::StructureOptions structure = read_model(section, document);
    const auto same_name = [&](const ident::StructureOptions& other) { return other.name == structure.name; };
    if (!structure.name.empty() && std::any_of(experiment.models.begin(), experiment.models.end(), same_name)) {
      add_fault(document, section.path("name"), "a name that no other model has",
                fmt::format("\"{}\"", structure.name));
    }
    experiment.models.push_back(std::move(structure));
  }
}

void read_record(Section& root, ident::FitOptions& fit) {
  auto section = root.section("record", Need::optional);
  if (!section) return;
  section->number("discard_s", fit.discard_s, Range::between(0.0, kLongestRun_s), Need::optional);
  section->integer("decimation", fit.decimation, 1, 100'000, Need::optional);
  section->number("split", fit.split, Range{.low = 0.0, .high = 1.0, .low_excluded = true}, Need::optional);
  section->finish();
}

void read_identification(Section& root, ident::FitOptions& fit) {
  auto section = root.section("identification", Need::optional);
  if (!section) return;
  section->choice("procedure", fit.procedure, kProcedures, Need::optional);
  section->integer("seed", fit.seed, 0, kAnySeed, Need::optional);
  section->finish();
}

void read_acceptance(Section& root, ident::AcceptanceLimits& acceptance) {
  auto section = root.section("acceptance", Need::optional);
  if (!section) return;
  section->number("min_validation_r2_percent", acceptance.min_validation_r2_percent, Range::between(0.0, 100.0),
                  Need::optional);
  section->number("max_abs_error_in", acceptance.max_abs_error, Range::above(0.0), Need::optional);
  section->boolean("require_stable", acceptance.require_stable, Need::optional);
  section->number("min_stability_margin_rad", acceptance.min_stability_margin_rad,
                  Range::between(0.0, std::numbers::pi / 2.0), Need::optional);
  section->finish();
}

ExperimentConfig read_experiment(Document& document) {
  ExperimentConfig experiment;
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.file_stem("name", experiment.name);
  root.number("duration_s", experiment.duration_s, Range{.low = 0.0, .high = kLongestRun_s, .low_excluded = true});
  root.integer("repetitions", experiment.repetitions, 1, 1000, Need::optional);
  if (auto section = root.section("excitation")) {
    ExcitationReader(*section, experiment.excitation, document).read();
    section->finish();
  }
  read_record(root, experiment.fit);
  read_identification(root, experiment.fit);
  read_models(root, experiment, document);
  read_acceptance(root, experiment.acceptance);
  root.finish();
  check_models(experiment, document);
  if (document.faults.clean("duration_s") && document.faults.clean("record.discard_s") &&
      experiment.fit.discard_s >= experiment.duration_s) {
    add_fault(document, "record.discard_s", fmt::format("less than duration_s = {}", experiment.duration_s),
              fmt::format("{}", experiment.fit.discard_s));
  }
  return experiment;
}

ExperimentConfig parse(std::string_view text, const std::string& file_name, const RigConfig* rig) {
  Document document = parse_document(text, file_name);
  ExperimentConfig experiment = read_experiment(document);
  if (rig != nullptr) add_conflicts(experiment, document.positions, *rig, document.faults);
  document.faults.throw_if_any();
  experiment.file_name = file_name;
  experiment.text = std::string(text);
  experiment.positions = std::move(document.positions);
  return experiment;
}

}  // namespace

ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name) {
  return parse(text, file_name, nullptr);
}

ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name, const RigConfig& rig) {
  return parse(text, file_name, &rig);
}

ExperimentConfig load_experiment(const std::string& path) { return parse_experiment(read_config_file(path), path); }

ExperimentConfig load_experiment(const std::string& path, const RigConfig& rig) {
  return parse_experiment(read_config_file(path), path, rig);
}

}  // namespace eha::config
