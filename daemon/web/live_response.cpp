// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/live_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <utility>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "daemon/record/experiment_rows.hpp"
#include "daemon/record/journal.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/periods.hpp"

namespace eha::web {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr double kDecibelsPerRelative = 20.0 / std::numbers::ln10;
/// The thinning filter is flat below this share of the thinned rate.
constexpr double kFlatShare = 0.25;
/// Distortion is measured up to this many harmonics beside a line.
constexpr double kHarmonicsBeside = 14.0;
/// Samples of a thinned period, for an experiment without lines of its own.
constexpr double kLeastPeriod = 4096.0;
/// Lines of an answer are at least this far apart.
constexpr double kLeastRatio = 1.01;

/// Returns the greatest divisor of `number` that is at most `limit`.
std::size_t greatest_divisor(std::size_t number, double limit) {
  for (std::size_t divisor = static_cast<std::size_t>(std::max(limit, 1.0)); divisor > 1; --divisor) {
    if (number % divisor == 0) return divisor;
  }
  return 1;
}

/// Keeps every `factor`-th value of a signal, filtered.
class Thinning {
 public:
  explicit Thinning(std::size_t factor) : factor_(factor), taps_(ident::antialias_taps(factor)) {
    if (taps_.empty()) taps_ = {1.0};
    window_.resize(taps_.size());
  }

  void add(double value) {
    window_[added_ % window_.size()] = value;
    ++added_;
    if (added_ < window_.size() || (added_ - window_.size()) % factor_ != 0) return;
    const std::size_t oldest = added_ % window_.size();
    const auto older = static_cast<std::ptrdiff_t>(window_.size() - oldest);
    double sum = 0.0;
    for (std::ptrdiff_t i = 0; i < older; ++i) {
      sum += taps_[static_cast<std::size_t>(i)] * window_[oldest + static_cast<std::size_t>(i)];
    }
    for (std::size_t i = 0; i < oldest; ++i) sum += taps_[static_cast<std::size_t>(older) + i] * window_[i];
    kept_.push_back(sum);
  }

  /// Number of rows before the first kept one, which lies in the middle of the filter.
  [[nodiscard]] std::size_t delay() const { return taps_.size() / 2; }
  [[nodiscard]] Eigen::VectorXd take() {
    return Eigen::Map<const Eigen::VectorXd>(kept_.data(), static_cast<Eigen::Index>(kept_.size()));
  }

