// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/twin_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "daemon/replay/replay.hpp"
#include "daemon/replay/twin_parameter.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::replay {
namespace {

/// Greatest deviations of a twin's parameters from the rig's, as shares of them.
struct Spread {
  const char* key;
  double share;
};
constexpr std::array kSpreads{Spread{"coulomb_friction_N", 0.1},         Spread{"viscous_friction_N_s_per_mm", 0.1},
                              Spread{"bulk_modulus_bar", 0.1},           Spread{"moving_mass_kg", 0.1},
                              Spread{"valve_natural_frequency_Hz", 0.1}, Spread{"valve_dead_band_V", 0.03},
                              Spread{"valve_null_offset_V", 0.03}};
constexpr std::uint64_t kSeeds = 7919;  // differs from the seeds that a rig file or a test would use

/// Draws a possible twin, each parameter uniformly within its spread.
hal::SimOptions drawn(const hal::SimOptions& twin, std::uint64_t seed) {
  ident::PortableDraw draw(seed);
  hal::SimOptions rig = twin;
  for (const Spread& spread : kSpreads) {
    const double factor = 1.0 + spread.share * (2.0 * draw.uniform() - 1.0);
    rig = with_value(rig, spread.key, factor * value_of(twin, spread.key));
  }
  // Break-away friction is not below sliding friction.
  rig.static_friction_N = std::max(rig.static_friction_N, rig.coulomb_friction_N);
  return hal::check(rig).empty() ? rig : twin;
}

/// Returns the standard error that a fit to one record gives; infinite if it gives none.
double std_of(const ident::Record& record, const TrialTask& task) {
  try {
    const ident::Model model = ident::fit(record, task.structure, task.options, ident::run_in_order, task.known).model;
    for (const ident::ParameterEstimate& p : model.parameters) {
      if (p.name == task.parameter && !p.fixed && p.std > 0.0) return p.std;
    }
  } catch (const DataError&) {
    // No stable model, or the record does not determine one.
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

Trial trial(const hal::SimOptions& twin, const Eigen::Ref<const Eigen::VectorXd>& volts, const TrialTask& task,
            const ident::Executor& executor) {
  TrialTask quick = task;
  quick.options.intervals = ident::IntervalMethod::straight;
  quick.options.reported = ident::Reported::estimation;
  std::vector<double> errors(static_cast<std::size_t>(task.records));
  executor(errors.size(), [&](std::size_t i) {
    const std::uint64_t seed = kSeeds + i;
    errors[i] = std_of(recorded(drawn(twin, seed), volts, task.step_s, seed, hal::Integration::quick), quick);
  });
  const auto [lowest, highest] = std::minmax_element(errors.begin(), errors.end());
  return {.std = std::sqrt(*lowest * *highest), .lowest = *lowest, .highest = *highest};
}

}  // namespace eha::replay
