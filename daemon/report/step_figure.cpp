// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "daemon/report/figures.hpp"
#include "ident/fractional/poles.hpp"
#include "ident/fractional/simulate.hpp"

namespace eha::report {
namespace {

using std::numbers::pi;

constexpr Eigen::Index kRows = 400;
constexpr double kLeastDamping = 0.05;  // a pair with less damping is shown for the duration of this one
constexpr double kShownLags = 6.0;      // of the slowest lag
constexpr double kShownBands = 3.0;     // of the time of the highest usable frequency
constexpr double kMostBands = 30.0;     // of the same: more would hide what the record shows first
constexpr double kWithoutBand_s = 1.0;
constexpr double kStillMoving = 0.05;  // of the greatest speed: the output still moves
constexpr double kSwings = 0.999;      // damping of a pair at most
constexpr double kLeastShade = 0.005;  // of the axis: a shorter one does not show
constexpr double kLeastOvershoot = 0.005;

/// Times 1/(2 pi f) of the ends of a model's usable band [s]; none without a band.
struct BandTimes {
  double slowest_s = 0.0;
  double fastest_s = 0.0;
};

std::optional<BandTimes> band_times(const ident::Model& model) {
  if (!model.verdict || !model.verdict->usable_band) return std::nullopt;
  const ident::FrequencyInterval& band = *model.verdict->usable_band;
  if (!(band.lowest_Hz > 0.0) || !(band.highest_Hz > 0.0)) return std::nullopt;
  return BandTimes{1.0 / (2.0 * pi * band.lowest_Hz), 1.0 / (2.0 * pi * band.highest_Hz)};
}

/// A pole that is not 0, as it shows in time.
struct Motion {
  double size_s = 0.0;      ///< 1/|s|; of a lag its time constant
  double decay_s = 0.0;     ///< of its share in the response; of a lightly damped pair as with kLeastDamping
  double damping = 1.0;     ///< cosine of the angle to the negative axis; negative: unstable
  bool is_lasting = false;  ///< a slow lag: the record does not distinguish it from an integrator
};

std::vector<Motion> motions_of(const ident::Model& model) {
  const ident::Poles poles = ident::poles(model.transfer_function);
  const std::optional<BandTimes> band = band_times(model);
  std::vector<Motion> motions;
  for (const auto& value : poles.values) {
    if (!(std::abs(value) > 0.0)) continue;
    const double angle = std::min(pi, std::abs(std::arg(value)) / poles.base_order);
    const double size_s = std::pow(std::abs(value), -1.0 / poles.base_order);
    Motion motion{.size_s = size_s, .damping = -std::cos(angle)};
    motion.decay_s = size_s / std::clamp(motion.damping, kLeastDamping, 1.0);
    const bool swings = motion.damping > 0.0 && motion.damping < kSwings;
    motion.is_lasting = (swings ? size_s : motion.decay_s) > (band ? band->slowest_s : kWithoutBand_s);
    motions.push_back(motion);
  }
  return motions;
}

/// Returns the duration of a model's lags within its band, its delay included [s].
double shown_s(const ident::Model& model) {
  const std::optional<BandTimes> band = band_times(model);
  double shown = 0.0;
  for (const Motion& motion : motions_of(model)) {
    if (!motion.is_lasting) shown = std::max(shown, kShownLags * motion.decay_s);
  }
  // Without a lag that the record shows the axis covers the band.
  if (band && shown < kShownLags * band->fastest_s) {
    shown = std::clamp(band->slowest_s, kShownBands * band->fastest_s, kMostBands * band->fastest_s);
  }
  if (!(shown > 0.0)) shown = kWithoutBand_s;
  return shown + 2.0 * model.transfer_function.delay_s;
}

Eigen::VectorXd step_response(const ident::TransferFunction& g, double step_s) {
  const Eigen::VectorXd input = Eigen::VectorXd::Ones(kRows);
  try {
    return ident::simulate(g, input, step_s);
  } catch (const ConfigError&) {
    return ident::simulate(g, input, step_s, ident::SimulationMethod::gl1);  // not stable
  }
}

/// Differences over the step, one less than values.
std::vector<double> speeds(const Eigen::VectorXd& output, double step_s) {
  std::vector<double> result;
  for (Eigen::Index k = 0; k + 1 < output.size(); ++k) result.push_back((output[k + 1] - output[k]) / step_s);
  return result;
}

const double kReached = 1.0 - std::exp(-1.0);  // of the final value: of a lag its time constant
constexpr Eigen::Index kFineRows = 40;         // that resolve a time

/// Time at which the output, or its speed where it goes on moving, has reached 63 % of `final` [s]: by grids that
/// become finer until they resolve it, as the axis of a picture may be much longer than a lag. 0 for a model without a
/// lag.
double time_of_reaching(const ident::TransferFunction& g, double duration_s, bool goes_on, double final) {
  constexpr double kNoLag = 1e-6;  // of the axis
  const auto has_reached = [&](double value) {
    return value * (final < 0.0 ? -1.0 : 1.0) >= kReached * std::abs(final);
  };
  for (double shown_s = duration_s; shown_s > kNoLag * duration_s;) {
    const double step_s = shown_s / static_cast<double>(kRows - 1);
    const Eigen::VectorXd y = step_response(g, step_s);
    const std::vector<double> values = goes_on ? speeds(y, step_s) : std::vector<double>(y.begin(), y.end());
    const auto at = std::find_if(values.begin(), values.end(), has_reached) - values.begin();
    if (at >= kFineRows) {
      const double before = values[static_cast<std::size_t>(at) - 1];
      const double share = at == std::ssize(values)
                               ? 0.0
                               : (kReached * final - before) / (values[static_cast<std::size_t>(at)] - before);
      // Nothing moves before the dead time, for any grid.
      return std::max((static_cast<double>(at) - 1.0 + share + (goes_on ? 0.5 : 0.0)) * step_s, g.delay_s);
    }
    shown_s = 4.0 * static_cast<double>(at + 1) * step_s;
  }
  return g.delay_s;
}

/// The response of a model over the axis of a picture, and its lag.
struct Response {
  double final = 0.0;  ///< value at rest, or last speed where the output goes on moving
  bool goes_on = false;
  double reached_s = 0.0;     ///< see time_of_reaching()
  double overshoot = 0.0;     ///< over the value at rest, of it
  double resonance_Hz = 0.0;  ///< of the least damped pair; 0: none
};

/// G(s) about s = 0 is gain / s^order.
struct AtRest {
  double order = 0.0;  ///< 1 for an integrator
  double gain = 0.0;
};

AtRest at_rest(const ident::TransferFunction& g) {
  const ident::ReducedPolynomial numerator = ident::reduced(g.numerator);
  const ident::ReducedPolynomial denominator = ident::reduced(g.denominator);
  if (numerator.terms.empty() || denominator.terms.empty()) return {};
  return {denominator.removed_order - numerator.removed_order,
          numerator.terms.front().coefficient / denominator.terms.front().coefficient};
}

/// Whether, and with what, the output of a step ends. A slow lag ends as an integrator does.
Response end_of_step(const ident::TransferFunction& g, const std::vector<Motion>& motions, const Eigen::VectorXd& y,
                     const std::vector<double>& rate) {
  const AtRest rest = at_rest(g);
  const auto faster = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const double fastest = std::abs(*std::max_element(rate.begin(), rate.end(), faster));
  const bool is_moving = std::abs(rate.back()) > kStillMoving * fastest;
  const bool is_unstable = std::any_of(motions.begin(), motions.end(), [](const Motion& m) { return m.damping < 0.0; });
  const bool has_slow = std::any_of(motions.begin(), motions.end(), [](const Motion& m) { return m.is_lasting; });
  constexpr double kWhole = 1e-9;
  if (!is_unstable && !has_slow && std::abs(rest.order - 1.0) <= kWhole) return {.final = rest.gain, .goes_on = true};
  if (is_moving && (is_unstable || has_slow || rest.order > kWhole)) return {.final = rate.back(), .goes_on = true};
  if (is_unstable || rest.order > kWhole) return {.final = y[y.size() - 1]};
  const double gain = rest.order < -kWhole ? 0.0 : rest.gain;
  // The end of a long tail is far from the picture.
  const double most = gain < 0.0 ? -y.minCoeff() : y.maxCoeff();
  return {.final = most >= kReached * std::abs(gain) ? gain : y[y.size() - 1]};
}

/// Greatest value of a curve, by a parabola through the rows beside its peak.
double highest(const Eigen::VectorXd& y) {
  Eigen::Index at = 0;
  const double greatest = y.maxCoeff(&at);
  if (at == 0 || at + 1 == y.size()) return greatest;
  const double bend = 2.0 * greatest - y[at - 1] - y[at + 1];
  const double slope = y[at + 1] - y[at - 1];
  return bend > 0.0 ? greatest + slope * slope / (8.0 * bend) : greatest;
}

Response response_of(const ident::Model& model, double duration_s) {
  const ident::TransferFunction& g = model.transfer_function;
  const double step_s = duration_s / static_cast<double>(kRows - 1);
  const Eigen::VectorXd y = step_response(g, step_s);
  const std::vector<Motion> motions = motions_of(model);
  Response response = end_of_step(g, motions, y, speeds(y, step_s));
  response.reached_s = time_of_reaching(g, duration_s, response.goes_on, response.final);
  if (response.goes_on || !(std::abs(response.final) > 0.0)) return response;
  response.overshoot = highest(y / response.final) - 1.0;
  const auto least = std::min_element(motions.begin(), motions.end(),
                                      [](const Motion& a, const Motion& b) { return a.damping < b.damping; });
  if (least != motions.end() && least->damping < kSwings) response.resonance_Hz = 1.0 / (2.0 * pi * least->size_s);
  return response;
}

/// Adds output and speed to lines, from a time on.
void add_rows(const ident::TransferFunction& g, double duration_s, double from_s, plot::Series& outputs,
              plot::Series& rates) {
  const double step_s = duration_s / static_cast<double>(kRows - 1);
  const Eigen::VectorXd y = step_response(g, step_s);
  const std::vector<double> rate = speeds(y, step_s);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    const double at_s = static_cast<double>(k) * step_s;
    if (at_s < from_s) continue;
    outputs.x.push_back(at_s);
    outputs.y.push_back(y[k]);
    if (k + 1 == kRows) continue;
    rates.x.push_back(at_s + 0.5 * step_s);
    rates.y.push_back(rate[static_cast<std::size_t>(k)]);
  }
}

}  // namespace

