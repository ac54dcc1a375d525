// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "core/time_text.hpp"
#include "daemon/plot/envelope.hpp"
#include "ident/fractional/poles.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

using plot::Mark;
using plot::Panel;
using plot::Series;
using std::numbers::pi;

constexpr double kMargin = 0.08;  // of a range, beyond the least and the greatest value
constexpr int kArcPoints = 90;
constexpr int kMostRings = 3;
constexpr int kTripStyle = 3;
constexpr const char* kReadings = "single readings";
constexpr std::size_t kParts = 500;    // of a curve's time, each drawn as its least and its greatest value
constexpr double kStandsStill = 1e-5;  // range of an output that is constant, of its value

Series curve(std::span<const double> x, std::span<const double> y, const std::string& label, int style,
             std::size_t parts = kParts) {
  plot::Points points = plot::envelope(x, y, parts);
  return {.label = label, .x = std::move(points.x), .y = std::move(points.y), .mark = Mark::line, .style = style};
}

std::vector<double> residual(const identify::FitTable& table, const identify::FitColumn& column) {
  std::vector<double> values(table.measured.size());
  std::transform(table.measured.begin(), table.measured.end(), column.simulated.begin(), values.begin(),
                 std::minus<>());
  return values;
}

Series circle(double radius, int style) {
  Series series{.label = "", .mark = Mark::line, .style = style};
  for (int i = 0; i <= kArcPoints; ++i) {
    const double angle = 2.0 * pi * i / kArcPoints;
    series.x.push_back(radius * std::cos(angle));
    series.y.push_back(radius * std::sin(angle));
  }
  return series;
}

/// Returns the sector |arg w| <= half_angle_rad as a closed polygon.
Series sector(double half_angle_rad, double radius) {
  Series series{.label = "unstable sector", .x = {0.0}, .y = {0.0}, .mark = Mark::area, .style = 3};
  for (int i = -kArcPoints; i <= kArcPoints; ++i) {
    const double angle = half_angle_rad * i / kArcPoints;
    series.x.push_back(radius * std::cos(angle));
    series.y.push_back(radius * std::sin(angle));
  }
  series.x.push_back(0.0);
  series.y.push_back(0.0);
  return series;
}

/// Range of |w| that a pole plot spans, in decades.
struct Decades {
  int low = -1;
  int high = 1;
  /// Maps |w| to a radius from 0.15 at the least to 1 at the greatest.
  [[nodiscard]] double radius(double size) const {
    return 0.15 + 0.85 * (std::log10(size) - low) / static_cast<double>(high - low);
  }
};

Decades decades_of(const std::vector<std::complex<double>>& values) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = 0.0;
  for (const auto& value : values) {
    if (std::abs(value) > 0.0) least = std::min(least, std::abs(value));
    greatest = std::max(greatest, std::abs(value));
  }
  if (!(greatest > 0.0)) return {};
  Decades decades{static_cast<int>(std::floor(std::log10(least) - 0.2)),
                  static_cast<int>(std::ceil(std::log10(greatest) + 0.2))};
  if (decades.high <= decades.low) decades.high = decades.low + 1;
  return decades;
}

/// Returns the direction in which the circles' captions meet no pole.
double clearest_angle(const std::vector<std::complex<double>>& poles) {
  double best = -3.0 * pi / 8.0;
  double most = -1.0;
  for (const double angle : {-3.0 * pi / 8.0, -5.0 * pi / 8.0, 3.0 * pi / 8.0, 5.0 * pi / 8.0, -pi / 8.0, pi / 8.0}) {
    double nearest = pi;
    for (const auto& pole : poles) {
      if (std::abs(pole) > 0.0) nearest = std::min(nearest, std::abs(std::remainder(std::arg(pole) - angle, 2.0 * pi)));
    }
    if (nearest > most + 0.1) {
      most = nearest;
      best = angle;
    }
  }
  return best;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, values.size())));
}

