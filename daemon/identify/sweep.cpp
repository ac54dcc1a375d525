// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/identify/thread_executor.hpp"

namespace eha::identify {
namespace {

ident::StructureOptions commensurate_structure(const std::vector<ident::StructureOptions>& structures) {
  const auto found = std::find_if(structures.begin(), structures.end(), [](const ident::StructureOptions& asked) {
    return asked.structure.base_order.has_value();
  });
  if (found != structures.end()) return *found;
  ident::StructureOptions asked;
  asked.structure = ident::structures::commensurate();
  asked.name = asked.structure.family;
  return asked;
}

}  // namespace

CommensurateSweep sweep_commensurate_order(const IdentificationTask& task, const std::vector<double>& orders,
                                           const Progress& progress) {
  CommensurateSweep sweep{.structure = commensurate_structure(task.structures), .points = {}};
  if (progress) progress(0.0, fmt::format("fitting {} values of q", orders.size()));
  sweep.points = ident::sweep_commensurate_order(task.record, sweep.structure, task.options, orders, thread_executor());
  const auto bic_of = [&](std::size_t i) { return sweep.points[i].model->estimation->information->ar_bic; };
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    if (sweep.points[i].model && (!sweep.best || bic_of(i) < bic_of(*sweep.best))) sweep.best = i;
  }
  return sweep;
}

}  // namespace eha::identify
