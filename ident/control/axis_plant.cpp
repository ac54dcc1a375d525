// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/control/axis_design.hpp"
#include "ident/control/sampled_plant.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/poles.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/spectra.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/structure/parameter_role.hpp"
#include "ident/uncertainty/stored_covariance.hpp"

namespace eha::ident {
namespace {

constexpr int kGridPoints = 160;
constexpr double kBelowBand = 1.0 / 3.0;  // of the lowest usable frequency
constexpr double kGridBelow = 1e-5;       // of the Nyquist frequency
constexpr int kTries = 20;                // tries of a draw until it is a valid plant
// For a model file without a covariance.
constexpr double kAssumedGainStd = 0.05;
constexpr double kAssumedLagStd = 0.1;
// Errors beyond the covariance, which holds only for a plant of exactly this structure. In models with straight gains
// the curvature and friction of a valve made lags wrong by up to half of the time between compared samples.
constexpr double kGainStd = 0.015;
constexpr double kUnseenDelayShare = 0.25;  // of that time: standard deviation of an unmodelled dead time

void sort_terms(std::vector<Term>& terms) {
  std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
}

/// Adds a draw's change of a parameter to G, if it is one of G.
void add(TransferFunction& g, const ParameterKey& key, double change) {
  const auto term = [&](std::vector<Term>& terms) -> Term* {
    return key.index < terms.size() ? &terms[key.index] : nullptr;
  };
  switch (key.role) {
    case ParameterRole::numerator_coefficient:
      if (Term* t = term(g.numerator)) t->coefficient += change;
      break;
    case ParameterRole::denominator_coefficient:
      if (Term* t = term(g.denominator)) t->coefficient += change;
      break;
    case ParameterRole::numerator_order:
      if (Term* t = term(g.numerator)) t->order = std::max(0.0, t->order + change);
      break;
    case ParameterRole::denominator_order:
      if (Term* t = term(g.denominator)) t->order = std::max(0.0, t->order + change);
      break;
    case ParameterRole::base_order: {
      const auto base = g.denominator.size() > 1 ? g.denominator[1].order : 0.0;
      if (!(base > 0.0)) break;
      for (auto* terms : {&g.numerator, &g.denominator}) {
        for (Term& t : *terms) t.order *= (base + change) / base;
      }
      break;
    }
    case ParameterRole::delay:
      g.delay_s = std::max(0.0, g.delay_s + change);
      break;
    default:
      break;
  }
}

TransferFunction scaled(TransferFunction g, double factor) {
  for (Term& t : g.numerator) t.coefficient *= factor;
  return g;
}

/// Slows the lags of G by a share: s becomes s (1 + share), the velocity gain is kept.
TransferFunction slowed(TransferFunction g, double share) {
  const double f = 1.0 + share;
  double lowest = 0.0;
  if (!g.denominator.empty()) lowest = g.denominator.front().order;
  for (Term& t : g.numerator) t.coefficient *= std::pow(f, t.order + lowest);
  for (Term& t : g.denominator) t.coefficient *= std::pow(f, t.order);
  return g;
}

bool is_plant(const TransferFunction& g) {
  try {
    check(g);
  } catch (const ConfigError&) {
    return false;
  }
  return !grows(g);
}

FrequencyInterval band_of(const Model& model) {
  const std::optional<FrequencyInterval> usable = model.verdict ? model.verdict->usable_band : std::nullopt;
  if (usable && usable->lowest_Hz > 0.0 && usable->lowest_Hz < usable->highest_Hz) return *usable;
  if (model.bode && model.bode->frequency_Hz.size() > 1) {
    return {model.bode->frequency_Hz.front(), model.bode->frequency_Hz.back()};
  }
  return {0.02, 2.0};
}

std::vector<TransferFunction> drawn(const Model& model, const AxisTask& task, double factor, double unseen_delay_s,
                                    bool& has_covariance) {
  const ParameterCovariance known = stored_covariance(model);
  PortableDraw random(task.seed);
  Eigen::MatrixXd root;
  has_covariance = known.matrix.size() > 0 && known.matrix.allFinite();
  if (has_covariance) {
    const SymmetricEigen eigen = symmetric_eigen(0.5 * (known.matrix + known.matrix.transpose()));
    root = eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  }
  TransferFunction nominal = model.transfer_function;
  sort_terms(nominal.numerator);
  sort_terms(nominal.denominator);
  std::vector<TransferFunction> list;
  for (int i = 0; i < task.draws; ++i) {
    for (int attempt = 0; attempt < kTries; ++attempt) {
      TransferFunction g = nominal;
      if (has_covariance) {
        Eigen::VectorXd normal(root.cols());
        for (double& value : normal) value = random.normal();
        const Eigen::VectorXd change = root * normal;
        for (std::size_t p = 0; p < known.parameters.size(); ++p) {
          add(g, known.parameters[p], change(static_cast<Eigen::Index>(p)));
        }
      } else {
        g = slowed(scaled(g, 1.0 + kAssumedGainStd * random.normal()),
                   std::max(-0.9, kAssumedLagStd * random.normal()));
      }
      // The errors of the valve's two gains in the inverse scale the plant.
      if (task.valve) g = scaled(g, 1.0 + task.valve->gain_std_share * random.normal());
      g = scaled(g, 1.0 + kGainStd * random.normal());
      g.delay_s += unseen_delay_s * std::abs(random.normal());
      if (!is_plant(g)) continue;
      list.push_back(scaled(g, factor));
      break;
    }
  }
  return list;
}

double std_of(const Model& model, std::string_view name) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name == name && !p.fixed && std::isfinite(p.std)) return p.std;
  }
  return 0.0;
}

}  // namespace