/// Label of a pole: "16.2 Hz, D = 0.52", "T = 0.0056 s" of a real one, or "grows, T = 21 s"; empty if no exponential
/// belongs to it.
std::string pole_caption(std::complex<double> value, double base_order) {
  const double angle = std::arg(value) / base_order;
  const double natural_rad_s = std::pow(std::abs(value), 1.0 / base_order);
  if (angle < -1e-9 || angle > pi + 1e-9) return "";
  if (std::abs(angle - pi) < 1e-9 || angle < 1e-9) {
    return fmt::format("{}T = {:.3g} s", angle < 1e-9 ? "grows, " : "", 1.0 / natural_rad_s);
  }
  return fmt::format("{:.3g} Hz, D = {:.2g}", natural_rad_s / (2.0 * pi), -std::cos(angle));
}

constexpr double kCaptionHeight = 0.14;  // of a pole map from -1 to 1
constexpr double kLetterWidth = 0.058;   // of the same
constexpr double kMarker = 0.09;         // of the same

/// Adds a caption above a marker, or above the captions and the other markers that it would cover.
void add_apart(std::vector<plot::Caption>& captions, const Series& markers, plot::Caption caption) {
  const double half = 0.5 * kLetterWidth * static_cast<double>(caption.text.size());
  const auto covers_caption = [&](const plot::Caption& other) {
    return std::abs(caption.x - other.x) < half + 0.5 * kLetterWidth * static_cast<double>(other.text.size()) &&
           std::abs(caption.y - other.y) < 0.9 * kCaptionHeight;
  };
  const auto covers_marker = [&] {
    for (std::size_t i = 0; i < markers.x.size(); ++i) {
      if (std::abs(caption.x - markers.x[i]) < half + 0.5 * kMarker &&
          std::abs(caption.y - markers.y[i]) < 0.5 * (0.9 * kCaptionHeight + kMarker)) {
        return true;
      }
    }
    return false;
  };
  while (covers_marker() || std::any_of(captions.begin(), captions.end(), covers_caption)) {
    caption.y += 0.25 * kCaptionHeight;
  }
  captions.push_back(std::move(caption));
}

}  // namespace

Series held(const Series& series) {
  Series steps = series;
  steps.x.clear();
  steps.y.clear();
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (i > 0) {
      steps.x.push_back(series.x[i]);
      steps.y.push_back(series.y[i - 1]);
    }
    steps.x.push_back(series.x[i]);
    steps.y.push_back(series.y[i]);
  }
  return steps;
}

namespace {

/// The input of a record, held between its rows; in straight lines where there are more rows than points, as stairs of
/// a thinned curve would be coarser than the input.
Series held_input(std::span<const double> time_s, std::span<const double> values) {
  Series series = curve(time_s, values, "input", 1);
  return series.x.size() == time_s.size() ? held(series) : series;
}

/// Gives several panels the range of all their values.
void scale_alike(std::vector<Panel>& panels) {
  if (panels.size() < 2) return;
  double least = 0.0;
  double greatest = 0.0;
  for (const Panel& panel : panels) {
    for (const double y : panel.series.front().y) {
      if (!std::isfinite(y)) continue;
      least = std::min(least, y);
      greatest = std::max(greatest, y);
    }
  }
  if (!(least < greatest)) return;
  const double beyond = kMargin * (greatest - least);
  for (Panel& panel : panels) panel.y_range = std::pair(least - beyond, greatest + beyond);
}

}  // namespace

std::string axis_label(const ident::Channel& channel) {
  return channel.unit.empty() ? channel.name : fmt::format("{} [{}]", channel.name, channel.unit);
}

