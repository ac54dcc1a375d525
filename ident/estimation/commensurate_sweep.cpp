// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/commensurate_sweep.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace eha::ident {

std::vector<SweepPoint> sweep_commensurate_order(const Record& record, const StructureOptions& structure,
                                                 const FitOptions& options, const std::vector<double>& orders,
                                                 const Executor& executor) {
  if (!structure.structure.base_order) {
    throw ConfigError(
        fmt::format("model {}: a sweep of the commensurate order needs structure commensurate", structure.name));
  }
  if (options.procedure == Procedure::paper) {
    throw ConfigError("the paper's procedure has no commensurate order to sweep; use procedure default");
  }
  const std::string& base_order = structure.structure.base_order->key.name;
  FitOptions each = options;
  each.intervals = IntervalMethod::straight;
  std::vector<SweepPoint> sweep(orders.size());
  executor(orders.size(), [&](std::size_t k) {
    StructureOptions held = structure;
    std::erase_if(held.parameters, [&](const ParameterRequest& request) { return request.name == base_order; });
    held.parameters.push_back({base_order, true, orders[k], {}, {}});
    sweep[k].commensurate_order = orders[k];
    try {
      sweep[k].model = fit(record, held, each).model;
    } catch (const NoStableModel&) {
      // The point stays without a model.
    }
  });
  return sweep;
}

std::vector<double> order_grid(double first, double last, double step) {
  if (!(first > 0.0) || !(last < 2.0) || !(first <= last) || !(step > 0.0)) {
    throw ConfigError(fmt::format(
        "commensurate orders: expected 0 < first <= last < 2 and a positive step, got {}:{}:{}", first, last, step));
  }
  if ((last - first) / step >= kMostSweepOrders) {
    throw ConfigError(fmt::format("commensurate orders: expected at most {} of them, {}:{}:{} are more",
                                  kMostSweepOrders, first, last, step));
  }
  std::vector<double> orders;
  const double slack = 1e-9;
  for (std::size_t k = 0; first + static_cast<double>(k) * step <= last + slack; ++k) {
    orders.push_back(first + static_cast<double>(k) * step);
  }
  return orders;
}

std::string to_csv(const std::vector<SweepPoint>& sweep) {
  std::string text =
      "q,estimation_r2_percent,estimation_fit_percent,validation_r2_percent,validation_fit_percent,ar_bic,stable,"
      "margin_"
      "rad\n";
  for (const SweepPoint& point : sweep) {
    text += fmt::format("{:.6g}", point.commensurate_order);
    if (!point.model) {
      text += ",,,,,,,\n";
      continue;
    }
    const Model& m = *point.model;
    text += fmt::format(",{:.10g},{:.10g}", m.estimation->score.r2_percent, m.estimation->score.fit_percent);
    text += m.validation
                ? fmt::format(",{:.10g},{:.10g}", m.validation->score.r2_percent, m.validation->score.fit_percent)
                : ",,";
    text += fmt::format(",{:.10g},{},{:.10g}\n", m.estimation->information->ar_bic, m.stability->stable ? 1 : 0,
                        m.stability->margin_rad);
  }
  return text;
}

}  // namespace eha::ident
