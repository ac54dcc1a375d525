// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/experiment_config.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Decimation of displayed data of a run that is not fitted; computations from its record use every row.
constexpr int kUnfittedDecimation = 40;

void read_identification(Section& root, ExperimentConfig& experiment) {
  Identification asked = experiment.identification();
  root.table("identification", asked, Need::optional);
  using Procedures = Identification::Procedures;
  experiment.fit.procedure =
      asked.procedures == Procedures::paper ? ident::Procedure::paper : ident::Procedure::standard;
  experiment.compares_with_paper = asked.procedures == Procedures::both;
  experiment.fit.seed = asked.seed;
}

constexpr double kTrackHold_s = 60.0;  // as in the promise
constexpr double kLongestHold_s = 600.0;

constexpr double kSweepErrorShare = 0.3;  // share of the following error that is a fault

constexpr double kLongestReference_s = 3600.0;
constexpr std::size_t kMostSetPoints = 5000;

/// Returns the fault in the user's set points; empty: none.
std::string reference_fault(const ident::TrialPlan& plan) {
  const std::vector<ident::SetPoint>& points = plan.reference;
  if (points.size() < 2 || points.size() > kMostSetPoints) return fmt::format("{}", points.size());
  const std::optional<ident::BadSetPoint> bad = ident::bad_set_point(plan);
  if (!bad) return {};
  const ident::SetPoint& point = points[bad->index];
  switch (bad->fault) {
    case ident::SetPointFault::first_not_at_zero:
      return fmt::format("the first at {:g} s", point.time_s);
    case ident::SetPointFault::not_later:
      return fmt::format("{:g} s after {:g} s", point.time_s, points[bad->index - 1].time_s);
    case ident::SetPointFault::outside_travel:
      return fmt::format("{:.4g} in at {:g} s", point.position, point.time_s);
  }
  return {};
}

/// [track]: reads the text of the controller's file and the trial's options.
Track read_track(Section& section, ExperimentConfig& experiment, Document& document) {
  std::string text;
  section.lines("controller", text);
  Track track;
  section.text("controller_file", track.controller_file, Need::optional);
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
  bool sweeps = false;  // as in records made before the sweep existed
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
  if (!document.issues.clean("track")) return track;
  const ident::AxisSettings& settings = track.controller.settings;
  if (!track.plan.reference.empty()) {
    if (const std::string fault = reference_fault(track.plan); !fault.empty()) {
      add_fault(document, "track.reference",
                fmt::format("2 to {} set points within {:g} to {:g} in, the first at 0 s, then later and later",
                            kMostSetPoints, track.plan.lowest, track.plan.highest),
                fault);
      return track;
    }
    experiment.duration_s =
        static_cast<double>(ident::TrialMotion(settings, track.plan, settings.reference.lowest).rows()) *
        settings.tick_s;
    return track;
  }
  const double half_in = 0.5 * (settings.reference.highest - settings.reference.lowest);
  if (track.plan.step + track.plan.sine > half_in) {
    add_fault(document, "track.step_in",
              fmt::format("with sine_in at most half of the controller's travel, {:g} in", half_in),
              fmt::format("{:g} in", track.plan.step + track.plan.sine));
    return track;
  }
  if (sweeps) {
    track.plan.sweep =
        ident::margin_sweep(settings, track.plan.step, kSweepErrorShare * track.controller.fault.following_error_in);
  }
  const ident::TrialMotion motion(settings, track.plan, settings.reference.lowest);
  experiment.duration_s = static_cast<double>(motion.rows()) * settings.tick_s;
  return track;
}

/// Reads an experiment of a kind that is not fitted and whose duration follows from its own table.
void read_unfitted(Section& root, ExperimentConfig& experiment, std::string_view why) {
  experiment.fit.discard_s = 0.0;
  experiment.fit.decimation = kUnfittedDecimation;
  for (const char* key : {"duration_s", "repetitions", "excitation", "place", "hold", "precision", "model"}) {
    root.forbid(key, why);
  }
}

SheetRun read_sheet_run(Section& root, Section& own, ExperimentConfig& experiment) {
  SheetRun kind;
  own.finish();
  experiment.duration_s = ident::kSheetDuration_s;
  read_unfitted(root, experiment, "[characterise], which plays what the valve sheet needs");
  root.optional_table("start", kind.start);
  return kind;
}

Tracking read_tracking(Section& root, Section& own, ExperimentConfig& experiment, Document& document) {
  Tracking kind{.track = read_track(own, experiment, document)};
  read_unfitted(root, experiment, "[track], which plays the trial of a controller");
  root.optional_table("start", kind.start);
  return kind;
}

Placing read_placing(Section& root, ExperimentConfig& experiment) {
  Placing kind;
  root.table("place", kind);
  for (const char* key : {"excitation", "start", "hold", "precision", "model"}) {
    root.forbid(key, "[place], which plays nothing");
  }
  experiment.fit.discard_s = 0.0;
  return kind;
}

Played read_played(Section& root, const ExperimentConfig& experiment, Document& document) {
  Played kind;
  root.optional_table("start", kind.start);
  root.optional_table("precision", kind.precision);
  root.optional_table("hold", kind.hold);
  if (auto section = root.section("excitation")) {
    read_excitation(*section, kind.excitation, document);
    section->finish();
  }
  if (kind.precision && experiment.repetitions < 2 && document.issues.clean("repetitions")) {
    add_fault(document, "repetitions", "2 or more with [precision], which ends the run after one of them",
              fmt::format("{}", experiment.repetitions));
  }
  return kind;
}

void read_kind(Section& root, ExperimentConfig& experiment, Document& document) {
  if (auto characterise = root.section("characterise", Need::optional)) {
    experiment.kind = read_sheet_run(root, *characterise, experiment);
    return;
  }
  if (auto track = root.section("track", Need::optional)) {
    experiment.kind = read_tracking(root, *track, experiment, document);
    return;
  }
  root.number("duration_s", experiment.duration_s, Range{.low = 0.0, .high = kLongestRun_s, .low_excluded = true});
  root.integer("repetitions", experiment.repetitions, 1, 1000, Need::optional);
  if (root.has("place")) {
    experiment.kind = read_placing(root, experiment);
  } else {
    experiment.kind = read_played(root, experiment, document);
  }
}

ExperimentConfig read_experiment(Document& document) {
  ExperimentConfig experiment;
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.file_stem("name", experiment.name);
  read_kind(root, experiment, document);
  root.table_of<RecordKeys>("record", experiment.fit, Need::optional);
  read_identification(root, experiment);
  experiment.models = read_models(root, document);
  root.table_of<AcceptanceKeys>("acceptance", experiment.acceptance, Need::optional);
  root.finish();
  check_models(experiment.models, experiment.fit.procedure, document);
  const bool has_duration = document.issues.clean("duration_s") && document.issues.clean("track");
  if (has_duration && document.issues.clean("record.discard_s") && experiment.fit.discard_s >= experiment.duration_s) {
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
    const Played* played = prepared.config.played();
    if (played != nullptr && played->hold && prepared.table_V.size() > 0 && document.issues.clean("hold")) {
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