AxisPlant axis_plant(const Model& model, const AxisTask& task) {
  require_linear(model, "a controller is designed for a linear plant");
  const auto refuse = [&](const std::string& why) { throw DataError(fmt::format("model {}: {}", model.name, why)); };
  if (!is_plant(model.transfer_function)) {
    refuse(
        "a mode of it grows; a controller is designed for a stable or an integrating model. Fit the record with "
        "other structures: `eha fit` of the run");
  }
  TransferFunction g = model.transfer_function;
  sort_terms(g.numerator);
  sort_terms(g.denominator);
  const auto inverse = inverse_expansion(g, band_of(model));
  if (!inverse) {
    const bool is_sound = !g.numerator.empty() && !g.denominator.empty() &&
                          g.numerator.front().coefficient / g.denominator.front().coefficient > 0.0;
    refuse(is_sound ? "in its band the rod's speed does not grow with the volts: a lead stands where an axis has an "
                      "integrator or a lag. Fit the record with a structure that has one, such as integrator_lag or "
                      "cylinder, if it is of a rod and a valve"
                    : "its gain at low frequencies is 0 or negative, so that no reference can be followed; positive "
                      "volts must extend the rod");
  }
  AxisPlant plant;
  const double factor = inverse->velocity;  // [V s/in]
  plant.g = scaled(g, factor);
  plant.inverse = *inverse;
  plant.inverse.position /= factor;
  plant.inverse.velocity = 1.0;
  plant.inverse.acceleration /= factor;
  // A pole far below the record's band cannot be distinguished from an integrator, and may differ elsewhere in the
  // travel. The feedback compensates it.
  if (std::abs(plant.inverse.position) < kBelowBand * 2.0 * std::numbers::pi * band_of(model).lowest_Hz) {
    plant.inverse.position = 0.0;
  }
  plant.order_at_zero = poles(g).order_at_zero;
  if (plant.order_at_zero > 1.5) refuse("it integrates more than once, which no valve and rod do");
  plant.rest = model.initial_output;

  if (task.valve && task.valve_is_measured) {
    plant.valve = *task.valve;
    plant.replaced = model.input_map;
  } else if (model.input_map) {
    const ValveMap& map = *model.input_map;
    if (!(map.negative_gain_ratio > 0.0)) refuse("its valve map has no positive gain ratio");
    plant.valve = {.null = map.null,
                   .dead_band = std::max(0.0, map.dead_band),
                   .gain_positive = 1.0 / factor,
                   .gain_negative = map.negative_gain_ratio / factor,
                   .null_std = std_of(model, valve_null_key().name),
                   .dead_band_std = std_of(model, dead_band_key().name),
                   .gain_std_share = std_of(model, negative_gain_ratio_key().name)};
  } else if (task.valve) {
    plant.valve = *task.valve;
  } else {
    plant.valve = {.null = -model.input_bias,
                   .gain_positive = 1.0 / factor,
                   .gain_negative = 1.0 / factor,
                   .null_std = std_of(model, input_bias_key().name)};
  }
  plant.compared_step_s = model.estimation ? model.estimation->compared_step_s.value_or(0.0) : 0.0;
  plant.unseen_delay_s = kUnseenDelayShare * plant.compared_step_s;
  plant.draws = drawn(model, task, factor, plant.unseen_delay_s, plant.has_covariance);
  if (plant.draws.size() < static_cast<std::size_t>(task.draws)) {
    refuse(
        fmt::format("only {} of {} draws of its parameters are stable; its uncertainty is too great to promise "
                    "anything. Make a longer record, or take a smaller structure",
                    plant.draws.size(), task.draws));
  }

  const double nyquist = std::numbers::pi / task.tick_s;
  plant.grid_rad_s = log_grid(kGridBelow * nyquist, nyquist, kGridPoints);
  PortableDraw random(task.seed + 1);
  for (const double w : plant.grid_rad_s) {
    plant.response.push_back(sampled_plant(plant.g, task.tick_s, task.tick_s, w));
  }
  for (const TransferFunction& draw : plant.draws) {
    const double late_s = task.tick_s * random.uniform();
    std::vector<std::complex<double>>& response = plant.drawn_responses.emplace_back();
    for (const double w : plant.grid_rad_s) response.push_back(sampled_plant(draw, task.tick_s, late_s, w));
  }
  return plant;
}

}  // namespace eha::ident
