// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/track_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/characterisation.hpp"
#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/track/track_source.hpp"

namespace eha::track {
namespace {

constexpr double kSmallNoise = 0.5;  // extremes of the noise, of the band within which the rod settles
constexpr double kExtremes = 5.0;    // standard deviations that the greatest of some 10^5 values of noise reaches

/// Estimates the noise of a rod that rests or moves smoothly, from the deviation of each reading from the mean of its
/// neighbours.
double noise_of(const TrackRows& rows, std::size_t from) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = from + 1; i + 1 < rows.rod_in.size(); ++i) {
    sum += std::pow(rows.rod_in[i - 1] - 2.0 * rows.rod_in[i] + rows.rod_in[i + 1], 2);
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / (6.0 * count)) : 0.0;
}

/// Returns the first row of the sweep; none without a whole one.
std::optional<std::size_t> sweep_begin(const TrackRows& rows, const ident::TrialMotion& motion,
                                       const ident::MarginSweep& sweep) {
  std::size_t first = 0;
  while (first < rows.rod_in.size() && motion.part(first + 1) != ident::TrialMotion::Part::sweep) ++first;
  return first + sweep.rows() <= rows.rod_in.size() ? std::optional(first) : std::nullopt;
}

/// Returns the margins from the sweep's ways, whose rows begin at `first`, in the direction of smaller phase margin.
std::optional<ident::MeasuredMargins> margins_of(const TrackRows& rows, std::size_t first,
                                                 const ident::MarginSweep& sweep, const ident::AxisSettings& settings,
                                                 bool& is_retracting) {
  std::vector<double> injected;
  for (std::size_t i = 0; i < sweep.rows(); ++i) injected.push_back(sweep.injected(i));
  std::optional<ident::MeasuredMargins> least;
  for (const std::size_t direction : {std::size_t{0}, std::size_t{1}}) {
    std::vector<ident::SweepWay> ways;
    for (std::size_t way = direction; way < sweep.ways; way += 2) {
      const std::size_t begin = way * sweep.way_rows() + sweep.lead_rows;
      ways.push_back({std::span(injected).subspan(begin, sweep.measured_rows()),
                      std::span(rows.rod_in).subspan(first + begin, sweep.measured_rows())});
    }
    ident::MeasuredMargins measured = ident::measured_margins(sweep, settings, ways);
    if (!measured.margins.is_stable) return std::nullopt;
    if (least && measured.margins.phase_deg >= least->margins.phase_deg) continue;
    least = std::move(measured);
    // The first way goes in the step's direction, or back if there is no room.
    const std::size_t middle = first + direction * sweep.way_rows() + sweep.lead_rows;
    is_retracting = rows.rod_in[middle + sweep.measured_rows() - 1] < rows.rod_in[middle];
  }
  return least;
}

/// @throws DataError  it is not a run of [track]
config::ExperimentConfig tracked_experiment(const record::LoadedRun& run) {
  config::ExperimentConfig experiment =
      config::parse_experiment(run.experiment_text, (run.folder / "run.json (experiment)").string());
  if (experiment.tracking() == nullptr) {
    throw DataError(fmt::format("{}: is no run of [track]; `eha track` plays one", run.folder.string()));
  }
  return experiment;
}

/// A figure whose standard error is known.
KeptFigure margin_figure(const char* name, const char* unit, double measured, double std,
                         const config::PromisedFigure& promised, Bound bound) {
  constexpr double kStudents = 2.6;  // 95 % with 5 degrees of freedom
  return {.name = name,
          .unit = unit,
          .measured = measured,
          .noise = kStudents * std,
          .promised = promised,
          .bound = bound,
          .is_two_sided = true};
}

/// Time after the end of the step's reference from which on the readings stay within a band about its end [s].
double settled_s(const TrackRows& rows, const ident::TrialMotion& motion, double band_in) {
  const double end_in = motion.home() + motion.way();
  std::optional<std::size_t> ended;
  std::size_t settled = 0;
  for (std::size_t i = 0; i < rows.rod_in.size(); ++i) {
    if (motion.part(i + 1) != ident::TrialMotion::Part::step) continue;
    const bool is_there = std::abs(rows.reference_in[i] - end_in) < 1e-6 * std::abs(motion.way());
    if (!ended && is_there) ended = settled = i;
    if (!ended || std::abs(rows.rod_in[i] - end_in) > band_in) settled = i;
  }
  return motion.tick_s() * static_cast<double>(settled - ended.value_or(0));
}