namespace {

/// Gaps of a record that are long enough to be seen in its picture.
std::vector<plot::Shade> seen_gaps(const ident::Record& record) {
  constexpr double kSeen = 0.005;  // of the record
  const auto seen = static_cast<std::size_t>(kSeen * static_cast<double>(record.output.size()));
  std::vector<plot::Shade> shades;
  const auto& rows = record.unmeasured;
  for (std::size_t from = 0; from < rows.size();) {
    std::size_t to = from + 1;
    while (to < rows.size() && rows[to] == rows[to - 1] + 1) ++to;
    if (to - from >= std::max(seen, ident::kRowsOfGap)) {
      const auto time_s = [&](std::size_t row) { return record.start_s + static_cast<double>(row) * record.step_s; };
      shades.push_back({.from = time_s(rows[from]),
                        .to = time_s(rows[to - 1] + 1),
                        .label = shades.empty() ? "not measured" : "",
                        .look = plot::Look::hatched});
    }
    from = to;
  }
  return shades;
}

/// "measured output", with what its straight lines are where rows are missing.
std::string output_label(const ident::Record& record) {
  const auto rows = static_cast<double>(record.output.size());
  const double lost_percent = 100.0 * static_cast<double>(record.unmeasured.size()) / rows;
  if (!(lost_percent > ident::kMostInterpolated_percent)) return "measured output";
  return fmt::format("output, {:.2g} % of its rows not measured and interpolated", lost_percent);
}

}  // namespace

plot::Figure record_figure(const ident::Record& record, const std::string& title) {
  std::vector<double> time_s(static_cast<std::size_t>(record.output.size()));
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    time_s[i] = record.start_s + static_cast<double>(i) * record.step_s;
  }
  const auto all = [](const Eigen::VectorXd& v) { return std::span(v.data(), static_cast<std::size_t>(v.size())); };
  Panel output{.x_label = "", .y_label = axis_label(record.output_channel)};
  output.series.push_back(curve(time_s, all(record.output), output_label(record), 1));
  output.shades = seen_gaps(record);
  Panel input{.x_label = "time [s]", .y_label = axis_label(record.input_channel)};
  input.series.push_back(held_input(time_s, all(record.input)));
  return {.title = title, .panels = {std::move(output), std::move(input)}};
}

plot::Figure fit_figure(const identify::FitTable& table, const std::vector<std::string>& models,
                        const std::optional<double>& split_s, const std::string& title) {
  Panel output{.x_label = "", .y_label = axis_label(table.output)};
  const Panel no_error{.x_label = "",
                       .y_label = axis_label({"error, measured - model", table.output.unit}),
                       .rules = {{.at = 0.0, .vertical = false}}};
  std::vector<Panel> errors;
  Panel input{.x_label = "time [s]", .y_label = axis_label(table.input)};
  output.series.push_back(curve(table.time_s, table.measured, "measured", 0));
  int style = 1;
  for (const std::string& name : models) {
    const identify::FitColumn* column = table.find(name);
    if (column == nullptr) continue;
    output.series.push_back(curve(table.time_s, column->simulated, name, style));
    errors.push_back(no_error);
    errors.back().series.push_back(curve(table.time_s, residual(table, *column), "error of " + name, style));
    ++style;
  }
  if (errors.empty()) errors.push_back(no_error);
  scale_alike(errors);
  input.series.push_back(held_input(table.time_s, table.applied));
  plot::Figure figure{.title = title, .panels = {std::move(output)}};
  std::move(errors.begin(), errors.end(), std::back_inserter(figure.panels));
  figure.panels.push_back(std::move(input));
  if (split_s) {
    for (Panel& panel : figure.panels) panel.rules.push_back({.at = *split_s, .vertical = true});
    figure.panels.front().rules.back().label = "estimated before, validated after";
  }
  return figure;
}

void mark_trip(plot::Figure& figure, double trip_s) {
  for (Panel& panel : figure.panels) {
    double first = trip_s;
    double last = trip_s;
    double least = std::numeric_limits<double>::infinity();
    double greatest = -least;
    for (const Series& series : panel.series) {
      for (const double x : series.x) {
        first = std::min(first, x);
        last = std::max(last, x);
      }
      for (const double y : series.y) {
        if (!std::isfinite(y)) continue;
        least = std::min(least, y);
        greatest = std::max(greatest, y);
      }
    }
    panel.x_range = std::pair(first, last + kMargin * (last - first));
    if (&panel != &figure.panels.front() || !(least <= greatest)) {
      panel.rules.push_back({.at = trip_s, .vertical = true});
      continue;
    }
    // A line as high as a constant output would be a point.
    const double size = std::max(1.0, std::max(std::abs(least), std::abs(greatest)));
    if (greatest - least < kStandsStill * size) {
      least -= kMargin * size;
      greatest += kMargin * size;
    }
    panel.series.push_back({.label = fmt::format("trip at {} s", time_text(trip_s)),
                            .x = {trip_s, trip_s},
                            .y = {least, greatest},
                            .style = kTripStyle});
  }
}

