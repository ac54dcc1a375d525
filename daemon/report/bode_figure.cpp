// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string_view>
#include <utility>

#include "daemon/report/figures.hpp"
#include "daemon/report/known_line.hpp"
#include "daemon/report/map_response.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/uncertainty/bode_curve.hpp"

namespace eha::report {
namespace {

using plot::Mark;
using plot::Panel;
using plot::Series;
using record::NumberTable;

constexpr double kLowest_Hz = 0.01;
constexpr double kHighest_Hz = 10.0;
constexpr std::size_t kGridPoints = 160;
constexpr std::size_t kPointsOfPeak = 24;  ///< on either side of one, between two points of the grid
constexpr int kMapStyle = 1;
constexpr std::string_view kOddDistortion = "odd_distortion_dB";
constexpr const char* kBounds = "95 % bounds";
constexpr double kVisibleBand = 0.02;      // of a panel's range: twice the width of a line
constexpr double kVisibleBar = 0.05;       // of the gains' range
constexpr double kBeyondBand_deg = 360.0;  // of the phases in the usable band: a dead time turns on for ever above it
constexpr double kBeyondModel_dB = 10.0;   // of models' and measured gains: noise far below would flatten them

/// Grows to hold finite values.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// Ends no further out than these.
  void keep_within(double least, double greatest) {
    if (!(least <= greatest)) return;
    low = std::max(low, least);
    high = std::min(high, greatest);
  }
  [[nodiscard]] std::optional<std::pair<double, double>> widened(double least) const {
    if (!(low <= high)) return std::nullopt;
    const double margin = std::max(least, 0.1 * (high - low));
    return std::pair(low - margin, high + margin);
  }
};

/// `count` frequencies after `from`, the last of them `to`, in equal ratios.
void add_grid(std::vector<double>& grid_Hz, double from_Hz, double to_Hz, std::size_t count) {
  for (std::size_t i = 1; i <= count; ++i) {
    grid_Hz.push_back(from_Hz * std::pow(to_Hz / from_Hz, static_cast<double>(i) / static_cast<double>(count)));
  }
}

/// A grid on which no resonance is a triangle: denser about each peak and notch of the gain.
std::vector<double> drawn_frequencies(const ident::Model& model, double lowest_Hz, double highest_Hz) {
  std::vector<double> coarse_Hz{lowest_Hz};
  add_grid(coarse_Hz, lowest_Hz, highest_Hz, kGridPoints - 1);
  const std::vector<double> gain_dB = ident::bode_curve(model, coarse_Hz, {}).gain_dB;
  std::vector<double> grid_Hz{lowest_Hz};
  for (std::size_t i = 1; i < coarse_Hz.size(); ++i) {
    const auto turns = [&](std::size_t at) {
      return at > 0 && at + 1 < gain_dB.size() &&
             (gain_dB[at] - gain_dB[at - 1]) * (gain_dB[at + 1] - gain_dB[at]) <= 0.0;
    };
    add_grid(grid_Hz, coarse_Hz[i - 1], coarse_Hz[i], turns(i - 1) || turns(i) ? kPointsOfPeak : 1);
  }
  return grid_Hz;
}

/// Values over the logarithm of a frequency, at other frequencies within.
std::vector<double> interpolated(const std::vector<double>& at_Hz, const std::vector<double>& values,
                                 const std::vector<double>& wanted_Hz) {
  std::vector<double> result;
  for (const double wanted : wanted_Hz) {
    const auto above = std::upper_bound(at_Hz.begin(), at_Hz.end(), wanted);
    const std::size_t i = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(above - at_Hz.begin(), 1, static_cast<std::ptrdiff_t>(at_Hz.size()) - 1));
    const double share = std::clamp(std::log(wanted / at_Hz[i - 1]) / std::log(at_Hz[i] / at_Hz[i - 1]), 0.0, 1.0);
    result.push_back(std::lerp(values[i - 1], values[i], share));
  }
  return result;
}

/// The curve of a model as it is drawn; its standard errors are those of the model file, interpolated.
ident::BodeCurve curve_of(const ident::Model& model) {
  const bool is_stored = model.bode && model.bode->frequency_Hz.size() > 1;
  const double lowest_Hz = is_stored ? model.bode->frequency_Hz.front() : kLowest_Hz;
  const double highest_Hz = is_stored ? model.bode->frequency_Hz.back() : kHighest_Hz;
  ident::BodeCurve curve = ident::bode_curve(model, drawn_frequencies(model, lowest_Hz, highest_Hz), {});
  if (!is_stored) return curve;
  const auto drawn = [&](const std::vector<double>& values) {
    const bool has_all = values.size() == model.bode->frequency_Hz.size();
    return has_all ? interpolated(model.bode->frequency_Hz, values, curve.frequency_Hz) : std::vector<double>();
  };
  curve.gain_std_dB = drawn(model.bode->gain_std_dB);
  curve.phase_std_deg = drawn(model.bode->phase_std_deg);
  return curve;
}

