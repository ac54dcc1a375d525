// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/output_derivatives.hpp"

#include <algorithm>
#include <cmath>

#include "ident/structure/structure.hpp"

namespace eha::ident {
namespace {

constexpr double kShareOfError = 1e-2;  // step of the differences, of the standard error
constexpr double kLongestStep = 1e-2;   // greatest step of an order, and relative step of any other value

/// Returns the place of a parameter's value in a model whose terms have rising orders; null if no single value holds
/// it.
double* place_of(Model& model, const ParameterKey& key) {
  TransferFunction& g = model.transfer_function;
  switch (key.role) {
    case ParameterRole::numerator_coefficient:
      return &g.numerator.at(key.index).coefficient;
    case ParameterRole::denominator_coefficient:
      return &g.denominator.at(key.index).coefficient;
    case ParameterRole::numerator_order:
      return &g.numerator.at(key.index).order;
    case ParameterRole::denominator_order:
      return &g.denominator.at(key.index).order;
    case ParameterRole::delay:
      return &g.delay_s;
    case ParameterRole::input_bias:
      return &model.input_bias;
    case ParameterRole::valve_null:
      return model.input_map ? &model.input_map->null : nullptr;
    case ParameterRole::dead_band:
      return model.input_map ? &model.input_map->dead_band : nullptr;
    case ParameterRole::negative_gain_ratio:
      return model.input_map ? &model.input_map->negative_gain_ratio : nullptr;
    case ParameterRole::grey_box:
      return model.grey_box && key.index < model.grey_box->values.size() ? &model.grey_box->values[key.index] : nullptr;
    case ParameterRole::initial_output:
      return &model.initial_output;
    case ParameterRole::initial_state:
      return key.index < model.initial_state.size() ? &model.initial_state[key.index] : nullptr;
    default:
      return nullptr;
  }
}

void move(Model& model, const ParameterKey& key, double by) {
  if (double* place = place_of(model, key)) *place += by;
  if (key.role != ParameterRole::base_order) return;
  TransferFunction& g = model.transfer_function;
  const double q = g.denominator.at(normalised_index(g.denominator.size())).order;
  for (Term& term : g.numerator) term.order *= 1.0 + by / q;
  for (Term& term : g.denominator) term.order *= 1.0 + by / q;
}

double value_scale(Model& model, const ParameterKey& key) {
  const double* place = place_of(model, key);
  return place == nullptr || is_order(key.role) ? 1.0 : std::abs(*place);
}

}  // namespace

Model with_rising_terms(Model model) {
  const auto by_order = [](const Term& a, const Term& b) { return a.order < b.order; };
  TransferFunction& g = model.transfer_function;
  std::stable_sort(g.numerator.begin(), g.numerator.end(), by_order);
  std::stable_sort(g.denominator.begin(), g.denominator.end(), by_order);
  return model;
}

Eigen::MatrixXd output_derivatives(const Model& model, OutputOnRecord& outputs, const ParameterCovariance& known) {
  const Eigen::VectorXd here = outputs.of(model).total(model);
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(here.size(), known.matrix.cols());
  for (Eigen::Index i = 0; i < derivatives.cols(); ++i) {
    const ParameterKey& key = known.parameters[static_cast<std::size_t>(i)];
    if (key.role == ParameterRole::initial_output) {
      derivatives.col(i).setOnes();
      continue;
    }
    Model moved = model;
    const double error = std::sqrt(std::max(0.0, known.matrix(i, i)));
    const double step = std::min(kShareOfError * error, kLongestStep * value_scale(moved, key));
    if (!(step > 0.0) || (place_of(moved, key) == nullptr && key.role != ParameterRole::base_order)) continue;
    move(moved, key, step);
    derivatives.col(i) = (outputs.of(moved).total(moved) - here) / step;
  }
  return derivatives;
}

}  // namespace eha::ident
