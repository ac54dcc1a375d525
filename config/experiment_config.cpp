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
#include "config/model_config.hpp"
#include "config/toml_section.hpp"
#include "core/error.hpp"

namespace eha::config {
namespace {

using ident::ExcitationKind;
using ident::Procedure;

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
constexpr std::int64_t kAnySeed = std::numeric_limits<std::int64_t>::max();

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
  experiment.models = read_models(root, document);
  read_acceptance(root, experiment.acceptance);
  root.finish();
  check_models(experiment.models, experiment.fit.procedure, document);
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
