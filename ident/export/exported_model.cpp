// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/exported_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/error.hpp"
#include "ident/export/partial_fractions.hpp"
#include "ident/export/vector_fitting.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

// The sections follow the model over two decades on either side of the band, so that its step response is accurate,
// too.
constexpr double kMargin = 100.0;
constexpr double kWanted = 3e-4;  // relative error over all of that range
constexpr double kCrossingMargin = 10.0;
constexpr double kMostSamples = 20000.0;

/// Returns the frequencies at which two terms of the denominator are equally large.
FrequencyInterval crossings(const TransferFunction& g) {
  double from = 1e300;
  double to = 0.0;
  for (const Term& a : g.denominator) {
    for (const Term& b : g.denominator) {
      if (!(a.order > b.order) || a.coefficient == 0.0 || b.coefficient == 0.0) continue;
      const double w = std::pow(std::abs(b.coefficient / a.coefficient), 1.0 / (a.order - b.order));
      from = std::min(from, w);
      to = std::max(to, w);
    }
  }
  if (to <= 0.0) from = to = 1.0;  // one term has no frequency of its own
  return {from / (2.0 * pi) / kCrossingMargin, to / (2.0 * pi) * kCrossingMargin};
}

std::optional<FrequencyInterval> shown_band(const Model& model) {
  const std::optional<FrequencyInterval> usable = model.verdict ? model.verdict->usable_band : std::nullopt;
  if (usable && usable->lowest_Hz > 0.0 && usable->lowest_Hz < usable->highest_Hz) return usable;
  if (model.bode && model.bode->frequency_Hz.size() > 1) {
    return FrequencyInterval{model.bode->frequency_Hz.front(), model.bode->frequency_Hz.back()};
  }
  return std::nullopt;
}

/// Returns the greatest difference over the greatest exact value [%].
double difference_percent(const Sections& sections, const TransferFunction& g, const Eigen::VectorXd& input,
                          double step_s) {
  const Eigen::VectorXd exact = simulate(g, input, step_s);
  Sections at_rest = sections;
  for (Section& section : at_rest.list) std::fill(section.state.begin(), section.state.end(), 0.0);
  return 100.0 * (respond(at_rest, input, step_s) - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
}

ApproximationError measured(const Sections& sections, const TransferFunction& g, const FrequencyInterval& band) {
  ApproximationError error;
  error.band = band;
  const FrequencyDeviation over =
      deviation(sections, g, dense_grid(g, {2.0 * pi * band.lowest_Hz, 2.0 * pi * band.highest_Hz}));
  error.gain_percent = over.gain_percent;
  error.phase_deg = over.phase_deg;
  const double duration_s = 2.0 / band.lowest_Hz + g.delay_s;
  const double samples = std::clamp(duration_s * band.highest_Hz * 20.0, 200.0, kMostSamples);
  const double step_s = duration_s / samples;
  Eigen::VectorXd input = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(samples));
  error.step_percent = difference_percent(sections, g, input, step_s);
  const double highest_Hz = std::min(band.highest_Hz, 0.1 / step_s);
  const double middle_Hz = std::sqrt(band.lowest_Hz * highest_Hz);
  for (Eigen::Index k = 0; k < input.size(); ++k) {
    const double t = 2.0 * pi * step_s * static_cast<double>(k);
    input[k] = std::cos(band.lowest_Hz * t + 0.4) + std::cos(middle_Hz * t + 1.9) + std::cos(highest_Hz * t + 4.2);
  }
  error.multisine_percent = difference_percent(sections, g, input, step_s);
  return error;
}

