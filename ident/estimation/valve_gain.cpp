// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/valve_gain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "ident/estimation/predicted_cost.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::infinity();

/// The model behind maps of several dead bands; none where it is not one of the structure.
std::vector<Eigen::VectorXd> behind_maps(const Parametrisation& parametrisation, const FittedOptimum& fitted) {
  const LocalOptimum& optimum = fitted.optimum;
  const TransferFunction g =
      optimum.parametrisation.transfer_function(optimum.best.theta, optimum.best.point.linear.numerator);
  const auto at = parametrisation.at_model(g, equivalent_bias(optimum), std::nullopt);
  if (!at) return {};
  const std::vector<Coordinate>& coordinates = parametrisation.coordinates();
  const auto dead_band = std::find_if(coordinates.begin(), coordinates.end(),
                                      [](const Coordinate& c) { return c.role == CoordinateRole::dead_band; });
  if (dead_band == coordinates.end()) return {*at};
  std::vector<Eigen::VectorXd> starts;
  for (const double share : kDeadBands) {
    starts.push_back(*at);
    const double range = fitted.scale.highest_input - fitted.scale.lowest_input;
    starts.back()[dead_band - coordinates.begin()] = std::clamp(share * range, dead_band->lower, dead_band->upper);
  }
  return starts;
}

/// Each way to read the start of the record that treats it as the optimum does; all where none does.
std::vector<Variant> like(const Variant& wanted, const std::vector<Variant>& all) {
  std::vector<Variant> alike;
  for (const Variant& variant : all) {
    if (treats_the_past_as(variant.linear, wanted.linear)) alike.push_back(variant);
  }
  return alike.empty() ? all : alike;
}

}  // namespace

double predicted_valve_gain(const PreparedRecord& prepared, const FittedOptimum& fitted,
                            const StructureOptions& behind_map, Work& work) {
  const StructureOptions asked = with_sides_of(prepared.record.input, behind_map);
  const LocalOptimum& optimum = fitted.optimum;
  const bool past = wants_past_input(asked);
  const ComparedRecord& linear = prepared.compared({past, false});
  const ComparedRecord& mapped = prepared.compared({past, true});
  if (linear.measured().size() < kFewestRowsToPredict) return kNotKnown;
  const Parametrisation parametrisation = Parametrisation::search(asked, fitted.scale);
  const std::vector<Eigen::VectorXd> starts = behind_maps(parametrisation, fitted);
  const Eigen::VectorXd residual = OutputError(linear, optimum.parametrisation, optimum.variant.linear)
                                       .residual(optimum.best.theta, optimum.best.point.linear);
  const double effective = residual_model(residual).effective_samples;
  const std::vector<Variant> ways =
      like(optimum.variant, variants(asked, mapped.past().size(), /*at_rest_before=*/false));
  double most = -kNotKnown;
  for (const bool coloured : {false, true}) {
    std::optional<Autoregression> noise;
    if (coloured) noise = autoregression(residual);
    const double samples = coloured ? static_cast<double>(residual.size()) : effective;
    const OutputError without(linear, optimum.parametrisation, optimum.variant.linear, noise);
    const double before = cost_after_a_step(without, optimum.best.theta, work);
    double least = kNotKnown;
    for (const Variant& way : ways) {
      const OutputError with(mapped, parametrisation, way.linear, noise);
      for (const Eigen::VectorXd& theta : starts) least = std::min(least, cost_after_a_step(with, theta, work));
    }
    if (!std::isfinite(before) || !std::isfinite(least)) return kNotKnown;
    most = std::max(most, samples * std::log(before / std::min(least, before)));
  }
  return most;
}

}  // namespace eha::ident