/// Settling within 2 % of the step. Means over 50 ms would hide as much of it; single readings show each tick where
/// their noise is small against those 2 %.
KeptFigure settling_figure(const TrackRows& rows, const ident::TrialMotion& motion, double noise_in, double by_means_s,
                           const config::PromisedFigure& promised) {
  KeptFigure figure{.name = "settling within 2 % of the step",
                    .unit = "s",
                    .measured = by_means_s,
                    .noise = kMean_s,
                    .promised = promised,
                    .is_two_sided = true};
  const double band_in = ident::kSettledShare * std::abs(motion.way());
  if (kExtremes * noise_in > kSmallNoise * band_in) return figure;
  figure.measured = settled_s(rows, motion, band_in);
  figure.noise = figure.measured - settled_s(rows, motion, band_in + kExtremes * noise_in) + motion.tick_s();
  figure.is_two_sided = false;
  return figure;
}

}  // namespace

bool TrackResult::is_kept() const noexcept {
  return std::all_of(figures.begin(), figures.end(), [](const KeptFigure& f) { return f.is_kept(); });
}

namespace {

/// The leak of a trial's rig: by the newest valve sheet beside it, else by the controller's.
std::optional<ident::Leak> leak_of(const record::OpenRun& trial, const config::ControllerConfig& controller) {
  try {
    if (const auto run = record::newest_sheet_run(trial.path())) return record::leak_in(*run);
    return controller.provenance.sheet.empty() ? std::nullopt : record::leak_in(controller.provenance.sheet);
  } catch (const Error&) {  // a folder that the caller may not read
    return std::nullopt;
  }
}

/// The part of a result that needs no complete trial: its rows and their means.
TrackResult played(const record::LoadedRun& run, const config::ExperimentConfig& experiment) {
  TrackResult result;
  result.folder = run.folder;
  result.opened = run.opened;
  const config::RigConfig rig = config::parse_rig(run.rig_text, (run.folder / "run.json (rig)").string());
  result.units = rig.units;
  result.controller = experiment.tracking()->track.controller;
  result.leak = leak_of(run.opened, result.controller);
  const ident::AxisCoefficients c = ident::coefficients(result.controller.settings);
  const Eigen::VectorXd& y = run.record.output;
  // The row before the controller's first: the controller starts from its reading.
  const auto before = static_cast<Eigen::Index>(first_tracked_row(rig.limits, c.settings.tick_s)) - 1;
  if (y.size() < before + 2) throw DataError(fmt::format("{}: it has no row of the controller", run.folder.string()));
  const ident::TrialMotion motion(c.settings, experiment.tracking()->track.plan, y[before + 1]);
  ident::AxisController controller(c);
  controller.start(y[before + 1], c.settings.inverse.null);
  TrackRows& rows = result.rows;
  const bool is_own = !experiment.tracking()->track.plan.reference.empty();
  for (Eigen::Index k = 1; before + k < y.size(); ++k) {
    const double reading_in = y[before + k];
    const double set_point = motion.set_point(static_cast<std::size_t>(k));
    rows.time_s.push_back(run.record.start_s + static_cast<double>(before + k) * c.settings.tick_s);
    rows.reference_in.push_back(controller.step(set_point, reading_in).reference);
    if (is_own) {
      result.reference_behind_in = std::max(result.reference_behind_in, std::abs(rows.reference_in.back() - set_point));
    }
    rows.rod_in.push_back(reading_in);
    rows.command_V.push_back(run.record.input[before + k]);
  }
  if (run.outcome == acquisition::Outcome::faulted) result.trip_s = rows.time_s.back() + c.settings.tick_s;
  const std::size_t width = mean_width(c.settings.tick_s);
  result.mean_reference_in = means(rows.reference_in, width);
  result.mean_rod_in = means(rows.rod_in, width);
  if (const auto& sweep = experiment.tracking()->track.plan.sweep; sweep && !is_own) {
    if (const auto first = sweep_begin(rows, motion, *sweep)) {
      result.sweep_s = {rows.time_s[*first], rows.time_s[*first + sweep->rows() - 1]};
    }
  }
  return result;
}

}  // namespace

TrackResult played_track(const record::OpenRun& opened) {
  const record::LoadedRun run = record::read_run(opened);
  return played(run, tracked_experiment(run));
}

