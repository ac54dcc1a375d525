// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/exchange_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/importer/output_findings.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/structure/structures.hpp"

namespace eha::identify {
namespace {

constexpr double kFitsWell_percent = 90.0;
constexpr double kFarLessLeft = 0.25;     // of what a model leaves over, in R2
constexpr double kAsGoodAsShifted = 4.0;  // times what a model of a shifted input leaves over, in R2
constexpr int kSamples = 4000;            // compared, about
constexpr int kFewestToExchange = 100;    // compared: a piece of one swing follows any model, the other way round, too

double r2_percent(const ident::Model& model) { return model.validation ? model.validation->score.r2_percent : 0.0; }

/// The best of the simplest models of the record the other way round; none below kFitsWell_percent.
std::optional<ExchangedFit> other_way_round(const Source& source, ident::FitOptions options) {
  if (source.record.input.size() / options.decimation < kFewestToExchange) return std::nullopt;
  ident::Record exchanged = source.record;
  std::swap(exchanged.input, exchanged.output);
  std::swap(exchanged.input_channel, exchanged.output_channel);
  options.procedure = ident::Procedure::standard;
  options.intervals = ident::IntervalMethod::straight;
  const auto rows = static_cast<int>(std::min<Eigen::Index>(exchanged.input.size(), 1'000'000'000));
  options.decimation *= std::max(1, rows / (options.decimation * kSamples));
  std::optional<ExchangedFit> best;
  const auto simple_of = [](const char* name) {
    ident::StructureOptions simple;
    simple.name = name;
    simple.structure = ident::structure_family(name).make({.poles = 1, .zeros = 0});
    simple.structure.delay.freedom = ident::Freedom::free;
    return simple;
  };
  // A dead band alone takes a tenth of the motion away.
  ident::StructureOptions behind_valve = simple_of("integrator_lag");
  behind_valve.name = "integrator_lag_valve";
  behind_valve.structure = ident::structures::behind_valve(behind_valve.structure);
  for (const ident::StructureOptions& simple : {simple_of("io1"), simple_of("integrator_lag"), behind_valve}) {
    try {
      const double r2 = r2_percent(ident::fit(exchanged, simple, options, thread_executor()).model);
      if (r2 > kFitsWell_percent && (!best || r2 > best->r2_percent)) best = {simple.name, r2};
    } catch (const DataError&) {
      continue;  // this one cannot be fitted the other way round
    }
  }
  return best;
}

/// Whether the output comes before the input by the record alone, or what models leave over looks like noise of the
/// input, which that of an exchanged output is; and no model passes every check.
bool may_come_before_its_input(const ident::Record& record, const Identification& identification) {
  const auto has = [&](auto&& of_model) {
    return std::any_of(identification.models.begin(), identification.models.end(),
                       [&](const auto& one) { return of_model(one.result.model); });
  };
  if (has([](const ident::Model& m) { return m.verdict && m.verdict->grade == ident::Grade::good; })) return false;
  if (has([](const ident::Model& m) { return m.validation && m.validation->input_noise; })) return true;
  return !importer::why_later_than_its_output({record.input.begin(), record.input.end()},
                                              {record.output.begin(), record.output.end()})
              .empty();
}

const ident::Score& score_of(const ScoredModel& scored) {
  const auto& anew = scored.validation.offset_reestimated;
  return anew ? *anew : scored.validation.score;
}

}  // namespace

std::optional<ExchangedFit> exchanged_fit(const Source& source, const IdentificationTask& task,
                                          const Identification& identification) {
  if (source.run_folder || task.options.split >= 1.0) return std::nullopt;
  const auto& models = identification.models;
  const bool any_accepted = std::any_of(models.begin(), models.end(), is_accepted);
  if (any_accepted && !may_come_before_its_input(source.record, identification)) return std::nullopt;
  const std::optional<ExchangedFit> best = other_way_round(source, task.options);
  // Beside a model that is accepted the other way round has to leave far less over.
  const double share = any_accepted ? kFarLessLeft : 1.0;
  const bool is_as_good_as_given = best && std::any_of(models.begin(), models.end(), [&](const IdentifiedModel& m) {
                                     return 100.0 - best->r2_percent >= share * (100.0 - r2_percent(m.result.model));
                                   });
  return is_as_good_as_given ? std::nullopt : best;
}

std::optional<ExchangedFit> exchanged_fit(const Source& source, const ident::FitOptions& options,
                                          const ScoredModel& scored) {
  if (source.run_folder || source.exchange.empty()) return std::nullopt;
  const ident::Score& score = score_of(scored);
  if (score.r2_percent >= kFitsWell_percent) return std::nullopt;
  if (scored.refit) {
    const double unexplained = (1.0 - 0.01 * score.r2_percent) * scored.refit_rms_error * scored.refit_rms_error;
    if (100.0 * (1.0 - unexplained / score.mse) >= kFitsWell_percent) return std::nullopt;
  }
  ident::FitOptions in_halves = options;
  in_halves.split = 0.5;
  return other_way_round(source, in_halves);
}

std::optional<ExchangedFit> exchanged_fit(const Source& source, const ident::FitOptions& options, double r2_percent) {
  if (source.run_folder || source.exchange.empty() || options.split >= 1.0) return std::nullopt;
  const std::optional<ExchangedFit> best = other_way_round(source, options);
  const double left = 100.0 - r2_percent;
  return best && 100.0 - best->r2_percent <= kAsGoodAsShifted * left ? best : std::nullopt;
}

std::string exchange_sentence(const ExchangedFit& other, const ScoredModel& scored) {
  return fmt::format(
      "input and output may be exchanged: as given the model has an R2 of {} %, and the other way round {}, fitted to "
      "the file, has a validation R2 of {:.1f} %",
      ident::percent_text(score_of(scored).r2_percent), other.name, other.r2_percent);
}

}  // namespace eha::identify