/// Returns the states that the input in the windows before t = 0 causes.
void add_past(Sections& sections, std::vector<PastInput> windows) {
  std::sort(windows.begin(), windows.end(), [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  for (Section& section : sections.list) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(section.denominator.size()));
    const auto pass = [&](double duration_s, double value) {
      if (!(duration_s > 0.0)) return;
      const DiscreteSection over = discretise(section, duration_s);
      x = (over.a * x + over.b * value).eval();
    };
    double now_s = windows.empty() ? 0.0 : windows.front().from_s;
    for (const PastInput& window : windows) {
      pass(window.from_s - now_s, 0.0);
      pass(window.to_s - window.from_s, window.value);
      now_s = window.to_s;
    }
    pass(-now_s, 0.0);
    for (std::size_t i = 0; i < section.state.size(); ++i) section.state[i] += x[static_cast<Eigen::Index>(i)];
  }
}

void check_fractional(const Model& model) {
  if (grows(model.transfer_function)) {
    throw ConfigError(
        "transfer_function: unstable and of fractional order, which has no stable approximation; export a model that "
        "`eha fit` accepted");
  }
  if (!model.initial_state.empty()) {
    throw ConfigError(
        "initial_state: not exported with fractional orders; it affects only the start of its own record, so remove it "
        "from the file");
  }
}

/// What a reader of the export is to know of the model: its verdict, and of which record it is.
void note_verdict(const Model& model, ExportedModel& out) {
  if (model.verdict) {
    out.verdict = verdict_word(*model.verdict);
    out.usable_band = model.verdict->usable_band;
    if (!model.verdict->accepted) out.rejected_for = model.verdict->reasons;
  }
  if (model.validation) {
    const Score& score = model.validation->score;
    out.largest_error = std::max(std::abs(score.error_min), std::abs(score.error_max));
  }
  const auto add = [&](const char* what, const char* key) {
    const auto found = model.provenance.find(key);
    if (found != model.provenance.end()) out.origin.push_back(what + found->second);
  };
  add("Fitted to the record ", "record");
  add("by ", "software");
}

}  // namespace

ExportedModel exported(const Model& model, const std::optional<FrequencyInterval>& band) {
  require_linear(model, "exports are of linear plants");
  const TransferFunction& g = model.transfer_function;
  check(g);
  if (!model.past_input.empty() && g.delay_s > 0.0) {
    throw ConfigError(
        "past_input: not exported with a delay; it affects only the start of its own record, so remove it from the "
        "file");
  }
  ExportedModel out{.name = model.name,
                    .transfer_function = g,
                    .sections = {},
                    .error = std::nullopt,
                    .input_map = model.input_map,
                    .input_bias = model.input_map ? 0.0 : model.input_bias,
                    .initial_output = model.initial_output,
                    .input_unit = model.input_unit,
                    .output_unit = model.output_unit,
                    .shown_band = shown_band(model),
                    .rejected_for = {}};
  note_verdict(model, out);
  if (has_whole_orders(g)) {
    out.sections = partial_fractions(g, model.initial_state);
  } else {
    check_fractional(model);
    const FrequencyInterval used = band ? *band : out.shown_band.value_or(crossings(g));
    out.sections = approximate(g, {2.0 * pi * used.lowest_Hz / kMargin, 2.0 * pi * used.highest_Hz * kMargin}, kWanted);
    out.error = measured(out.sections, g, used);
    if (!(out.error->gain_percent <= kMostGainError_percent && out.error->phase_deg <= kMostPhaseError_deg)) {
      throw ConfigError(fmt::format(
          "transfer_function: the rational approximation is {} % and {} degrees off between {:.4g} and {:.4g} "
          "Hz, at most {:g} % and {:g} degrees are allowed; give a narrower --band LOW:HIGH",
          figure_text(out.error->gain_percent), figure_text(out.error->phase_deg), used.lowest_Hz, used.highest_Hz,
          kMostGainError_percent, kMostPhaseError_deg));
    }
  }
  add_past(out.sections, model.past_input);
  return out;
}

Eigen::VectorXd simulate(const ExportedModel& model, const Eigen::Ref<const Eigen::VectorXd>& input, double step_s) {
  const Eigen::VectorXd driving =
      model.input_map ? mapped(*model.input_map, input) : Eigen::VectorXd(input.array() + model.input_bias);
  return respond(model.sections, driving, step_s).array() + model.initial_output;
}

}  // namespace eha::ident