plot::Figure step_figure(const std::vector<const ident::Model*>& models, const std::string& title) {
  const std::string& unit = models.front()->output_unit;
  plot::Panel output{.x_label = "", .y_label = axis_label({"output", unit})};
  plot::Panel speed{.x_label = "time after the step [s]", .y_label = axis_label({"speed", unit + "/s"})};
  double duration_s = 0.0;
  for (const ident::Model* model : models) duration_s = std::max(duration_s, shown_s(*model));
  int style = 1;
  for (const ident::Model* model : models) {
    plot::Series outputs{.label = model->name, .x = {}, .y = {}, .style = style};
    plot::Series rates{.label = "", .x = {}, .y = {}, .style = style};
    // A lag that is short against the axis has rows of its own.
    constexpr double kShownReaches = 8.0;
    const double start_s = kShownReaches * response_of(*model, duration_s).reached_s;
    const bool is_short = start_s > 0.0 && start_s < 0.5 * duration_s;
    if (is_short) add_rows(model->transfer_function, start_s, 0.0, outputs, rates);
    add_rows(model->transfer_function, duration_s, is_short ? start_s : 0.0, outputs, rates);
    output.series.push_back(std::move(outputs));
    speed.series.push_back(std::move(rates));
    ++style;
  }
  if (const auto band = band_times(*models.front()); band && band->fastest_s >= kLeastShade * duration_s) {
    for (plot::Panel* panel : {&output, &speed}) {
      panel->shades.push_back({.to = std::min(band->fastest_s, duration_s), .look = plot::Look::hatched});
    }
    output.shades.back().label = "faster than the usable band";
  }
  for (plot::Panel* panel : {&output, &speed}) {
    panel->x_range = std::pair(0.0, duration_s);
    panel->rules.push_back({.at = 0.0, .vertical = false});
  }
  // The speed of an integrator changes little after its start: an axis without 0 would show a small difference as
  // large.
  speed.series.push_back({.label = "", .x = {0.0, duration_s}, .y = {0.0, 0.0}, .style = plot::kGuideStyle});
  return {.title = title, .panels = {std::move(output), std::move(speed)}};
}

