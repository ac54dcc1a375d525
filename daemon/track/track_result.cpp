// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/track_result.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "config/bound_text.hpp"
#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/track/track_source.hpp"

namespace eha::track {
namespace {

constexpr double kBeforeFault_s = 0.5;
constexpr double kStood_s = 0.3;      // before the end
constexpr double kStood_in = 0.005;   // within it of the reference
constexpr double kFollowed_in = 0.1;  // way that shows that the rod follows
constexpr double kSmallNoise = 0.5;   // extremes of the noise, of the band within which the rod settles
constexpr double kExtremes = 5.0;     // standard deviations that the greatest of some 10^5 values of noise reaches

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

/// Rows of a mean.
std::size_t mean_width(double tick_s) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kMean_s / tick_s)));
}

/// Means of `width` values about each row; shorter at the ends.
std::vector<double> means(const std::vector<double>& values, std::size_t width) {
  std::vector<double> sums(values.size() + 1, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
  std::vector<double> result(values.size());
  const std::size_t half = width / 2;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t reach = std::min({half, i, values.size() - 1 - i});
    result[i] = (sums[i + reach + 1] - sums[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return result;
}

constexpr double kSpeed_s = 0.1;  // rows over which speeds are differences
constexpr double kMoving_in_per_s = 0.03;
constexpr Eigen::Index kFewestRowsAWay = 5;  // in motion
constexpr double kChangeShare = 0.07;        // of a gain
constexpr const char* kGainUnit = "in/(V s)";

SeenValve valve_of(const TrackRows& rows, const std::vector<double>& rod, double tick_s) {
  const auto reach = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.5 * kSpeed_s / tick_s)));
  const std::vector<double> volts = means(rows.command_V, 2 * reach);
  const double span_s = 2.0 * static_cast<double>(reach) * tick_s;
  std::vector<std::array<double, 6>> used;
  for (std::size_t i = 2 * reach; i + 2 * reach < rod.size(); i += reach) {
    const double v = (rod[i + reach] - rod[i - reach]) / span_s;
    const double before = (rod[i] - rod[i - 2 * reach]) / span_s;
    const double after = (rod[i + 2 * reach] - rod[i]) / span_s;
    if (std::min({std::abs(v), std::abs(before), std::abs(after)}) < kMoving_in_per_s || before * after < 0.0) continue;
    used.push_back(
        {1.0, v > 0.0 ? 1.0 : -1.0, std::max(v, 0.0), std::min(v, 0.0), (after - before) / span_s, volts[i]});
  }
  Eigen::MatrixXd a(static_cast<Eigen::Index>(used.size()), 5);
  Eigen::VectorXd u(a.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto& row = used[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < 5; ++j) a(i, j) = row[static_cast<std::size_t>(j)];
    u[i] = row[5];
  }
  // A trial that ended early moved one way alone, or not at all: that tells no gain of the other.
  const auto both_ways = std::min((a.col(2).array() > 0.0).count(), (a.col(3).array() < 0.0).count());
  if (both_ways < kFewestRowsAWay) return {};
  const Eigen::VectorXd x = a.colPivHouseholderQr().solve(u);
  return {x[0], x[1], 1.0 / x[2], 1.0 / x[3]};
}

