// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/known_starts.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "ident/coordinates/term_weight.hpp"
#include "ident/estimation/valve_starts.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kMostPolished = 3;  // of the known models
constexpr std::size_t kMostMoved = 2;     // of the known models, whose neighbourhood is tried
constexpr std::array<double, 2> kDelaySteps = {1.0, 4.0};
constexpr double kDead = 1e-5;                                  // coordinate of a weight
constexpr std::array<double, 2> kRevivedWeights = {0.01, 0.1};  // beside the others'
constexpr std::array<double, 2> kRevivedOrders = {0.25, 0.75};  // share of the search box

double mse(const Model& model) {
  return model.estimation ? model.estimation->score.mse : std::numeric_limits<double>::infinity();
}

/// The start with one coordinate of the role at other values.
void add_moved(const Parametrisation& parametrisation, const Eigen::VectorXd& at, CoordinateRole role,
               const std::vector<double>& values, std::vector<Eigen::VectorXd>& starts) {
  const std::vector<Coordinate>& coordinates = parametrisation.coordinates();
  for (std::size_t l = 0; l < coordinates.size(); ++l) {
    const auto i = static_cast<Eigen::Index>(l);
    if (coordinates[l].role != role || at[i] > coordinates[l].lower) continue;
    for (const double value : values) {
      starts.push_back(at);
      starts.back()[i] = std::clamp(value, coordinates[l].lower, coordinates[l].upper);
    }
  }
}

}  // namespace

double equivalent_bias(const Model& model) {
  std::vector<Term> d = model.transfer_function.denominator;
  std::stable_sort(d.begin(), d.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  const std::vector<Term>& numerator = model.transfer_function.numerator;
  const bool names_it = model.initial_state.size() + 1 != d.size() || numerator.size() != 1;
  if (names_it || numerator[0].coefficient == 0.0 || d.back().coefficient == 0.0) return model.input_bias;
  // As for an optimum: offset + x_n / a_n is the offset of a plant at rest, and a_0 times what the model's own offset
  // differs from it is the work of K bias.
  return model.input_bias -
         d.front().coefficient * model.initial_state.back() / (d.back().coefficient * numerator[0].coefficient);
}

KnownStarts known_starts(const Parametrisation& parametrisation, const std::vector<Model>& known,
                         const Parametrisation::Scale& scale) {
  std::vector<const Model*> order;
  for (const Model& model : known) order.push_back(&model);
  std::stable_sort(order.begin(), order.end(), [](const Model* a, const Model* b) { return mse(*a) < mse(*b); });
  const double range = scale.highest_input - scale.lowest_input;
  std::vector<double> dead_bands;
  for (const double share : kDeadBands) dead_bands.push_back(share * range);
  std::vector<double> delays;
  for (const double steps : kDelaySteps) delays.push_back(steps * scale.step_s);
  for (const Model* model : order) {
    if (model->transfer_function.delay_s > 0.0) delays.push_back(model->transfer_function.delay_s);
  }
  KnownStarts starts;
  for (const Model* model : order) {
    const auto at = parametrisation.at_model(model->transfer_function, equivalent_bias(*model), model->input_map);
    if (!at) continue;
    starts.at.push_back(*at);
    if (starts.at.size() > kMostMoved) continue;
    if (!model->input_map) add_moved(parametrisation, *at, CoordinateRole::dead_band, dead_bands, starts.near);
    add_moved(parametrisation, *at, CoordinateRole::delay, delays, starts.near);
  }
  return starts;
}

void KnownStarts::append_to(std::vector<Eigen::VectorXd>& starts) const {
  const auto end = at.begin() + static_cast<std::ptrdiff_t>(std::min(at.size(), kMostPolished));
  starts.insert(starts.end(), at.begin(), end);
  starts.insert(starts.end(), near.begin(), near.end());
}

double least_known_error(const Parametrisation& parametrisation, const std::vector<Model>& known) {
  double least = std::numeric_limits<double>::infinity();
  for (const Model& model : known) {
    if (parametrisation.at_model(model.transfer_function, equivalent_bias(model), model.input_map)) {
      least = std::min(least, mse(model));
    }
  }
  return least;
}

std::vector<Eigen::VectorXd> revived(const Parametrisation& parametrisation, const Eigen::VectorXd& theta) {
  const std::vector<Coordinate>& coordinates = parametrisation.coordinates();
  std::vector<Eigen::VectorXd> starts;
  for (std::size_t l = 0; l < coordinates.size(); ++l) {
    const auto i = static_cast<Eigen::Index>(l);
    if (coordinates[l].role != CoordinateRole::weighted_denominator || !(theta[i] < kDead)) continue;
    const auto order = std::find_if(coordinates.begin(), coordinates.end(), [&](const Coordinate& c) {
      return c.role == CoordinateRole::denominator_order && c.index == coordinates[l].index;
    });
    for (const double revived_weight : kRevivedWeights) {
      Eigen::VectorXd start = theta;
      start[i] = std::min(weight_coordinate(revived_weight), coordinates[l].upper);
      if (order == coordinates.end()) starts.push_back(start);
      for (const double share : kRevivedOrders) {
        if (order == coordinates.end()) break;
        start[order - coordinates.begin()] = order->search_lower + share * (order->search_upper - order->search_lower);
        starts.push_back(start);
      }
    }
  }
  return starts;
}

}  // namespace eha::ident