void add_rest(plot::Figure& figure, const identify::FitTable& table, const ident::Record& record) {
  if (table.time_s.empty()) return;
  std::vector<double> time_s{table.time_s.back()};
  std::vector<double> output{table.measured.back()};
  std::vector<double> input{table.applied.back()};
  for (Eigen::Index k = 0; k < record.output.size(); ++k) {
    const double at_s = record.start_s + static_cast<double>(k) * record.step_s;
    if (at_s <= table.time_s.back()) continue;
    time_s.push_back(at_s);
    output.push_back(record.output[k]);
    input.push_back(record.input[k]);
  }
  // As dense as the curve before it.
  const double share = (time_s.back() - time_s.front()) / (time_s.back() - table.time_s.front());
  const auto parts = static_cast<std::size_t>(std::ceil(share * static_cast<double>(kParts)));
  if (parts == 0) return;
  figure.panels.front().series.push_back(curve(time_s, output, kReadings, plot::kGuideStyle, parts));
  figure.panels.back().series.push_back(curve(time_s, input, "each tick", plot::kGuideStyle, parts));
}

plot::Figure ended_trial_figure(const identify::FitTable& rows, const std::string& title) {
  plot::Figure figure = fit_figure(rows, {"reference"}, std::nullopt, title);
  figure.panels[0].series.front().label = "rod";
  figure.panels[1].y_label = axis_label({"error, rod - reference", rows.output.unit});
  for (Series& error : figure.panels[1].series) error.label = kReadings;
  figure.panels[2].series.front().label.clear();
  return figure;
}

plot::Figure fit_table_figure(const identify::FitTable& table, const std::string& title) {
  std::vector<std::pair<double, std::string>> by_error;
  for (const identify::FitColumn& column : table.models)
    by_error.emplace_back(rms(residual(table, column)), column.model);
  // The error of an output that overflowed is NaN; it comes last.
  std::stable_sort(by_error.begin(), by_error.end(), [](const auto& a, const auto& b) {
    return std::isfinite(a.first) && (!std::isfinite(b.first) || a.first < b.first);
  });
  std::vector<std::string> names;
  for (const auto& [error, name] : by_error) {
    if (names.size() < kMostCurves) names.push_back(name);
  }
  const bool is_part = by_error.size() > names.size();
  return fit_figure(
      table, names, std::nullopt,
      is_part ? fmt::format("{}: the {} of {} models with the least error", title, names.size(), by_error.size())
              : title);
}

Panel correlation_panel(const ident::Correlation& correlation, const std::string& y_label) {
  Panel panel{.x_label = "lag [samples]", .y_label = y_label};
  Series stems{.label = "", .mark = Mark::impulses, .style = 1};
  double greatest = correlation.bound99;
  for (std::size_t i = 0; i < correlation.lags.size() && i < correlation.values.size(); ++i) {
    stems.x.push_back(correlation.lags[i]);
    stems.y.push_back(correlation.values[i]);
    greatest = std::max(greatest, std::abs(correlation.values[i]));
  }
  if (stems.x.empty()) return panel;
  const std::vector<double> ends{stems.x.front() - 0.5, stems.x.back() + 0.5};
  for (const double sign : {1.0, -1.0}) {
    const auto flat = [&](double bound) { return std::vector<double>(2, sign * bound); };
    panel.series.push_back({.label = sign > 0.0 ? "95 % bound" : "",
                            .x = ends,
                            .y = flat(correlation.bound95),
                            .mark = Mark::line,
                            .style = 2});
    panel.series.push_back({.label = sign > 0.0 ? "99 % bound" : "",
                            .x = ends,
                            .y = flat(correlation.bound99),
                            .mark = Mark::line,
                            .style = 3});
  }
  panel.series.push_back(std::move(stems));
  panel.rules.push_back({.at = 0.0, .vertical = false});
  panel.x_range = std::pair(ends[0], ends[1]);
  const double end = std::max(0.1, (1.0 + kMargin) * greatest);
  panel.y_range = std::pair(-std::min(end, 1.05), std::min(end, 1.05));
  return panel;
}

