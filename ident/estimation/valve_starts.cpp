// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/valve_starts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "ident/signal/held_levels.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

constexpr double kAtRest = 0.01;         // of the input's range: as good as 0
constexpr std::size_t kMostCarried = 2;  // optima without the map

bool is_of_valve(CoordinateRole role) {
  return role == CoordinateRole::valve_null || role == CoordinateRole::dead_band ||
         role == CoordinateRole::negative_gain_ratio;
}

/// Whether the input is at 0 or on one side of it, and reaches 0.
bool is_one_sided(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const double near = kAtRest * (input.maxCoeff() - input.minCoeff());
  return near > 0.0 && (std::abs(input.minCoeff()) <= near || std::abs(input.maxCoeff()) <= near);
}

/// The optima to carry over, the best first: those of the same variant, or all where there are none.
std::vector<const LocalOptimum*> carried(const std::vector<LocalOptimum>& linear, const Variant& variant) {
  std::vector<const LocalOptimum*> chosen;
  for (const LocalOptimum& optimum : linear) {
    if (treats_the_past_as(optimum.variant.linear, variant.linear)) chosen.push_back(&optimum);
  }
  for (std::size_t k = 0; chosen.empty() && k < linear.size(); ++k) chosen.push_back(&linear[k]);
  std::stable_sort(chosen.begin(), chosen.end(), [](const LocalOptimum* a, const LocalOptimum* b) {
    return a->best.point.cost < b->best.point.cost;
  });
  chosen.resize(std::min(chosen.size(), kMostCarried));
  return chosen;
}

bool has_start(const StructureOptions& asked, const StructureParameter& parameter) {
  const ParameterRequest* request = find_request(asked, parameter);
  return request != nullptr && request->start;
}

}  // namespace

std::optional<StructureOptions> asked_behind_valve(const StructureOptions& asked) {
  if (!asked.structure.input_map.valve) return {};
  check_requests(asked);
  return asked;
}

StructureOptions without_valve(const StructureOptions& asked) {
  if (!asked.structure.input_map.valve) return asked;
  StructureOptions without = asked;
  without.structure.input_map = {};
  for (const StructureParameter* parameter : map_parameters(asked.structure.input_map)) {
    std::erase_if(without.parameters, [&](const ParameterRequest& r) { return r.name == parameter->key.name; });
  }
  return without;
}

double equivalent_bias(const LocalOptimum& optimum) {
  const LinearSolution& found = optimum.best.point.linear;
  if (optimum.variant.linear.first_state >= 0) return found.input_bias;
  const TransferFunction g = optimum.parametrisation.transfer_function(optimum.best.theta, found.numerator);
  const Eigen::VectorXd& c = found.initial_state;
  const double offset = c[c.size() - 1] / g.denominator.back().coefficient;
  const double pushed = c[0] - offset * g.denominator.front().coefficient;
  return found.numerator[0] == 0.0 ? 0.0 : pushed / found.numerator[0];
}

std::optional<ValveMap> valve_of(const LocalOptimum& optimum) {
  std::optional<ValveMap> map = optimum.parametrisation.valve(optimum.best.theta);
  if (map) map->negative_gain_ratio = optimum.best.point.linear.negative_gain_ratio;
  return map;
}

void move_null(const Parametrisation& parametrisation, Eigen::VectorXd& theta, double by) {
  for (std::size_t l = 0; l < parametrisation.coordinates().size(); ++l) {
    if (parametrisation.coordinates()[l].role == CoordinateRole::valve_null) theta[static_cast<Eigen::Index>(l)] += by;
  }
}

