// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/exchange_check.hpp"

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/structure/structures.hpp"

namespace eha::identify {
namespace {

constexpr double kFitsWell_percent = 90.0;
constexpr int kSamples = 4000;  // compared, about

double r2_percent(const ident::Model& model) { return model.validation ? model.validation->score.r2_percent : 0.0; }

}  // namespace

std::optional<ExchangedFit> exchanged_fit(const Source& source, const IdentificationTask& task,
                                          const Identification& identification) {
  if (source.run_folder || task.options.split >= 1.0) return std::nullopt;
  if (std::any_of(identification.models.begin(), identification.models.end(), is_accepted)) return std::nullopt;
  ident::Record exchanged = source.record;
  std::swap(exchanged.input, exchanged.output);
  std::swap(exchanged.input_channel, exchanged.output_channel);
  ident::FitOptions options = task.options;
  options.procedure = ident::Procedure::standard;
  options.intervals = ident::IntervalMethod::straight;
  const auto rows = static_cast<int>(std::min<Eigen::Index>(exchanged.input.size(), 1'000'000'000));
  options.decimation *= std::max(1, rows / (options.decimation * kSamples));
  std::optional<ExchangedFit> best;
  for (const char* name : {"io1", "integrator_lag"}) {
    ident::StructureOptions simple;
    simple.name = name;
    simple.structure = ident::structure_family(name).make({.poles = 1, .zeros = 0});
    simple.structure.delay.freedom = ident::Freedom::free;
    try {
      const double r2 = r2_percent(ident::fit(exchanged, simple, options, thread_executor()).model);
      if (r2 > kFitsWell_percent && (!best || r2 > best->r2_percent)) best = {name, r2};
    } catch (const DataError&) {
      continue;  // this one cannot be fitted the other way round
    }
  }
  const bool is_as_good_as_given =
      best && std::any_of(identification.models.begin(), identification.models.end(),
                          [&](const IdentifiedModel& m) { return r2_percent(m.result.model) >= best->r2_percent; });
  return is_as_good_as_given ? std::nullopt : best;
}

}  // namespace eha::identify