/// Returns the whole turns that bring a model's phase next to the measured one at its first line.
double turns_deg(const ident::BodeCurve& curve, const NumberTable* response) {
  const std::vector<double>* frequency = response != nullptr ? response->find("frequency_Hz") : nullptr;
  const std::vector<double>* phase = response != nullptr ? response->find("phase_deg") : nullptr;
  if (frequency == nullptr || phase == nullptr || frequency->empty() || curve.frequency_Hz.empty()) return 0.0;
  const auto at = std::lower_bound(curve.frequency_Hz.begin(), curve.frequency_Hz.end(), frequency->front());
  const auto i =
      std::min<std::size_t>(static_cast<std::size_t>(at - curve.frequency_Hz.begin()), curve.frequency_Hz.size() - 1);
  return 360.0 * std::round((phase->front() - curve.phase_deg[i]) / 360.0);
}

/// Draws the bounds where the record supports the response; beyond, they hold only if the structure is the plant's.
Series band(const std::vector<double>& x, const std::vector<double>& centre, const std::vector<double>& std, int style,
            const std::optional<ident::FrequencyInterval>& usable) {
  constexpr double kRounding = 1e-6;
  Series series{.label = "", .x = {}, .mark = Mark::band, .style = style};
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (usable && (x[i] < usable->lowest_Hz * (1.0 - kRounding) || x[i] > usable->highest_Hz * (1.0 + kRounding))) {
      continue;
    }
    series.x.push_back(x[i]);
    series.lower.push_back(centre[i] - ident::kInterval95 * std[i]);
    series.upper.push_back(centre[i] + ident::kInterval95 * std[i]);
  }
  return series;
}

/// Draws the measured response: bars of 95 %, the noise level, and the distortion beside the lines.
void add_measured(const NumberTable& response, Panel& gain, Panel& phase, Range& gains, Range& phases) {
  const auto* f = response.find("frequency_Hz");
  const auto* level = response.find("gain");
  const auto* gain_dB = response.find("gain_dB");
  const auto* phase_deg = response.find("phase_deg");
  const auto* std = response.find("std");
  const auto* noise_dB = response.find("noise_dB");  // below the output, as the distortion is
  if (f == nullptr || level == nullptr || gain_dB == nullptr || phase_deg == nullptr || std == nullptr) return;
  Series g{.label = "measured", .x = *f, .y = *gain_dB, .mark = Mark::error_bars, .style = 0};
  Series p{.label = "", .x = *f, .y = *phase_deg, .mark = Mark::error_bars, .style = 0};
  double longest_bar_dB = 0.0;
  Series noise{.label = "noise", .x = *f, .mark = Mark::points, .style = 5};
  for (std::size_t i = 0; i < f->size(); ++i) {
    const double relative = std::min(0.9, ident::kInterval95 * (*std)[i] / (*level)[i]);
    g.lower.push_back((*gain_dB)[i] + 20.0 * std::log10(1.0 - relative));
    g.upper.push_back((*gain_dB)[i] + 20.0 * std::log10(1.0 + relative));
    p.lower.push_back((*phase_deg)[i] - relative * kDegrees);
    p.upper.push_back((*phase_deg)[i] + relative * kDegrees);
    noise.y.push_back(noise_dB != nullptr ? (*gain_dB)[i] + (*noise_dB)[i] : std::numeric_limits<double>::quiet_NaN());
    for (const double value : {g.lower[i], g.upper[i], noise.y[i]}) gains.add(value);
    for (const double value : {p.lower[i], p.upper[i]}) phases.add(value);
    longest_bar_dB = std::max(longest_bar_dB, g.upper[i] - g.lower[i]);
  }
  // Over three decades of gain most bars are shorter than their points are high.
  g.label += longest_bar_dB < kVisibleBar * (gains.high - gains.low) ? " (its 95 % bars: see gain error)" : ", 95 %";
  const auto distortion = [&](std::string_view name, const char* label, int style) {
    const auto* below_dB = response.find(name);
    if (below_dB == nullptr) return;
    // A silent line beside several excited ones has a point for each, at its own frequency.
    const auto* at_Hz = name == kOddDistortion ? response.find("odd_distortion_Hz") : nullptr;
    Series series{.label = label, .x = *f, .mark = Mark::points, .style = style};
    for (std::size_t i = 0; i < f->size(); ++i) {
      if (at_Hz != nullptr && std::isfinite((*at_Hz)[i])) series.x[i] = (*at_Hz)[i];
      series.y.push_back((*gain_dB)[i] + (*below_dB)[i]);
      gains.add(series.y[i]);
    }
    if (std::any_of(series.y.begin(), series.y.end(), [](double y) { return std::isfinite(y); })) {
      gain.series.push_back(std::move(series));
    }
  };
  gain.series.push_back(std::move(g));
  if (std::any_of(noise.y.begin(), noise.y.end(), [](double y) { return std::isfinite(y); })) {
    gain.series.push_back(std::move(noise));
  }
  distortion("even_distortion_dB", "even distortion", 3);
  distortion(kOddDistortion, "odd distortion", 4);
  distortion("distortion_dB", "distortion at the lines", 6);
  phase.series.push_back(std::move(p));
}