std::vector<Eigen::VectorXd> valve_starts(const std::vector<LocalOptimum>& linear, const Variant& variant,
                                          const Parametrisation& parametrisation, const StructureOptions& asked,
                                          const Parametrisation::Scale& scale) {
  const std::vector<Coordinate>& coordinates = parametrisation.coordinates();
  const ValveParameters& valve = asked.structure.input_map.valve.value();
  const auto of_g = static_cast<Eigen::Index>(
      std::count_if(coordinates.begin(), coordinates.end(), [](const Coordinate& c) { return !is_of_valve(c.role); }));
  std::vector<Eigen::VectorXd> starts;
  for (const LocalOptimum* optimum : carried(linear, variant)) {
    Eigen::VectorXd theta = parametrisation.start();
    theta.head(of_g) = optimum->best.theta.head(of_g);
    const double null = -equivalent_bias(*optimum);
    const bool is_inside = null > scale.lowest_input && null < scale.highest_input;
    for (const double share : kDeadBands) {
      for (std::size_t l = 0; l < coordinates.size(); ++l) {
        const Coordinate& c = coordinates[l];
        double& value = theta[static_cast<Eigen::Index>(l)];
        // A bias beyond the input is one that the record does not determine.
        if (c.role == CoordinateRole::valve_null && is_inside && !has_start(asked, valve.null)) value = null;
        if (c.role == CoordinateRole::dead_band && !has_start(asked, valve.dead_band)) {
          value = share * (scale.highest_input - scale.lowest_input);
        }
      }
      starts.push_back(theta.cwiseMax(parametrisation.lower()).cwiseMin(parametrisation.upper()));
      const bool dead_band_moves = is_estimated(asked, valve.dead_band) && !has_start(asked, valve.dead_band);
      if (!dead_band_moves) break;
    }
  }
  return starts;
}

StructureOptions with_sides_of(const Eigen::Ref<const Eigen::VectorXd>& input, StructureOptions asked) {
  if (!asked.structure.input_map.valve || !is_one_sided(input)) return asked;
  const ValveParameters& valve = *asked.structure.input_map.valve;
  if (find_request(asked, valve.null) != nullptr || find_request(asked, valve.negative_gain_ratio) != nullptr) {
    return asked;
  }
  asked.parameters.push_back({valve.null.key.name, true, 0.0, {}, {}});
  asked.parameters.push_back({valve.negative_gain_ratio.key.name, true, 1.0, {}, {}});
  return asked;
}

void require_more_than_two_levels(const StructureOptions& asked, const Eigen::Ref<const Eigen::VectorXd>& input,
                                  const std::string& unit) {
  if (!asked.structure.input_map.valve) return;
  const ValveParameters& valve = *asked.structure.input_map.valve;
  if (!is_estimated(asked, valve.dead_band) && !is_estimated(asked, valve.negative_gain_ratio)) return;
  const auto levels = two_levels(input);
  if (!levels) return;
  throw DataError(fmt::format(
      "model {}: the input stays at two levels, {:.4g} and {:.4g} {}, which show nothing of a valve map: fit "
      "without a map, or record more levels",
      asked.name, (*levels)[0], (*levels)[1], unit));
}

void require_both_sides(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input,
                        const std::string& model_name, const std::string& unit) {
  const double share_above = is_above(map, input).mean();
  const double share_below = is_below(map, input).mean();
  if (is_one_sided(input)) {
    const double beyond = std::max(share_above, share_below);
    if (std::min(beyond, 1.0 - beyond) >= kLeastShareOfASide) return;
    throw DataError(fmt::format(
        "model {}: the input has one side, and {:.1f} % of the samples that estimate lie beyond the dead band of "
        "{:.4g} {}; the map needs {:.0f} to {:.0f} %: fit without a map, or record more input {} the dead band",
        model_name, 100.0 * beyond, map.dead_band, unit, 100.0 * kLeastShareOfASide, 100.0 * (1.0 - kLeastShareOfASide),
        beyond < 0.5 ? "beyond" : "within"));
  }
  const double rarer = std::min(share_above, share_below);
  if (!(rarer < kLeastShareOfASide)) return;
  throw DataError(fmt::format(
      "model {}: {:.1f} % of the samples that estimate lie {} the dead band (null {:.4g} {}, half dead band {:.4g} "
      "{}); the valve map needs at least {:.0f} % on either side: fit without a map, or record more input on that side",
      model_name, 100.0 * rarer, share_above < share_below ? "above" : "below", map.null, unit, map.dead_band, unit,
      100.0 * kLeastShareOfASide));
}

}  // namespace eha::ident
