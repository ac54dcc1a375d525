// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/experiment_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <utility>

#include "config/excitation_section.hpp"
#include "config/experiment_check.hpp"
#include "config/file_kind.hpp"
#include "config/model_config.hpp"
#include "config/prepared_experiment.hpp"
#include "config/toml_section.hpp"
#include "core/error.hpp"
#include "ident/valve/sheet_plan.hpp"

namespace eha::config {
namespace {

using ident::Procedure;

enum class Procedures { standard, paper, both };
constexpr auto kProcedures = std::to_array<std::pair<std::string_view, Procedures>>(
    {{"default", Procedures::standard}, {"paper", Procedures::paper}, {"both", Procedures::both}});
/// Of the data for people of a characterisation; its valve sheet takes every row.
constexpr int kSheetDecimation = 40;
constexpr std::int64_t kAnySeed = std::numeric_limits<std::int64_t>::max();

void read_record(Section& root, ident::FitOptions& fit) {
  auto section = root.section("record", Need::optional);
  if (!section) return;
  section->number("discard_s", fit.discard_s, Range::between(0.0, kLongestRun_s), Need::optional);
  section->integer("decimation", fit.decimation, 1, 100'000, Need::optional);
  section->number("split", fit.split, Range{.low = 0.0, .high = 1.0, .low_excluded = true}, Need::optional);
  section->number("input_before_V", fit.input_before, Range::any());
  section->finish();
}

void read_identification(Section& root, ExperimentConfig& experiment) {
  auto section = root.section("identification", Need::optional);
  if (!section) return;
  Procedures procedures = Procedures::standard;
  section->choice("procedure", procedures, kProcedures, Need::optional);
  experiment.fit.procedure = procedures == Procedures::paper ? Procedure::paper : Procedure::standard;
  experiment.compares_with_paper = procedures == Procedures::both;
  section->integer("seed", experiment.fit.seed, 0, kAnySeed, Need::optional);
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
  section->number("usable_gain_error_dB", acceptance.usable_gain_error_dB, Range::above(0.0), Need::optional);
  section->number("usable_phase_error_deg", acceptance.usable_phase_error_deg, Range::above(0.0), Need::optional);
  section->finish();
}

constexpr double kTrackHold_s = 60.0;  // as the promise
constexpr double kLongestHold_s = 600.0;

constexpr double kSweepErrorShare = 0.3;  // of the error that is a fault

constexpr double kLongestReference_s = 3600.0;
constexpr std::size_t kMostSetPoints = 5000;

/// What is wrong with set points of one's own; empty: nothing.
std::string reference_fault(const ident::TrialPlan& plan) {
  const std::vector<ident::SetPoint>& points = plan.reference;
  if (points.size() < 2 || points.size() > kMostSetPoints) return fmt::format("{}", points.size());
  if (points.front().time_s != 0.0) return fmt::format("the first at {:g} s", points.front().time_s);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && !(points[i].time_s > points[i - 1].time_s)) {
      return fmt::format("{:g} s after {:g} s", points[i].time_s, points[i - 1].time_s);
    }
    if (points[i].position < plan.lowest || points[i].position > plan.highest) {
      return fmt::format("{:.4g} in at {:g} s", points[i].position, points[i].time_s);
    }
  }
  return {};
}

/// [track]: the controller's file as text, and what of its trial is not as usual.
void read_track(Section& section, ExperimentConfig& experiment, Document& document) {
  std::string text;
  section.text("controller", text);
  Track track;
  if (document.issues.clean("track.controller")) {
    try {
      track.controller = parse_controller(text, "controller");
      track.plan = ident::trial_plan(track.controller.settings);
    } catch (const Error& error) {
      add_fault(document, "track.controller", "the text of a controller file", error.what());
    }
  }
  track.plan.hold_s = kTrackHold_s;
  section.number("step_in", track.plan.step, Range::above(0.0), Need::optional);
  section.number("sine_in", track.plan.sine, Range::above(0.0), Need::optional);
  section.number("sine_Hz", track.plan.sine_Hz, Range::above(0.0), Need::optional);
  section.integer("trapezoids", track.plan.trapezoids, 1, 1000, Need::optional);
  bool sweeps = false;  // as of the runs before there was a sweep
  section.boolean("sweep", sweeps, Need::optional);
  section.number("hold_s", track.plan.hold_s, Range::between(0.0, kLongestHold_s), Need::optional);
  std::vector<Section> points = section.sections("reference", Need::optional);
  for (Section& point : points) {
    ident::SetPoint& set = track.plan.reference.emplace_back();
    point.number("time_s", set.time_s, Range::between(0.0, kLongestReference_s));
    point.number("displacement_in", set.position, Range::any());
    point.finish();
  }
  section.finish();
  if (!document.issues.clean("track")) return;
  const ident::AxisSettings& settings = track.controller.settings;
  if (!track.plan.reference.empty()) {
    if (const std::string fault = reference_fault(track.plan); !fault.empty()) {
      add_fault(document, "track.reference",
                fmt::format("2 to {} set points within {:g} to {:g} in, the first at 0 s, then later and later",
                            kMostSetPoints, track.plan.lowest, track.plan.highest),
                fault);
      return;
    }
    experiment.duration_s =
        static_cast<double>(ident::TrialMotion(settings, track.plan, settings.reference.lowest).rows()) *
        settings.tick_s;
    experiment.track = std::move(track);
    return;
  }
  const double half_in = 0.5 * (settings.reference.highest - settings.reference.lowest);
  if (track.plan.step + track.plan.sine > half_in) {
    add_fault(document, "track.step_in",
              fmt::format("with sine_in at most half of the controller's travel, {:g} in", half_in),
              fmt::format("{:g} in", track.plan.step + track.plan.sine));
    return;
  }
  if (sweeps) {
    track.plan.sweep =
        ident::margin_sweep(settings, track.plan.step, kSweepErrorShare * track.controller.fault.following_error_in);
  }
  const ident::TrialMotion motion(settings, track.plan, settings.reference.lowest);
  experiment.duration_s = static_cast<double>(motion.rows()) * settings.tick_s;
  experiment.track = std::move(track);
}

/// Where the rod is to be.
void read_motion(Section& root, ExperimentConfig& experiment) {
  if (auto section = root.section("place", Need::optional)) {
    double place_in = 0.0;
    section->number("displacement_in", place_in, Range::any());
    section->boolean("way_back", experiment.brings_back, Need::optional);
    section->finish();
    experiment.place_in = place_in;
    return;
  }
  if (auto section = root.section("start", Need::optional)) {
    double start_in = 0.0;
    section->number("displacement_in", start_in, Range::any());
    section->finish();
    experiment.start_in = start_in;
  }
  if (auto section = root.section("precision", Need::optional)) {
    section->number("gain_percent", experiment.precision.emplace().gain_percent, Range::above(0.0));
    section->finish();
  }
  if (auto section = root.section("hold", Need::optional)) {
    experiment.hold.emplace();
    section->number("gain_V_per_in", experiment.hold->gain_V_per_in, Range::above(0.0));
    section->finish();
  }
}

ExperimentConfig read_experiment(Document& document) {
  ExperimentConfig experiment;
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.file_stem("name", experiment.name);
  if (auto section = root.section("characterise", Need::optional)) {
    section->finish();
    experiment.characterises = true;
    experiment.duration_s = ident::kSheetDuration_s;
    experiment.fit.discard_s = 0.0;
    experiment.fit.decimation = kSheetDecimation;
    for (const char* key : {"duration_s", "repetitions", "excitation", "place", "hold", "precision", "model"}) {
      root.forbid(key, "[characterise], which plays what the valve sheet needs");
    }
  } else if (auto tracked = root.section("track", Need::optional)) {
    read_track(*tracked, experiment, document);
    experiment.fit.discard_s = 0.0;
    experiment.fit.decimation = kSheetDecimation;
    for (const char* key : {"duration_s", "repetitions", "excitation", "place", "hold", "precision", "model"}) {
      root.forbid(key, "[track], which plays the trial of a controller");
    }
  } else {
    root.number("duration_s", experiment.duration_s, Range{.low = 0.0, .high = kLongestRun_s, .low_excluded = true});
    root.integer("repetitions", experiment.repetitions, 1, 1000, Need::optional);
  }
  read_motion(root, experiment);
  if (experiment.characterises || document.positions.contains("track")) {
    // Nothing more is asked for.
  } else if (experiment.place_in) {
    for (const char* key : {"excitation", "start", "hold", "precision", "model"}) {
      root.forbid(key, "[place], which plays nothing");
    }
    experiment.fit.discard_s = 0.0;
  } else if (auto section = root.section("excitation")) {
    read_excitation(*section, experiment.excitation, document);
    section->finish();
  }
  read_record(root, experiment.fit);
  read_identification(root, experiment);
  experiment.models = read_models(root, document);
  read_acceptance(root, experiment.acceptance);
  root.finish();
  check_models(experiment.models, experiment.fit.procedure, document);
  if (experiment.precision && experiment.repetitions < 2 && document.issues.clean("repetitions")) {
    add_fault(document, "repetitions", "2 or more with [precision], which ends the run after one of them",
              fmt::format("{}", experiment.repetitions));
  }
  if (document.issues.clean("duration_s") && document.issues.clean("record.discard_s") &&
      experiment.fit.discard_s >= experiment.duration_s) {
    add_fault(document, "record.discard_s", fmt::format("less than duration_s = {}", experiment.duration_s),
              fmt::format("{}", experiment.fit.discard_s));
  }
  return experiment;
}

/// @param rig  checked against the experiment; none: the table stays empty
PreparedExperiment parse(std::string_view text, const std::string& file_name, NamedFiles named_files,
                         const RigConfig* rig) {
  Document document = parse_document(text, file_name, named_files);
  PreparedExperiment prepared;
  prepared.config = read_experiment(document);
  if (rig != nullptr) {
    prepared.table_V = check_table(prepared.config, document.positions, *rig, document.issues);
    if (prepared.config.hold && document.issues.clean("hold")) {
      prepared.predicted_in = predicted_displacement(prepared.config, *rig, prepared.table_V);
    }
  }
  document.issues.throw_if_any();
  prepared.config.file_name = file_name;
  prepared.config.text = std::string(text);
  prepared.config.positions = std::move(document.positions);
  return prepared;
}

}  // namespace

ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name, NamedFiles named_files) {
  return parse(text, file_name, named_files, nullptr).config;
}

ExperimentConfig load_experiment(const std::string& path) {
  return parse_experiment(read_config_file(path), path, NamedFiles::read);
}

PreparedExperiment parse_prepared_experiment(std::string_view text, const std::string& file_name, const RigConfig& rig,
                                             NamedFiles named_files) {
  return parse(text, file_name, named_files, &rig);
}

PreparedExperiment load_prepared_experiment(const std::string& path, const RigConfig& rig) {
  return parse_prepared_experiment(read_config_file(path), path, rig, NamedFiles::read);
}

}  // namespace eha::config