std::string step_text(const ident::Model& model) {
  return fmt::format("a step of 1 {} {}", model.input_unit, model.input_map ? "behind the valve" : "at the input");
}

std::string step_sentence(const ident::Model& model) {
  const Response response = response_of(model, shown_s(model));
  const std::optional<BandTimes> band = band_times(model);
  const bool is_observed = !band || response.reached_s >= band->fastest_s;
  const std::string step = fmt::format("1 {} {} {} {:.3g} {} with {}", model.input_unit,
                                       model.input_map ? "behind the valve" : "at the input",
                                       response.goes_on ? "moves the output at" : "brings the output to",
                                       response.final, model.output_unit + (response.goes_on ? "/s" : ""), model.name);
  if (!(response.reached_s > 0.0)) return step + ", at once: the model has no lag.";
  const bool swings = response.resonance_Hz > 0.0 && response.overshoot >= kLeastOvershoot;
  return fmt::format("{}; 63 % of that after {:.2g} s{}{}.", step, response.reached_s,
                     is_observed ? std::string()
                                 : fmt::format(" by the model, in the hatched part of {:.2g} s: it is faster than the "
                                               "usable band, and there the record shows little of it",
                                               band->fastest_s),
                     swings ? fmt::format("; it overshoots by {:.2g} %, f0 = {:.3g} Hz", 100.0 * response.overshoot,
                                          response.resonance_Hz)
                            : std::string());
}