 private:
  std::size_t factor_;
  std::vector<double> taps_;
  std::vector<double> window_;
  std::size_t added_ = 0;
  std::vector<double> kept_;
};

/// The hold between samples, as in measure_frequency_response.
std::complex<double> hold_of(double frequency_Hz, double step_s) {
  const std::complex<double> turn(0.0, 2.0 * std::numbers::pi * frequency_Hz * step_s);
  return (1.0 - std::exp(-turn)) / turn;
}

double std_dB(const ident::LineResponse& line) { return kDecibelsPerRelative * line.std / std::abs(line.response); }

/// Returns the greater of both distortions; none if neither was measured.
Json distortion_of(const ident::LineResponse& line) {
  if (!line.even_distortion_dB && !line.odd_distortion_dB) return nullptr;
  return std::max(line.even_distortion_dB.value_or(-INFINITY), line.odd_distortion_dB.value_or(-INFINITY));
}

/// Returns the valve of a rig file; none without [following], or if an earlier version wrote a file that is now
/// refused.
std::optional<ident::ValveMap> valve_of(const std::string& rig_text, const std::string& source) {
  try {
    const config::RigConfig rig = config::parse_rig(rig_text, source);
    if (!rig.limits.following) return std::nullopt;
    const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
    return ident::ValveMap{.null = valve.null_V,
                           .dead_band = valve.dead_band_V,
                           .negative_gain_ratio = valve.gain_negative_in_per_V_s / valve.gain_positive_in_per_V_s};
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

/// Returns the valve's response at each excited line; the rod's response is the measured one divided by it.
std::vector<std::complex<double>> valve_response(const ident::ValveMap& valve, ident::Record record,
                                                 const ident::Periods& periods,
                                                 const std::vector<ident::LineResponse>& lines) {
  std::vector<double> lines_Hz;
  for (const ident::LineResponse& line : lines) lines_Hz.push_back(line.frequency_Hz);
  record.output = ident::mapped(valve, record.input);
  std::vector<std::complex<double>> passed;
  for (const ident::LineResponse& line : ident::measure_frequency_response(record, periods, lines_Hz).lines) {
    passed.push_back(line.response * hold_of(line.frequency_Hz, record.step_s));  // from volts to volts: no hold
  }
  return passed;
}

/// Returns the longest run of neighbouring lines of known gain; null without one.
Json usable_band(const std::vector<ident::LineResponse>& lines) {
  std::size_t begin = 0;
  std::size_t best_begin = 0;
  std::size_t best_end = 0;
  for (std::size_t i = 0; i <= lines.size(); ++i) {
    if (i < lines.size() && std_dB(lines[i]) <= kKnownStd_dB) continue;
    if (i - begin > best_end - best_begin) {
      best_begin = begin;
      best_end = i;
    }
    begin = i + 1;
  }
  if (best_end == best_begin) return nullptr;
  return Json::array({lines[best_begin].frequency_Hz, lines[best_end - 1].frequency_Hz});
}

/// One sentence.
std::string what_is_unknown(const PeriodPlan& plan, const LiveResponse& response, std::size_t rows, bool is_over) {
  if (!response.refusal.empty()) return response.refusal;
  const double period_s = static_cast<double>(plan.period) * plan.step_s;
  if (response.lines.empty()) {
    const std::size_t needed = plan.discard + 2 * plan.period;
    const double missing_s = static_cast<double>(needed > rows ? needed - rows : 0) * plan.step_s;
    if (is_over) {
      return fmt::format("nothing is known: the run ended before two periods of {:.4g} s after the discarded {:.4g} s",
                         period_s, static_cast<double>(plan.discard) * plan.step_s);
    }
    return fmt::format(
        "nothing is known yet: the measurement needs two periods of {:.4g} s after the discarded {:.4g} s; {:.0f} s "
        "more",
        period_s, static_cast<double>(plan.discard) * plan.step_s, std::ceil(missing_s));
  }
  std::vector<std::string> unknown;
  double worst_dB = 0.0;
  for (const ident::LineResponse& line : response.lines) {
    if (std_dB(line) <= kKnownStd_dB) continue;
    unknown.push_back(fmt::format("{:.4g}", line.frequency_Hz));
    worst_dB = std::max(worst_dB, std_dB(line));
  }
  if (unknown.empty()) return "every line is known within 1 dB (95 %)";
  constexpr std::size_t kMostNamed = 5;
  const std::string more = unknown.size() > kMostNamed ? fmt::format(" and {} more", unknown.size() - kMostNamed) : "";
  unknown.resize(std::min(unknown.size(), kMostNamed));
  if (is_over) return fmt::format("not known within 1 dB (95 %): {} Hz{}", fmt::join(unknown, ", "), more);
  // The standard error falls with the root of the periods.
  const auto measured = static_cast<double>(response.periods);
  const double missing = std::ceil(measured * (std::pow(worst_dB / kKnownStd_dB, 2) - 1.0));
  return fmt::format("not known within 1 dB (95 %) yet: {} Hz{}; it takes about {:.0f} more periods, {:.4g} s",
                     fmt::join(unknown, ", "), more, missing, missing * period_s);
}

}  // namespace

PeriodPlan plan_periods(const record::RunHeader& header, const std::string& source) {
  const config::ExperimentConfig experiment =
      config::parse_experiment(header.experiment_text, source, config::NamedFiles::leave);
  PeriodPlan plan;
  plan.step_s = header.sample_period_s;
  plan.rows = header.samples_per_repetition * header.repetitions;
  plan.discard = ident::discarded_rows(header.discard_s, header.sample_period_s);
  plan.valve = valve_of(header.rig_text, source);
  const config::Played* played = experiment.played();
  plan.is_fitted = played != nullptr;
  if (played == nullptr) return plan;
  const identify::ExcitedPeriod excited =
      identify::excited_period(played->excitation, header.sample_period_s, plan.rows, header.samples_per_repetition);
  plan.period = excited.samples;
  plan.lines_Hz = excited.lines_Hz;
  if (plan.period == 0) return plan;
  const double period_s = static_cast<double>(plan.period) * plan.step_s;
  const double limit = plan.lines_Hz.empty()
                           ? static_cast<double>(plan.period) / kLeastPeriod
                           : kFlatShare / (plan.step_s * (plan.lines_Hz.back() + kHarmonicsBeside / period_s));
  plan.thinning = greatest_divisor(plan.period, limit);
  return plan;
}

LiveResponse measure_live_response(const std::filesystem::path& journal, const PeriodPlan& plan) {
  LiveResponse result;
  if (plan.period == 0) {
    result.refusal = plan.is_fitted
                         ? "the experiment has no two equal periods, so its response is known when models are fitted"
                         : "no frequency response is measured in a move, a valve sheet or a trial";
    return result;
  }
  if (plan.rows / plan.thinning > kMostRows) {
    result.refusal =
        fmt::format("the experiment has {} rows, too many for the page; eha fit measures their response", plan.rows);
    return result;
  }
  Thinning input(plan.thinning);
  Thinning output(plan.thinning);
  record::ExperimentRows rows(os::shown(journal), [&](std::size_t, double voltage_V, double displacement_in) {
    input.add(voltage_V);
    output.add(displacement_in);
  });
  static_cast<void>(
      record::read_journal(journal, [&](std::span<const acquisition::TickRecord> ticks) { rows.add(ticks); }));
  rows.finish();
  result.rows = rows.rows();
  ident::Record record;
  record.step_s = plan.step_s * static_cast<double>(plan.thinning);
  record.input = input.take();
  record.output = output.take();
  const auto samples = static_cast<std::size_t>(record.output.size());
  const std::size_t period = plan.period / plan.thinning;
  const std::size_t ahead = plan.discard > input.delay() ? plan.discard - input.delay() : 0;
  std::size_t discard = (ahead + plan.thinning - 1) / plan.thinning;
  if (result.rows < plan.discard + 2 * plan.period || samples < 2 * period) return result;
  // The filter uses half its length at either end: without more rows the two periods begin that much earlier.
  discard = std::min(discard, samples - 2 * period);
  const ident::Periods periods = ident::last_periods(samples, period, discard);
  ident::FrequencyResponse measured = ident::measure_frequency_response(record, periods, plan.lines_Hz);
  result.periods = periods.count;
  double last_Hz = 0.0;
  for (ident::LineResponse& line : measured.lines) {
    const bool is_flat = plan.thinning == 1 || line.frequency_Hz * record.step_s <= kFlatShare;
    if (!is_flat || line.frequency_Hz < kLeastRatio * last_Hz) continue;
    last_Hz = line.frequency_Hz;
    // The input was held for one tick, not for the thinned step.
    const std::complex<double> held = hold_of(last_Hz, record.step_s) / hold_of(last_Hz, plan.step_s);
    line.response *= held;
    line.std *= std::abs(held);
    result.lines.push_back(line);
  }
  if (plan.valve && !result.lines.empty()) result.valve = valve_response(*plan.valve, record, periods, result.lines);
  return result;
}

std::string describe(const std::string& run, const PeriodPlan& plan, const LiveResponse& response, std::size_t rows,
                     bool is_over) {
  Json lines = Json::array();
  double last_deg = 0.0;
  for (const ident::LineResponse& line : response.lines) {
    const double angle_deg = std::arg(line.response) * kDegreesPerRadian;
    // Unwrapped from line to line.
    last_deg = lines.empty() ? angle_deg : angle_deg - 360.0 * std::round((angle_deg - last_deg) / 360.0);
    const double relative = line.std / std::abs(line.response);
    const bool has_valve = lines.size() < response.valve.size();
    const std::complex<double> valve = has_valve ? response.valve[lines.size()] : 0.0;
    lines.push_back({{"f_Hz", line.frequency_Hz},
                     {"magnitude_dB", 20.0 * std::log10(std::abs(line.response))},
                     {"magnitude_std_dB", kDecibelsPerRelative * relative},
                     {"phase_deg", last_deg},
                     {"phase_std_deg", kDegreesPerRadian * relative},
                     {"valve_dB", has_valve ? Json(20.0 * std::log10(std::abs(valve))) : Json(nullptr)},
                     {"valve_phase_deg", has_valve ? Json(std::arg(valve) * kDegreesPerRadian) : Json(nullptr)},
                     {"noise_dB", line.noise_dB},
                     {"distortion_dB", distortion_of(line)}});
  }
  const Json answer{{"run", run},
                    {"periods", response.periods},
                    {"period_s", static_cast<double>(plan.period) * plan.step_s},
                    {"complete_s", static_cast<double>(response.periods * plan.period) * plan.step_s},
                    {"rows", std::max(rows, response.rows)},
                    {"rows_total", plan.rows},
                    {"lines", std::move(lines)},
                    {"usable_band_Hz", usable_band(response.lines)},
                    {"unknown", what_is_unknown(plan, response, std::max(rows, response.rows), is_over)}};
  return answer.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace eha::web