std::size_t outside99(const ident::Correlation& correlation, int first_lag) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < correlation.lags.size(); ++i) {
    if (correlation.lags[i] >= first_lag && std::abs(correlation.values[i]) > correlation.bound99) ++count;
  }
  return count;
}

plot::Figure pole_figure(const ident::Model& model) {
  const ident::Poles poles = ident::with_rounded_at_zero(ident::poles(model.transfer_function));
  const double q = poles.base_order;
  // Frequencies are in Hz everywhere: |w| as the natural frequency |w|^(1/q) / 2 pi.
  std::vector<std::complex<double>> in_Hz;
  for (const auto& value : poles.values) {
    in_Hz.push_back(std::polar(std::pow(std::abs(value), 1.0 / q) / (2.0 * pi), std::arg(value)));
  }
  const Decades decades = decades_of(in_Hz);
  constexpr double kReach = 1.12;
  const std::string plane = std::abs(q - 1.0) < 1e-9 ? "s" : "w";
  Panel panel{.x_label = "Re " + plane,
              .y_label = "Im " + plane,
              .x_range = std::pair(-kReach - 0.25, kReach + 0.25),
              .y_range = std::pair(-kReach, kReach),
              .is_map = true};
  panel.series.push_back(sector(std::min(pi, 0.5 * pi * q), 1.05));
  const double away = clearest_angle(in_Hz);
  const int step = (decades.high - decades.low + kMostRings - 1) / kMostRings;
  for (int decade = decades.low; decade <= decades.high; decade += step) {
    const double radius = decades.radius(std::pow(10.0, decade));
    panel.series.push_back(circle(radius, plot::kGuideStyle));
    panel.series.back().label = "";
    constexpr double kBeside = 0.5 * kCaptionHeight;
    panel.captions.push_back({.x = (radius + kBeside) * std::cos(away),
                              .y = (radius + kBeside) * std::sin(away),
                              .text = fmt::format("{:g} Hz", std::pow(10.0, decade))});
  }
  Series points{.label = "poles", .mark = Mark::points, .style = 1};
  for (std::size_t i = 0; i < in_Hz.size(); ++i) {
    if (!(std::abs(in_Hz[i]) > 0.0)) continue;
    const double radius = decades.radius(std::abs(in_Hz[i]));
    points.x.push_back(radius * std::cos(std::arg(in_Hz[i])));
    points.y.push_back(radius * std::sin(std::arg(in_Hz[i])));
  }
  Series markers = points;
  if (poles.order_at_zero > 0.0) {
    markers.x.push_back(0.0);
    markers.y.push_back(0.0);
  }
  std::size_t drawn = 0;
  for (const std::complex<double>& value : poles.values) {
    if (!(std::abs(value) > 0.0)) continue;
    const double x = points.x[drawn];
    const double y = points.y[drawn++];
    const std::string caption = pole_caption(value, q);
    if (!caption.empty()) add_apart(panel.captions, markers, {x, y + 0.6 * kCaptionHeight, caption});
  }
  panel.series.push_back(std::move(points));
  if (poles.order_at_zero > 0.0) {
    panel.series.push_back({.label = "pole at 0", .x = {0.0}, .y = {0.0}, .mark = Mark::points, .style = 2});
  }
  return {.title = "Poles of " + model.name, .panels = {std::move(panel)}};
}

}  // namespace eha::report
