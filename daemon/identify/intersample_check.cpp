// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/intersample_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/kept_values.hpp"
#include "ident/signal/value_step.hpp"

namespace eha::identify {
namespace {

constexpr double kWorthAsking = 0.005;  // movement within half a row, share of the input's standard deviation
constexpr double kClearly = 20.0;       // of AR-BIC
constexpr Eigen::Index kMostRows = 1'000'000;

constexpr double kRepeats = 0.1;   // of the rows, from which on an input is a staircase
constexpr double kMuch = 0.1;      // movement within half a row that matters whatever a model takes up
constexpr double kFalls = 0.98;    // of the error, at most, to be told as a fall
constexpr double kFarFalls = 0.7;  // the same, which leaves half of what was left over to the rows' halves

/// Whether so many rows repeat the input of the row before that it is a controller's staircase, sampled off its edges:
/// a signal that moves as much repeats none, unless its converter is so coarse that it moves by single codes.
bool is_staircase(const Eigen::VectorXd& input) {
  Eigen::Index repeats = 0;
  for (Eigen::Index k = 1; k < input.size(); ++k) repeats += ident::is_same_value(input[k], input[k - 1]) ? 1 : 0;
  return static_cast<double>(repeats) > kRepeats * static_cast<double>(input.size()) &&
         !ident::moves_by_single_steps({input.data(), static_cast<std::size_t>(input.size())});
}

bool has_zero_or_delay(const ident::Model& model) {
  return model.transfer_function.numerator.size() > 1 || model.transfer_function.delay_s > 0.0;
}

/// Whether a model has what half a row may have made: a zero, a dead time, an estimated order or a map.
bool takes_up_half_a_row(const ident::Model& model) {
  return has_zero_or_delay(model) || model.input_map || ident::has_estimated_order(model);
}

/// A structure to fit to the record in parts, from a model that was found.
struct Attempt {
  const ident::Model* from;
  ident::StructureOptions structure;  ///< of that model, or with a free dead time
  ident::Intersample intersample;
};

ident::Model again(const Source& source, ident::FitOptions options, const Attempt& attempt) {
  const ident::Record fine = ident::in_parts(source.record, attempt.intersample);
  options.decimation *= ident::kPartsOfARow;
  options.intervals = ident::IntervalMethod::straight;
  options.search = ident::Search::nearest;
  options.reported = ident::Reported::score;
  const ident::PreparedRecord prepared(fine, options);
  return ident::fit(prepared, attempt.structure, options, thread_executor(), {*attempt.from}).model;
}

double error(const ident::Model& model) { return std::sqrt(model.estimation->score.mse); }

/// Whether a record says anything of its input between the rows.
bool may_tell(const Source& source) {
  return !source.run_folder && source.intersample == ident::Intersample::held &&
         source.record.input.size() <= kMostRows &&
         ident::movement_within_half_a_row(source.record.input) >= kWorthAsking && !is_staircase(source.record.input);
}

/// @param by  of AR-BIC
bool is_better(const ident::Model& a, const ident::Model& b, double by = 0.0) {
  return ident::is_comparable(a, b) && ident::ar_bic(a) < ident::ar_bic(b) - by;
}

/// The structure with a free dead time, which the half row may have hidden; none where it has a zero or dead time.
std::optional<ident::StructureOptions> with_delay(const IdentifiedModel& model) {
  if (has_zero_or_delay(model.result.model)) return std::nullopt;
  ident::StructureOptions delayed = model.structure;
  delayed.structure.delay.freedom = ident::Freedom::free;
  return delayed;
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

/// The models without what may stand for the half row alone (takes_up_half_a_row()): the closest one, and the one
/// of fewest parameters, which half a row may have hidden; none where the one asked about has none of that.
std::vector<const IdentifiedModel*> without_half_row(const Identification& identification,
                                                     const IdentifiedModel& asked) {
  if (!takes_up_half_a_row(asked.result.model)) return {};
  const IdentifiedModel* closest = nullptr;
  const IdentifiedModel* simplest = nullptr;
  const auto lower = [](const IdentifiedModel& a, const IdentifiedModel* b) {
    return b == nullptr || ident::ar_bic(a.result.model) < ident::ar_bic(b->result.model);
  };
  const auto parameters = [](const IdentifiedModel& m) { return m.result.model.parameters.size(); };
  for (const IdentifiedModel& m : identification.models) {
    if (!m.result.model.estimation || takes_up_half_a_row(m.result.model)) continue;
    if (lower(m, closest)) closest = &m;
    if (simplest == nullptr || parameters(m) < parameters(*simplest) ||
        (parameters(m) == parameters(*simplest) && lower(m, simplest)))
      simplest = &m;
  }
  if (closest == nullptr) return {};
  return closest == simplest ? std::vector{closest} : std::vector{closest, simplest};
}

/// Twice the standard error of the lags together [s], by those of the two lowest coefficients that a denominator has;
/// infinite where they are not known.
double uncertainty_of_lags_s(const ident::Model& model) {
  if (ident::has_estimated_order(model)) return std::numeric_limits<double>::infinity();
  std::vector<double> lowest;  // coefficients, of ascending powers; an integrator has none of the lowest power
  for (const ident::Term& term : model.transfer_function.denominator) {
    if (term.coefficient != 0.0) lowest.insert(lowest.begin(), term.coefficient);
  }
  if (lowest.size() < 2) return std::numeric_limits<double>::infinity();
  lowest.resize(2);
  double share = 0.0;
  for (const ident::ParameterEstimate& p : model.parameters) {
    const bool is_one = std::find(lowest.begin(), lowest.end(), p.value) != lowest.end();
    if (p.role == ident::ParameterRole::denominator_coefficient && is_one && !p.fixed) {
      share = std::hypot(share, p.std / std::abs(p.value));
    }
  }
  const double value = lowest[1] / lowest[0];
  return share > 0.0 ? 2.0 * share * std::abs(value) : std::numeric_limits<double>::infinity();
}

/// Whether half a row lies beyond the uncertainty of the dead time, or of the lags where there is none; a zero has no
/// such uncertainty here.
bool half_a_row_shows(const ident::Model& model, double half_row_s) {
  if (!(model.transfer_function.delay_s > 0.0)) {
    return model.transfer_function.numerator.size() > 1 || uncertainty_of_lags_s(model) < half_row_s;
  }
  const auto delay = std::find_if(model.parameters.begin(), model.parameters.end(),
                                  [](const ident::ParameterEstimate& p) { return p.name == "delay_s" && !p.fixed; });
  return delay != model.parameters.end() && !(2.0 * delay->std > half_row_s);
}

/// What half a row changes in a model that takes it up, where the error does not tell.
std::string undecided(const ident::Model& model, double half_row_s) {
  const std::string half = ident::figure_text(1e3 * half_row_s);
  if (model.transfer_function.delay_s > 0.0) {
    return fmt::format("the dead time is half a row longer ({:.4g} + {} ms)", 1e3 * model.transfer_function.delay_s,
                       half);
  }
  if (model.transfer_function.numerator.size() > 1) {
    return fmt::format("{} ms (half a row) of its zero are none of the plant", half);
  }
  return fmt::format("its lags together are {} ms (half a row) longer", half);
}

}  // namespace

std::optional<BetweenRows> input_between_rows(const Source& source, const IdentificationTask& task,
                                              const Identification& identification) {
  const IdentifiedModel* held = asked_about(identification);
  if (!may_tell(source) || held == nullptr || task.options.procedure != ident::Procedure::standard) return {};
  const double movement = ident::movement_within_half_a_row(source.record.input);
  try {
    // Both in parts: the filter before the comparison changes the noise of both alike.
    const std::vector<const IdentifiedModel*> simpler = without_half_row(identification, *held);
    const std::optional<ident::StructureOptions> delayed = with_delay(*held);
    const ident::Model* from = &held->result.model;
    std::vector<Attempt> attempts{{from, held->structure, ident::Intersample::held},
                                  {from, held->structure, ident::Intersample::straight},
                                  {from, held->structure, ident::Intersample::smooth}};
    if (delayed) {
      attempts.push_back({from, *delayed, ident::Intersample::straight});
      attempts.push_back({from, *delayed, ident::Intersample::held});
    }
    const std::size_t others = attempts.size();
    for (const auto* m : simpler) attempts.push_back({&m->result.model, m->structure, ident::Intersample::straight});
    std::vector<ident::Model> found(attempts.size());
    thread_executor()(attempts.size(), [&](std::size_t k) { found[k] = again(source, task.options, attempts[k]); });
    const ident::Model& steps = found[0];
    const ident::Model& smooth = found[2];
    const auto falls_far = [](const ident::Model& straight, const ident::Model& as_held) {
      return is_better(straight, as_held, kClearly) && error(straight) < kFarFalls * error(as_held);
    };
    // A dead time may explain as much beside a held input, so that both have it.
    const bool is_straight = falls_far(found[1], steps) || (delayed && falls_far(found[3], found[4]));
    const ident::Model& lines = delayed && is_better(found[3], found[1]) ? found[3] : found[1];
    const auto better = std::find_if(found.begin() + static_cast<std::ptrdiff_t>(others), found.end(),
                                     [&](const ident::Model& m) { return is_better(m, steps); });
    const std::string unit = ident::after_number(source.record.output_channel.unit);
    const std::string moves = fmt::format(
        "within half a row the input moves by {} % of its spread, and it was taken as held between the rows",
        ident::figure_text(100.0 * movement));
    std::string gain;
    if (is_better(lines, steps, kClearly) && error(lines) < kFalls * error(steps)) {
      gain = fmt::format("the error of {} falls from {:.3g} to {:.3g}{} (rms)", held->structure.name, error(steps),
                         error(lines), unit);
    } else if (better != found.end()) {
      gain = fmt::format(
          "{} errs by {:.3g}{} (rms) and {}, which has more parameters, by {:.3g}: what that has more may stand for "
          "half a row alone",
          simpler[static_cast<std::size_t>(better - found.begin()) - others]->structure.name, error(*better), unit,
          held->structure.name, error(steps));
    } else if ((movement > kMuch || half_a_row_shows(held->result.model, 0.5 * source.record.step_s)) &&
               !is_better(steps, smooth, kClearly)) {
      return BetweenRows{.seen = moves, .undecided = undecided(held->result.model, 0.5 * source.record.step_s)};
    }
    if (gain.empty()) return {};
    return BetweenRows{.seen = fmt::format("{}: taken as straight lines, {}", moves, gain), .is_straight = is_straight};
  } catch (const DataError&) {
    return {};
  }
}

bool are_straight(const std::vector<Source>& sources, const std::vector<const ident::Model*>& models) {
  double log_ratio = 0.0;  // of the errors, straight over held
  double gained = 0.0;     // of AR-BIC
  int told = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!may_tell(sources[i]) || !models[i]->structure) continue;
    ident::FitOptions options = sources[i].experiment ? sources[i].experiment->fit : ident::FitOptions{};
    options.split = 1.0;
    const auto fitted = [&](ident::Intersample intersample) {
      return again(sources[i], options, {models[i], *models[i]->structure, intersample});
    };
    try {
      const ident::Model held = fitted(ident::Intersample::held);
      const ident::Model straight = fitted(ident::Intersample::straight);
      if (!ident::is_comparable(straight, held)) continue;
      log_ratio += std::log(error(straight) / error(held));
      gained += ident::ar_bic(held) - ident::ar_bic(straight);
      ++told;
    } catch (const DataError&) {
      continue;
    }
  }
  return told > 0 && log_ratio < told * std::log(kFarFalls) && gained > kClearly;
}

std::string advice_of(const BetweenRows& found, const std::string& command) {
  if (found.undecided.empty()) {
    return fmt::format("{}; if it is a signal that was sampled and not the staircase of a controller: `{}`", found.seen,
                       command);
  }
  return fmt::format(
      "{}, as a controller holds it; if it is a signal that was sampled, which the record does not rule out, {}: `{}`",
      found.seen, found.undecided, command);
}

}  // namespace eha::identify