plot::Panel valve_panel(const std::vector<const ident::Model*>& models, double low, double high) {
  const ident::Model& last = *models.back();
  plot::Panel panel{.x_label = fmt::format("input [{}]", last.input_unit),
                    .y_label = fmt::format("passed on [{}]", last.input_unit)};
  ident::ValveMap straight = *last.input_map;
  straight.dead_band = 0.0;
  std::vector<double> bend{low, straight.null, high};
  std::sort(bend.begin(), bend.end());
  const Eigen::VectorXd passed = ident::mapped(straight, Eigen::Map<const Eigen::VectorXd>(bend.data(), 3));
  panel.series.push_back(
      {.label = "without a dead band", .x = bend, .y = {passed.begin(), passed.end()}, .style = plot::kGuideStyle});
  int style = 1;
  for (const ident::Model* model : models) {
    const ident::ValveMap& map = *model->input_map;
    std::vector<double> u{low, map.null - map.dead_band, map.null + map.dead_band, high};
    std::sort(u.begin(), u.end());
    const Eigen::VectorXd v = ident::mapped(map, Eigen::Map<const Eigen::VectorXd>(u.data(), 4));
    panel.series.push_back({.label = "valve of " + model->name, .x = u, .y = {v.begin(), v.end()}, .style = style++});
  }
  const ident::ValveMap& marked = *last.input_map;
  panel.shades.push_back({marked.null - marked.dead_band, marked.null + marked.dead_band, "dead band"});
  panel.rules.push_back({.at = 0.0, .vertical = false});
  panel.rules.push_back({.at = marked.null, .vertical = true, .label = "null"});
  return panel;
}

}  // namespace eha::report