/// Draws the gain of each line over that of a model at the line [dB], with its 95 % bars.
Panel gain_error_panel(const std::vector<double>& measured_dB, const std::vector<double>& model_dB,
                       const NumberTable& response, const std::string& model) {
  Panel panel{.x_label = "", .y_label = "gain error [dB]", .log_x = true};
  const std::vector<double>& f = *response.find("frequency_Hz");
  const std::vector<double>& level = *response.find("gain");
  const std::vector<double>& std = *response.find("std");
  Series bars{.label = "measured over " + model + ", 95 %", .x = f, .mark = Mark::error_bars, .style = 1};
  Range range;
  range.add(0.0);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double relative = std::min(0.9, ident::kInterval95 * std[i] / level[i]);
    const double error = measured_dB[i] - model_dB[i];
    bars.y.push_back(error);
    bars.lower.push_back(error + 20.0 * std::log10(1.0 - relative));
    bars.upper.push_back(error + 20.0 * std::log10(1.0 + relative));
    range.add(bars.lower.back());
    range.add(bars.upper.back());
  }
  panel.series.push_back(std::move(bars));
  panel.rules.push_back({.at = 0.0, .vertical = false});
  panel.y_range = range.widened(0.01);
  return panel;
}

/// Removes marks below an axis that ends at `lowest`: noise far below the models. The key has their median.
void drop_points_below(Panel& gain, double lowest) {
  std::string below;
  for (Series& series : gain.series) {
    if (series.mark != Mark::points) continue;
    std::vector<double> dropped;
    std::size_t shown = 0;
    for (double& y : series.y) {
      if (!std::isfinite(y)) continue;
      if (y >= lowest) {
        ++shown;
        continue;
      }
      dropped.push_back(std::exchange(y, std::numeric_limits<double>::quiet_NaN()));
    }
    if (dropped.empty()) continue;
    std::nth_element(dropped.begin(), dropped.begin() + static_cast<std::ptrdiff_t>(dropped.size() / 2), dropped.end());
    const double median = dropped[dropped.size() / 2];
    if (shown == 0) {
      below += fmt::format("; {} at {:.0f} dB", series.label, median);
    } else {
      series.label +=
          fmt::format(" ({} of {} lines below the axis, at {:.0f} dB)", dropped.size(), dropped.size() + shown, median);
    }
  }
  std::erase_if(gain.series, [](const Series& series) {
    return series.mark == Mark::points &&
           std::none_of(series.y.begin(), series.y.end(), [](double y) { return std::isfinite(y); });
  });
  for (Series& series : gain.series) {
    if (series.mark == Mark::error_bars) series.label += below;
  }
}

/// Whether an eye can tell a band of the panel from its curve. @param range  of the panel
bool shows_bounds(const Panel& panel, const Range& range) {
  const double visible = kVisibleBand * (range.high - range.low);
  return std::any_of(panel.series.begin(), panel.series.end(), [&](const Series& series) {
    if (series.mark != Mark::band) return false;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (series.upper[i] - series.lower[i] >= visible) return true;
    }
    return false;
  });
}

/// Says of bounds that no eye can tell from their curves that they are there.
void name_hidden_bounds(Panel& gain) {
  for (Series& series : gain.series) {
    if (series.label == kBounds) series.label += ", narrower than the line";
  }
}

