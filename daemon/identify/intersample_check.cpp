// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/intersample_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::identify {
namespace {

constexpr double kWorthAsking = 0.005;  // movement within half a row, share of the input's standard deviation
constexpr double kClearly = 20.0;       // of AR-BIC
constexpr Eigen::Index kMostRows = 1'000'000;

/// The model on the record in parts.
ident::Model again(const Source& source, const IdentificationTask& task, const IdentifiedModel& model,
                   ident::Intersample intersample) {
  const ident::Record fine = ident::in_parts(source.record, intersample);
  ident::FitOptions options = task.options;
  options.decimation *= ident::kPartsOfARow;
  options.intervals = ident::IntervalMethod::straight;
  options.search = ident::Search::nearest;
  const ident::PreparedRecord prepared(fine, options);
  return ident::fit(prepared, model.structure, options, thread_executor(), {model.result.model}).model;
}

/// The recommended model; without one the one of least error.
const IdentifiedModel* asked_about(const Identification& identification) {
  const IdentifiedModel* least = nullptr;
  for (const IdentifiedModel& m : identification.models) {
    if (!m.result.model.estimation) continue;
    if (m.structure.name == identification.recommendation.model) return &m;
    if (least == nullptr || m.result.model.estimation->score.mse < least->result.model.estimation->score.mse)
      least = &m;
  }
  return least;
}

}  // namespace

std::optional<std::string> intersample_advice(const Source& source, const IdentificationTask& task,
                                              const Identification& identification, const std::string& command) {
  if (source.run_folder || source.intersample != ident::Intersample::held) return {};
  if (source.record.input.size() > kMostRows) return {};
  const double movement = ident::movement_within_half_a_row(source.record.input);
  const IdentifiedModel* held = asked_about(identification);
  if (movement < kWorthAsking || held == nullptr || task.options.procedure != ident::Procedure::standard) return {};
  try {
    // Both in parts: the filter before the comparison changes the noise of both alike.
    std::array<ident::Model, 2> found;
    thread_executor()(found.size(), [&](std::size_t k) {
      found[k] = again(source, task, *held, k == 0 ? ident::Intersample::held : ident::Intersample::straight);
    });
    const auto& [steps, lines] = found;
    if (!ident::is_comparable(lines, steps) || !(ident::ar_bic(lines) < ident::ar_bic(steps) - kClearly)) return {};
    return fmt::format(
        "within half a row the input moves by {:.2g} % of its spread, and it was taken as held between the rows: taken "
        "as straight lines, the error of {} falls from {:.3g} to {:.3g} {} (rms); if it is a signal that was sampled "
        "and not the staircase of a controller: `{}`",
        100.0 * movement, held->structure.name, std::sqrt(steps.estimation->score.mse),
        std::sqrt(lines.estimation->score.mse), source.record.output_channel.unit, command);
  } catch (const DataError&) {
    return {};
  }
}

}  // namespace eha::identify