std::vector<std::string> changes_of(const SeenValve& seen, const ident::InverseMap& map, const DisplayUnit& unit) {
  std::vector<std::string> changes;
  const auto volts = [&](const char* name, double was, double is) {
    if (std::abs(is - was) > config::kSameValve_V)
      changes.push_back(fmt::format("{} {:.3f} V instead of {:.3f} V", name, is, was));
  };
  const auto gain = [&](const char* name, double was, double is) {
    if (std::abs(is / was - 1.0) > kChangeShare) {
      const double factor = unit.factor(kGainUnit);
      changes.push_back(fmt::format("{} {:.4g} {} instead of {:.4g}, {:+.0f} %", name, factor * is, unit.of(kGainUnit),
                                    factor * was, 100.0 * (is / was - 1.0)));
    }
  };
  if (!(seen.gain_positive_in_per_V_s > 0.0 && seen.gain_negative_in_per_V_s > 0.0)) return changes;
  volts("null", map.null, seen.null_V);
  volts("half dead band", map.dead_band, seen.dead_band_V);
  gain("gain extending", map.gain_positive, seen.gain_positive_in_per_V_s);
  gain("gain retracting", map.gain_negative, seen.gain_negative_in_per_V_s);
  return changes;
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

/// Null without a sweep.
nlohmann::ordered_json sweep_json(const TrackResult& result) {
  if (!result.margins) return nullptr;
  const ident::MeasuredMargins& m = *result.margins;
  nlohmann::ordered_json tones = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < m.w_rad_s.size(); ++i) {
    tones.push_back({{"frequency_Hz", m.w_rad_s[i] / (2.0 * std::numbers::pi)},
                     {"open_loop_real", m.open_loop[i].real()},
                     {"open_loop_imaginary", m.open_loop[i].imag()}});
  }
  const auto value = [](const ident::SweptValue& v) {
    return nlohmann::ordered_json{{"value", v.value}, {"half_width95", v.half_width}};
  };
  return {{"direction", result.margins_retracting ? "retracting" : "extending"},
          {"gain_share", value(m.gain_share)},
          {"lag_s", value(m.lag_s)},
          {"tones", std::move(tones)}};
}

}  // namespace

bool TrackResult::is_kept() const noexcept {
  return std::all_of(figures.begin(), figures.end(), [](const KeptFigure& f) { return f.is_kept(); });
}

std::vector<std::string> changes_until_fault(const record::OpenRun& opened, const DisplayUnit& unit) {
  const record::LoadedRun run = record::read_run(opened);
  const config::ExperimentConfig experiment = tracked_experiment(run);
  const config::RigConfig rig = config::parse_rig(run.rig_text, (run.folder / "run.json (rig)").string());
  const ident::AxisSettings& settings = experiment.tracking()->track.controller.settings;
  const auto first = static_cast<Eigen::Index>(first_tracked_row(rig.limits, settings.tick_s));
  // The motion due to the fault says nothing about the valve.
  const Eigen::Index rows = run.record.output.size() - first - std::lround(kBeforeFault_s / settings.tick_s);
  if (rows <= 0) return {};
  TrackRows moved;
  const Eigen::VectorXd rod = run.record.output.segment(first, rows);
  const Eigen::VectorXd volts = run.record.input.segment(first, rows);
  moved.rod_in.assign(rod.begin(), rod.end());
  moved.command_V.assign(volts.begin(), volts.end());
  const SeenValve seen = valve_of(moved, means(moved.rod_in, mean_width(settings.tick_s)), settings.tick_s);
  return changes_of(seen, settings.inverse, unit);
}