TrackResult track_result(const record::OpenRun& opened) {
  const record::LoadedRun run = record::read_run(opened);
  const std::filesystem::path& folder = run.folder;
  const config::ExperimentConfig experiment = tracked_experiment(run);
  if (run.outcome != acquisition::Outcome::completed) {
    throw DataError(fmt::format("{}: {}; a controller is judged by a completed run", folder.string(),
                                acquisition::to_text(run.outcome)));
  }
  const double lost_percent =
      100.0 * static_cast<double>(run.record.unmeasured.size()) / static_cast<double>(run.record.output.size());
  if (lost_percent > config::kMostLostRows_percent) {
    throw DataError(fmt::format(
        "{}: {:.3g} % of the trial's rows were not measured, more than {:g} %, so that it judges neither controller "
        "nor "
        "valve: repeat it while the computer is idle; `eha doctor` and `eha latency` say what keeps it busy",
        folder.string(), lost_percent, config::kMostLostRows_percent));
  }
  TrackResult result = played(run, experiment);
  const ident::AxisCoefficients c = ident::coefficients(result.controller.settings);
  const TrackRows& rows = result.rows;
  const std::vector<double>& reference = result.mean_reference_in;
  const std::vector<double>& rod = result.mean_rod_in;
  const std::size_t width = mean_width(c.settings.tick_s);
  const bool is_own = !experiment.tracking()->track.plan.reference.empty();
  const ident::TrialMotion motion(c.settings, experiment.tracking()->track.plan, rows.rod_in.front());
  ident::TrialScore score(motion);
  std::size_t hold = rod.size();
  // Excludes the first and last rows, whose means have few values.
  for (std::size_t i = width; i + width < rod.size(); ++i) {
    score.take(i + 1, reference[i], rod[i]);
    if (motion.part(i + 1) == ident::TrialMotion::Part::hold) hold = std::min(hold, i);
  }
  const ident::TrialFigures did = score.figures();
  result.noise_in = noise_of(rows, is_own ? 0 : hold);
  const double noise = result.noise_in / std::sqrt(static_cast<double>(width));
  const config::ControllerPromise& p = result.controller.promise;
  const auto rms = [&](double value) { return value - std::sqrt(std::max(0.0, value * value - noise * noise)); };
  result.figures = {{"following error, RMS", "in", did.following_rms_in, rms(did.following_rms_in), p.following_rms_in},
                    {"following error, worst", "in", did.following_worst_in, kExtremes * noise, p.following_worst_in},
                    {"error on a sine, RMS", "in", did.sine_rms_in, rms(did.sine_rms_in), p.sine_rms_in},
                    {"overshoot of a step", "in", did.overshoot_in, kExtremes * noise, p.overshoot_in},
                    settling_figure(rows, motion, result.noise_in, did.settling_s, p.settling_s),
                    {"error at rest, worst", "in", did.rest_error_in, kExtremes * noise, p.rest_error_in},
                    {"motion at rest, peak to peak", "in", did.standing_in, 2.0 * kExtremes * noise, p.standing_in}};
  if (is_own) result.figures.resize(2);
  if (experiment.tracking()->track.plan.sweep && !is_own) {
    const ident::MarginSweep& sweep = *experiment.tracking()->track.plan.sweep;
    if (const auto first = sweep_begin(rows, motion, sweep)) {
      result.margins = margins_of(rows, *first, sweep, c.settings, result.margins_retracting);
    }
  }
  if (result.margins) {
    const ident::MeasuredMargins& m = *result.margins;
    result.figures.push_back(margin_figure("Ms", "", m.margins.ms, m.ms_std, p.ms, Bound::most));
    result.figures.push_back(margin_figure("Mt", "", m.margins.mt, m.mt_std, p.mt, Bound::most));
    result.figures.push_back(
        margin_figure("phase margin", "deg", m.margins.phase_deg, m.phase_std_deg, p.phase_margin_deg, Bound::least));
    // The sweep ends below the frequency of the gain margin, which Ms bounds: what it does not show is left out.
    KeptFigure gain =
        margin_figure("gain margin", "times", m.margins.ms / (m.margins.ms - 1.0), 0.0, p.gain_margin, Bound::least);
    gain.is_lower_bound = true;
    if (m.margins.ms > 1.0 && gain.beyond() <= 0.0) result.figures.push_back(gain);
    result.figures.push_back(
        margin_figure("delay margin", "s", m.margins.delay_s, m.delay_std_s, p.delay_margin_s, Bound::least));
  }
  result.valve = seen_valve(rows.command_V, rod, c.settings.tick_s);
  // A user's set points need not have the speeds that determine a valve.
  result.shows_valve = !is_own;
  return result;
}

std::vector<std::string> changes_of(const TrackResult& result, const DisplayUnit& unit) {
  if (!result.shows_valve) return {};
  return changes_of(result.valve, result.controller.settings.inverse, unit);
}

}  // namespace eha::track