bool is_measured(const NumberTable* response) {
  if (response == nullptr) return false;
  for (const char* name : {"frequency_Hz", "gain", "gain_dB", "phase_deg", "std"}) {
    if (response->find(name) == nullptr) return false;
  }
  return !response->find("frequency_Hz")->empty();
}

/// Inserts the panel between gain and phase, with their x axis.
plot::Figure stacked(const std::string& title, Panel gain, std::optional<Panel> error, Panel phase) {
  plot::Figure figure{.title = title, .panels = {std::move(gain)}};
  if (error) {
    error->x_range = phase.x_range;
    error->shades = phase.shades;
    figure.panels.push_back(std::move(*error));
  }
  figure.panels.push_back(std::move(phase));
  return figure;
}

/// Returns the names of the models whose columns are nearest to the measured gain, at most kMostCurves.
std::vector<std::string> nearest_models(const NumberTable& response) {
  constexpr std::string_view kEnding = "_gain_dB";
  const std::vector<double>& measured = *response.find("gain_dB");
  std::vector<std::pair<double, std::string>> all;
  for (std::size_t column = 0; column < response.names.size(); ++column) {
    const std::string& name = response.names[column];
    if (!name.ends_with(kEnding)) continue;
    double most = 0.0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      most = std::max(most, std::abs(response.columns[column][i] - measured[i]));
    }
    all.emplace_back(most, name.substr(0, name.size() - kEnding.size()));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (const auto& [distance, name] : all) {
    if (names.size() < kMostCurves) names.push_back(name);
  }
  return names;
}

}  // namespace

plot::Figure response_figure(const NumberTable& response, const std::string& unit, const std::string& title) {
  Panel gain{.x_label = "", .y_label = unit.empty() ? "gain [dB]" : "gain [dB re " + unit + "]", .log_x = true};
  Panel phase{.x_label = "frequency [Hz]", .y_label = "phase [deg]", .log_x = true};
  if (!is_measured(&response)) return {.title = title, .panels = {std::move(gain), std::move(phase)}};
  Range gains;
  Range phases;
  const std::vector<double>& f = *response.find("frequency_Hz");
  const std::vector<std::string> names = nearest_models(response);
  int style = 1;
  for (const std::string& name : names) {
    const auto* phase_deg = response.find(name + "_phase_deg");
    gain.series.push_back({.label = name, .x = f, .y = *response.find(name + "_gain_dB"), .style = style});
    if (phase_deg != nullptr) phase.series.push_back({.label = "", .x = f, .y = *phase_deg, .style = style});
    ++style;
  }
  for (const Series& series : gain.series)
    std::for_each(series.y.begin(), series.y.end(), [&](double y) { gains.add(y); });
  for (const Series& series : phase.series)
    std::for_each(series.y.begin(), series.y.end(), [&](double y) { phases.add(y); });
  add_measured(response, gain, phase, gains, phases);
  gain.y_range = gains.widened(3.0);
  phase.y_range = phases.widened(5.0);
  phase.x_range = gain.x_range = std::pair(0.7 * f.front(), 1.4 * f.back());
  std::optional<Panel> error;
  if (!names.empty()) {
    error = gain_error_panel(*response.find("gain_dB"), *response.find(names.front() + "_gain_dB"), response,
                             names.front());
  }
  return stacked(title, std::move(gain), std::move(error), std::move(phase));
}

bool shows_map(const ident::Model& model, const NumberTable* response, const identify::FitTable* fit) {
  if (!model.input_map || fit == nullptr || !is_measured(response)) return false;
  return !map_response(*model.input_map, *fit, *response->find("frequency_Hz")).empty();
}

ident::BodeCurve curve_at_lines(const ident::Model& model, const NumberTable& response, const identify::FitTable* fit) {
  const std::vector<double>& lines_Hz = *response.find("frequency_Hz");
  ident::BodeCurve curve = ident::bode_curve(model, lines_Hz, {});
  if (!model.input_map || fit == nullptr) return curve;
  const std::vector<std::complex<double>> map = map_response(*model.input_map, *fit, lines_Hz);
  for (std::size_t i = 0; i < map.size(); ++i) {
    curve.gain_dB[i] += 20.0 * std::log10(std::abs(map[i]));
    curve.phase_deg[i] += std::arg(map[i]) * kDegrees;
  }
  return curve;
}