namespace {

/// The part of a result that needs no complete trial: its rows and their means.
TrackResult played(const record::LoadedRun& run, const config::ExperimentConfig& experiment) {
  TrackResult result;
  result.folder = run.folder;
  result.opened = run.opened;
  const config::RigConfig rig = config::parse_rig(run.rig_text, (run.folder / "run.json (rig)").string());
  result.units = rig.units;
  result.controller = experiment.tracking()->track.controller;
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
  result.valve = valve_of(rows, rod, c.settings.tick_s);
  // A user's set points need not have the speeds that determine a valve.
  result.shows_valve = !is_own;
  return result;
}

std::vector<std::string> changes_of(const TrackResult& result, const DisplayUnit& unit) {
  if (!result.shows_valve) return {};
  return changes_of(result.valve, result.controller.settings.inverse, unit);
}

std::string kept_text(const KeptFigure& figure) {
  if (!figure.is_decided()) return "hidden by noise";
  return figure.is_kept() ? "yes" : "no";
}

std::string kept_text(const TrackResult& result) {
  std::size_t broken = 0;
  std::size_t hidden = 0;
  for (const KeptFigure& f : result.figures) (f.is_kept() ? hidden : broken) += f.is_decided() && f.is_kept() ? 0 : 1;
  std::string text =
      fmt::format("{} of {} figures are kept", result.figures.size() - broken - hidden, result.figures.size());
  if (broken > 0) text += fmt::format(", {} {} not", broken, broken == 1 ? "is" : "are");
  if (hidden > 0) text += fmt::format(", {} {} hidden by the sensor's noise", hidden, hidden == 1 ? "is" : "are");
  return text;
}

std::string track_text(const TrackResult& result, const DisplayUnit& unit) {
  std::string text = fmt::format("{:<32} {:>9} {:>14} {:>12}  {:<5} {}\n", "figure", "measured", "noise adds to",
                                 "promised", "unit", "kept");
  for (const KeptFigure& f : result.figures) {
    const double factor = unit.factor(f.unit);
    const bool is_most = f.bound == Bound::most;
    text += fmt::format("{:<32} {:>9} {:>14.2g} {:>12}  {:<5} {}\n", f.name,
                        fmt::format("{}{:.3g}", f.is_lower_bound ? ">= " : "", factor * f.measured), factor * f.noise,
                        fmt::format("{} {}", is_most ? "<=" : ">=", config::bound_text(factor * f.limit(), is_most)),
                        unit.of(f.unit), kept_text(f));
  }
  if (result.reference_behind_in > 0.0) {
    text += fmt::format(
        "The generated reference is up to {:.3g} {} from the file's set points: it keeps to {:.3g} {} and {:.3g} {}.\n",
        unit.factor("in") * result.reference_behind_in, unit.of("in"),
        unit.factor("in/s") * result.controller.settings.reference.velocity, unit.of("in/s"),
        unit.factor("in/s^2") * result.controller.settings.reference.acceleration, unit.of("in/s^2"));
  }
  const std::vector<std::string> changes = changes_of(result, unit);
  for (const std::string& change : changes) text += fmt::format("The moving rod shows: {}.\n", change);
  if (result.is_kept() && !changes.empty()) text += fmt::format("{}\n", kChangedAndKept);
  const std::string summary = kept_text(result);
  text += result.is_kept() ? fmt::format("{}: nothing breaks the promise; {}.\n", result.controller.name, summary)
                           : fmt::format(
                                 "{}: the promise is not kept; {}. Valve, load or sensor differ from what the "
                                 "controller was made for: `eha characterise`, then `eha tune`.\n",
                                 result.controller.name, summary);
  if (result.margins) {
    const ident::InverseMap& map = result.controller.settings.inverse;
    const bool is_retracting = result.margins_retracting;
    const double gain = is_retracting ? map.gain_negative : map.gain_positive;
    const ident::SweptValue& share = result.margins->gain_share;
    const double factor = unit.factor(kGainUnit);
    text += fmt::format(
        "By the sweep the gain {} is {:.4g} +- {:.2g} {}, the lag with all delays {:.2g} +- {:.2g} ms "
        "(95 %).\n",
        is_retracting ? "retracting" : "extending", factor * gain * share.value, factor * gain * share.half_width,
        unit.of(kGainUnit), 1e3 * result.margins->lag_s.value, 1e3 * result.margins->lag_s.half_width);
  }
  if (!result.margins) return text + "Margins (Ms, Mt, phase, gain, delay) are not measured by this trial.\n";
  const double ms = result.margins->margins.ms;
  return text +
         fmt::format(
             "Margins: of the open loop, from the sweep, in the direction that has less of them. The gain margin "
             "is at least Ms / (Ms - 1) = {:.3g}.\n",
             ms / (ms - 1.0));
}

nlohmann::ordered_json to_json(const TrackResult& result) {
  nlohmann::ordered_json figures = nlohmann::ordered_json::array();
  for (const KeptFigure& f : result.figures) {
    figures.push_back(
        {{"figure", f.name},
         {"unit", f.unit},
         {"measured", f.measured},
         {"noise", f.noise},
         {"promised", f.promised.value},
         {"promised_to", f.limit()},
         {"promised_is", f.bound == Bound::most ? "most" : "least"},
         {"is_lower_bound", f.is_lower_bound},
         {"kept", f.is_decided() ? nlohmann::ordered_json(f.is_kept()) : nlohmann::ordered_json(nullptr)}});
  }
  return {{"schema", "eha-track/1"},
          {"run", result.folder.string()},
          {"controller", result.controller.name},
          {"kept", result.is_kept()},
          {"noise_in", result.noise_in},
          {"reference_behind_in", result.reference_behind_in},
          {"figures", std::move(figures)},
          {"valve",
           {{"null_V", result.valve.null_V},
            {"dead_band_V", result.valve.dead_band_V},
            {"gain_positive_in_per_V_s", result.valve.gain_positive_in_per_V_s},
            {"gain_negative_in_per_V_s", result.valve.gain_negative_in_per_V_s}}},
          {"sweep", sweep_json(result)},
          {"changes", changes_of(result, DisplayUnit("in"))}};
}

namespace {

void write_rows(const TrackResult& result) {
  std::string csv = "time_s,reference_in,displacement_in,error_in,command_V\n";
  const TrackRows& rows = result.rows;
  for (std::size_t i = 0; i < rows.time_s.size(); ++i) {
    csv += fmt::format("{:.6g},{:.7g},{:.7g},{:.4g},{:.6g}\n", rows.time_s[i], rows.reference_in[i], rows.rod_in[i],
                       rows.rod_in[i] - rows.reference_in[i], rows.command_V[i]);
  }
  os::write_file_atomically(result.opened.files() / kTrackRows, csv);
}

}  // namespace

std::string stood_under_volts(const record::OpenRun& opened, const DisplayUnit& unit,
                              const std::optional<ident::Leak>& leak) {
  const TrackResult result = played_track(opened);
  const TrackRows& rows = result.rows;
  const config::RigConfig rig =
      config::parse_rig(record::read_run(opened).rig_text, (opened.path() / "run.json (rig)").string());
  const auto look = static_cast<std::size_t>(std::lround(kStood_s / result.controller.settings.tick_s));
  if (!rig.limits.following || rows.time_s.size() < 2 * look || look == 0) return {};
  const std::size_t from = rows.time_s.size() - look;
  double volts_V = 0.0;
  for (std::size_t i = from; i < rows.time_s.size(); ++i) {
    volts_V += rows.command_V[i] / static_cast<double>(look);
    if (std::abs(rows.reference_in[i] - rows.reference_in.back()) > kStood_in) return {};
    if (std::abs(result.mean_rod_in[i] - rows.reference_in[i]) > kStood_in) return {};
  }
  const double beyond_V = std::abs(volts_V - rig.limits.following->null_V);
  const auto [lowest, highest] = std::minmax_element(result.mean_rod_in.begin(), result.mean_rod_in.end());
  if (*highest - *lowest < kFollowed_in || beyond_V <= rig.limits.following->dead_band_V) return {};
  return fmt::format(
      "until then the rod followed the reference over {:.2g} {}, so that valve, sensor and hydraulics work. At the end "
      "it stood at the reference under {:.2f} V, {:.2f} V from the null, which the checks of [following] (dead_band_V "
      "{:.2f} V) take for a motion that is missing: {}",
      unit.factor("in") * (*highest - *lowest), unit.of("in"), volts_V, beyond_V, rig.limits.following->dead_band_V,
      leak ? "the volts make up for the leak"
           : "oil leaks past the piston and the volts make up for it, or a load or a wrong null does the same. "
             "`eha characterise` tells them apart by the drift inside the dead band; repair a leak");
}

void write_ended_track(const record::OpenRun& run, const std::optional<ident::Leak>& leak) {
  const bool is_broken = record::read_manifest(run.files()).outcome == acquisition::Outcome::faulted;
  nlohmann::ordered_json document{{"schema", "eha-track/1"},
                                  {"run", run.path().string()},
                                  {"kept", is_broken ? nlohmann::ordered_json(false) : nlohmann::ordered_json(nullptr)},
                                  {"ended_early", true},
                                  {"changes", changes_until_fault(run, DisplayUnit("in"))}};
  if (leak) document["leak"] = {{"creep_in_per_s", leak->creep_in_per_s}, {"as_V", leak->as_V}};
  const std::string stood = is_broken ? stood_under_volts(run, DisplayUnit("in"), leak) : std::string();
  if (!stood.empty()) document["stood"] = stood;
  os::write_file_atomically(run.files() / kTrackFile, document.dump(2) + "\n");
  write_rows(played_track(run));
}

void write_track(const TrackResult& result) {
  os::write_file_atomically(result.opened.files() / kTrackFile, to_json(result).dump(2) + "\n");
  write_rows(result);
}

}  // namespace eha::track