plot::Figure bode_figure(const std::vector<const ReportedModel*>& models, const NumberTable* response,
                         const std::string& title, const identify::FitTable* fit) {
  const ident::Model* first = models.empty() ? nullptr : &models.front()->model;
  const std::string unit = first == nullptr ? "" : " [dB re " + first->output_unit + "/" + first->input_unit + "]";
  Panel gain{.x_label = "", .y_label = "gain" + unit, .log_x = true};
  Panel phase{.x_label = "frequency [Hz]", .y_label = "phase [deg]", .log_x = true};
  Range gains;
  Range phases;
  Range readable;  // phases within the usable bands
  Range frequencies;
  int style = 1;
  for (const ReportedModel* reported : models) {
    const ident::BodeCurve curve = curve_of(reported->model);
    std::vector<double> phase_deg = curve.phase_deg;
    const double shift = turns_deg(curve, response);
    for (double& value : phase_deg) value += shift;
    const std::optional<ident::FrequencyInterval> usable = reported->usable_band();
    if (!curve.gain_std_dB.empty()) {
      gain.series.push_back(band(curve.frequency_Hz, curve.gain_dB, curve.gain_std_dB, style, usable));
      phase.series.push_back(band(curve.frequency_Hz, phase_deg, curve.phase_std_deg, style, usable));
      if (style == 1) gain.series.back().label = kBounds;
    }
    add_known_line(gain, reported->model.name, *reported, curve.frequency_Hz, curve.gain_dB, style);
    add_known_line(phase, "", *reported, curve.frequency_Hz, phase_deg, style);
    for (const double value : curve.gain_dB) gains.add(value);
    for (std::size_t i = 0; i < phase_deg.size(); ++i) {
      phases.add(phase_deg[i]);
      const double at_Hz = curve.frequency_Hz[i];
      if (!usable || (at_Hz >= usable->lowest_Hz && at_Hz <= usable->highest_Hz)) readable.add(phase_deg[i]);
    }
    for (const double value : curve.frequency_Hz) frequencies.add(value);
    ++style;
  }
  if (first != nullptr && shows_map(*first, response, fit)) {
    const ident::BodeCurve at_lines = curve_at_lines(*first, *response, fit);
    Series with_map{.label = first->name + " with its map, at the lines",
                    .x = at_lines.frequency_Hz,
                    .y = at_lines.gain_dB,
                    .mark = Mark::points,
                    .style = kMapStyle};
    Series map_phase = with_map;
    map_phase.label.clear();
    map_phase.y = at_lines.phase_deg;
    const double shift = turns_deg(at_lines, response);
    for (double& value : map_phase.y) value += shift;
    for (const double value : with_map.y) gains.add(value);
    for (const double value : map_phase.y) phases.add(value);
    gain.series.push_back(std::move(with_map));
    phase.series.push_back(std::move(map_phase));
  }
  Range wanted = gains;  // of models and measured lines
  if (response != nullptr) add_measured(*response, gain, phase, gains, phases);
  for (const Series& series : gain.series) {
    if (series.mark != Mark::error_bars) continue;
    for (const std::vector<double>* ends : {&series.lower, &series.upper}) {
      for (const double value : *ends) wanted.add(value);
    }
  }
  phases.keep_within(readable.low - kBeyondBand_deg, readable.high + kBeyondBand_deg);
  gains.keep_within(wanted.low - kBeyondModel_dB, wanted.high + kBeyondModel_dB);
  if (const auto band = models.empty() ? std::nullopt : models.front()->usable_band()) {
    for (Panel* panel : {&gain, &phase}) panel->shades.push_back({band->lowest_Hz, band->highest_Hz});
    gain.shades.back().label = models.size() == 1 ? "usable band" : "usable band of " + first->name;
  }
  drop_points_below(gain, gains.low);
  if (!shows_bounds(gain, gains) && !shows_bounds(phase, phases)) name_hidden_bounds(gain);
  gain.y_range = gains.widened(3.0);
  phase.y_range = phases.widened(5.0);
  if (frequencies.low < frequencies.high) {
    for (Panel* panel : {&gain, &phase}) panel->x_range = std::pair(frequencies.low, frequencies.high);
  }
  std::optional<Panel> error;
  if (first != nullptr && is_measured(response)) {
    const bool has_map = shows_map(*first, response, fit);
    error = gain_error_panel(*response->find("gain_dB"), curve_at_lines(*first, *response, fit).gain_dB, *response,
                             first->name + (has_map ? " with its map" : ""));
  }
  return stacked(title, std::move(gain), std::move(error), std::move(phase));
}

}  // namespace eha::report
