// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/input_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/identify/clipped_input_trial.hpp"
#include "daemon/identify/exchange_check.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/refit.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/signal/frozen_input.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/parameter_change.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

using Eigen::Index;
using Kind = ident::CriterionKind;

constexpr Index kMostRowsOfTrial = 1'000'000;
constexpr std::array<std::string_view, 4> kSimpleBases{"integrator_lag_valve", "io_valve", "integrator_lag", "io"};
constexpr std::size_t kMostBasesTried = 2;
constexpr std::array<Index, 6> kShifts{1, 2, 4, 8, 16, 32};  // rows
constexpr double kMostShifted = 0.05;                        // of its rows, for a shift
constexpr double kLessByShift = 0.5;                         // of the error
constexpr double kGainByShift = 50.0;                        // of BIC, where plain noise is left over
constexpr double kLessWithoutFrozen = 0.5;                   // of the error

/// The simple models of a table, those that err least, and the one that stands first in it.
std::vector<const IdentifiedModel*> bases_of(const Identification& identification) {
  std::vector<const IdentifiedModel*> bases;
  for (const IdentifiedModel& one : identification.models) {
    const bool is_simple =
        std::find(kSimpleBases.begin(), kSimpleBases.end(), one.structure.name) != kSimpleBases.end();
    const bool is_first = one.structure.name == identification.recommendation.model;
    const bool is_asked = identification.models.size() <= kMostBasesTried;
    if (one.result.model.estimation && !one.result.model.grey_box && (is_simple || is_first || is_asked)) {
      bases.push_back(&one);
    }
  }
  std::stable_sort(bases.begin(), bases.end(), [](const IdentifiedModel* a, const IdentifiedModel* b) {
    return rms_error_of(a->result.model) < rms_error_of(b->result.model);
  });
  if (bases.size() > kMostBasesTried) bases.resize(kMostBasesTried);
  return bases;
}

/// The record whose rows have the input of so many rows later.
ident::Record with_later_input(const ident::Record& record, Index rows) {
  const Index count = record.input.size() - rows;
  ident::Record found = rows_from(record, 0, count);
  found.input = record.input.tail(count);
  return found;
}

/// A shift of the input that mends it, and how well a model describes the record with it.
struct LateInput {
  WrongInput wrong;
  Index rows = 0;
  double r2_percent = 0.0;
};

std::optional<LateInput> of_late_input(const Source& source, const IdentificationTask& task,
                                       const std::vector<const IdentifiedModel*>& bases) {
  const Index parts = source.record.parts;
  const ident::Record record = tried_rows(task.record, parts);
  const bool is_held = parts == 1;
  // In parts, so that the filter before the comparison takes as much noise away from each.
  ident::FitOptions options = task.options;
  if (is_held) options.decimation *= ident::kPartsOfARow;
  const auto fitted = [&](Index rows, ident::Intersample intersample) {
    const ident::Record moved = with_later_input(record, rows * parts);
    return least_error_of(bases, is_held ? ident::in_parts(moved, intersample) : moved, options);
  };
  const std::optional<Refit> given = fitted(0, ident::Intersample::held);
  if (!given) return std::nullopt;
  double least = given->error;
  if (const auto straight = is_held ? fitted(0, ident::Intersample::straight) : std::nullopt) {
    least = std::min(least, straight->error);
  }
  std::optional<Refit> best;
  Index best_rows = 0;
  const Index all_rows = record.input.size() / parts;
  const auto most = static_cast<Index>(kMostShifted * static_cast<double>(all_rows));
  const auto take = [&](Index rows) {
    if (rows < 1 || rows > most) return;
    const std::optional<Refit> found = fitted(rows, ident::Intersample::held);
    if (!found || (best && !(found->error < best->error))) return;
    best = found;
    best_rows = rows;
  };
  for (const Index rows : kShifts) {
    const Index before = best_rows;
    take(rows);
    if (best_rows == before && best_rows > 0) break;  // it errs more again
  }
  for (Index step = best_rows / 4; step >= 1; step /= 2) {
    const Index middle = best_rows;
    take(middle - step);
    take(middle + step);
  }
  if (best_rows == 2) take(3);
  if (!best) return std::nullopt;
  const bool is_far_less = best->error <= kLessByShift * least;
  if (!is_far_less) {
    // A lag makes up for most of a row or two; that the rest is plain noise then tells.
    const auto samples = static_cast<double>(all_rows);
    if (!(2.0 * samples * std::log(least / best->error) > kGainByShift)) return std::nullopt;
    const auto leaves_plain_noise = [&](Index rows) {
      const auto found =
          least_error_of(bases, with_later_input(record, rows * parts), task.options, ident::Reported::everything);
      return found && ident::leaves_plain_noise(found->model);
    };
    if (leaves_plain_noise(0) || !leaves_plain_noise(best_rows)) return std::nullopt;
  }
  const double row_s = record.step_s * static_cast<double>(parts);
  // A plant whose dead time behind the shifted input is longer than the shift answers after the given one, too: a fit
  // that a drift of the sensor led astray was led back by chance.
  if (best->model.transfer_function.delay_s >= row_s * static_cast<double>(best_rows + 1)) return std::nullopt;
  // Rows that are too slow for the plant look like a column that is one row late.
  if (best_rows == 1 && !task.slow_rows.empty()) return std::nullopt;
  WrongInput wrong{
      fmt::format(
          "The input's column comes about {} row{} ({:.3g} s) late, after the output that it moves: with the "
          "input of as many rows later {} errs {} times as much{}, and no plant answers before its input. If the "
          "input was played, shift the column back (option --input-late {} of `eha fit`), or mend the logger; if a "
          "controller made it from the output, the record is of a loop, and no shift mends it",
          best_rows, best_rows == 1 ? "" : "s", row_s * static_cast<double>(best_rows), best->name,
          ident::figure_text(best->error / least), is_far_less ? "" : " and leaves plain noise over", best_rows),
      fmt::format("--input-late {}", best_rows)};
  return LateInput{std::move(wrong), best_rows, best->model.estimation->score.r2_percent};
}

/// Root mean square of the output's steps.
double motion_of(const ident::Record& record) {
  const Index steps = record.output.size() - 1;
  return std::sqrt((record.output.tail(steps) - record.output.head(steps)).array().square().mean());
}

/// "The input's column froze from 30 to 49.98 s and 2 more times: it keeps 0 V ..."
std::string frozen_text(const Stretches& stretches, const ident::Record& record) {
  const auto& [first, last] = *std::max_element(stretches.begin(), stretches.end(), [](const auto& a, const auto& b) {
    return a.second - a.first < b.second - b.first;
  });
  return fmt::format(
      "The input's column froze from {} to {} s{}: it keeps {:.6g}{} to the last digit while the output "
      "turns about as it does elsewhere, so that what the plant got is not recorded there",
      time_at(record, first), time_at(record, last),
      stretches.size() > 1 ? fmt::format(" and {} more times", stretches.size() - 1) : std::string(),
      record.input[first], ident::after_number(record.input_channel.unit));
}

/// Correlation of x, of zero mean, with the change of y over so many rows from each row on.
double correlation_with_change(const Eigen::VectorXd& x, const Eigen::VectorXd& y, Index rows) {
  const Index count = y.size() - rows;
  Eigen::VectorXd change = y.tail(count) - y.head(count);
  change.array() -= change.mean();
  const double norms = x.head(count).norm() * change.norm();
  return norms > 0.0 ? x.head(count).dot(change) / norms : 0.0;
}

/// Whether an input is plain noise, as of an open wire, and the output, which moves, has no part in it: of white noise
/// every correlation scatters by 1 / sqrt(N).
bool is_noise_beside_the_output(const ident::Record& record) {
  constexpr Index kFewestRows = 500;
  constexpr double kByChance = 5.0;  // standard deviations
  constexpr double kSmooth = 0.7;    // correlation of neighbours, of a motion and not of a sensor's noise
  const Eigen::VectorXd& y = record.output;
  const Index rows = record.input.size();
  if (rows < kFewestRows || y.size() != rows || !record.input.allFinite() || !y.allFinite()) return false;
  const Eigen::VectorXd u = record.input.array() - record.input.mean();
  const Eigen::VectorXd motion = y.array() - y.mean();
  if (!(u.squaredNorm() > 0.0) || !(motion.squaredNorm() > 0.0)) return false;
  if (motion.head(rows - 1).dot(motion.tail(rows - 1)) < kSmooth * motion.squaredNorm()) return false;
  const double bound = kByChance / std::sqrt(static_cast<double>(rows));
  for (Index lag = 1; lag <= 10; ++lag) {
    if (std::abs(u.head(rows - lag).dot(u.tail(rows - lag))) > bound * u.squaredNorm()) return false;
  }
  for (const Index over : {1, 2, 3, 5, 8, 12, 20, 35, 60, 100}) {
    if (std::abs(correlation_with_change(u, y, over)) > bound) return false;
  }
  return true;
}

/// Where a logger repeated its last value; the part without has to fit far better.
std::optional<WrongInput> of_frozen_input(const IdentificationTask& task,
                                          const std::vector<const IdentifiedModel*>& bases) {
  const ident::Record& record = task.record;
  const Stretches stretches = ident::frozen_input(record.input, record.output);
  const auto part = stretches.empty() ? std::nullopt : longest_without(stretches, record.input.size());
  if (!part) return std::nullopt;
  const ident::Record without = rows_from(record, part->first, part->second - part->first);
  const std::optional<Refit> given = least_error_of(bases, record, task.options);
  const std::optional<Refit> found = least_error_of(bases, without, task.options);
  if (!given || !found) return std::nullopt;
  // Each beside the motion that it describes: a part may err less because it is quieter.
  const double quieter = std::min(1.0, motion_of(without) / motion_of(record));
  if (!(found->error <= kLessWithoutFrozen * quieter * given->error)) return std::nullopt;
  const std::string options = cut_to(*part, record);
  return WrongInput{
      fmt::format("{}; cut with {}, or mend the logger and record again", frozen_text(stretches, record), options),
      options};
}

std::optional<WrongInput> of_moved_rows(const Source& source, const IdentificationTask& task,
                                        const std::vector<const IdentifiedModel*>& bases) {
  if (!source.as_even || task.record.parts != 1) return std::nullopt;
  ident::Record even = task.record;
  even.step_s = source.as_even->step_s;
  even.input = source.as_even->input;
  even.output = source.as_even->output;
  const std::optional<Refit> given = least_error_of(bases, task.record, task.options);
  const std::optional<Refit> found = least_error_of(bases, even, task.options);
  if (!given || !found) return std::nullopt;
  if (!(found->error < given->error)) {
    return WrongInput{
        "The rows were moved to even times, the input as if it had switched at the times of the rows; what "
        "the checks find beside may come from that alone: record with an even clock where it matters",
        {},
        true};
  }
  const std::string options = fmt::format("--period {:.6g}", even.step_s);
  return WrongInput{
      fmt::format("The rows were moved to even times although they had been sampled at such, and only their time "
                  "stamps came early or late: taken as even {} errs {} times as much (`{}` in place of --resample). "
                  "What moving them leaves over is no part of the plant",
                  found->name, ident::figure_text(found->error / given->error), options),
      options, true};
}

WrongInput exchanged_columns(const Source& source, const ExchangedFit& other, std::string_view why) {
  return {fmt::format("Input and output may be exchanged: {}, and the other way round {} has a validation R2 of {} %",
                      why, other.name, ident::percent_text(other.r2_percent)),
          source.exchange};
}

std::optional<WrongInput> of_exchanged_columns(const Source& source, const IdentificationTask& task,
                                               const Identification& identification) {
  const auto other = source.exchange.empty() ? std::nullopt : exchanged_fit(source, task, identification);
  if (!other) return std::nullopt;
  const bool any_accepted = std::any_of(identification.models.begin(), identification.models.end(), is_accepted);
  return exchanged_columns(source, *other,
                           any_accepted ? "the output comes before the input" : "no model passes its checks");
}

}  // namespace

std::optional<WrongInput> wrong_input(const Source& source, const IdentificationTask& task,
                                      const Identification& identification, const Progress& progress) {
  // A loop has no input to mend, and the copy of a run's record the run's own.
  if (is_loop_noted(identification) || source.is_closed_loop || source.is_of_run) return std::nullopt;
  // Of exchanged columns a later input explains more, too.
  if (auto found = of_exchanged_columns(source, task, identification)) return found;
  const bool is_known = source.run_folder || !task.frozen.empty();
  if (is_known || task.options.procedure == ident::Procedure::paper || task.record.input.size() > kMostRowsOfTrial) {
    return std::nullopt;
  }
  const IdentifiedModel* first = recommended_model(identification);
  if (first != nullptr && !misses_something(first->result.model)) return std::nullopt;
  const std::vector<const IdentifiedModel*> bases = bases_of(identification);
  if (bases.empty()) return std::nullopt;
  const auto say = [&](double share, const char* what) {
    if (progress) progress(share, std::string("testing whether the input's column ") + what);
  };
  if (auto found = of_moved_rows(source, task, bases)) return found;
  say(0.0, "froze or is clipped");
  if (auto found = of_frozen_input(task, bases)) return found;
  if (auto found = of_clipped_input(source, task, bases)) return found;
  // What the input did in a gap is not known; a later input makes up for a part of that, too.
  const auto has_gaps = [](const IdentifiedModel& one) { return !ident::gaps_in_record(one.result.model).empty(); };
  if (std::any_of(identification.models.begin(), identification.models.end(), has_gaps)) return std::nullopt;
  say(0.5, "comes late");
  std::optional<LateInput> late = of_late_input(source, task, bases);
  if (!late) return std::nullopt;
  // A curved gain bends an edge of the input as a row that is late does.
  if (late->rows == 1 && first != nullptr &&
      ident::nonlinear_kind(first->result.model, *first->result.model.verdict) == ident::NonlinearKind::level) {
    return std::nullopt;
  }
  if (const auto other = exchanged_fit(source, task.options, late->r2_percent)) {
    return exchanged_columns(source, *other, "the output comes before the input");
  }
  return late->wrong;
}

std::optional<WrongInput> lost_input(const Source& source) {
  constexpr double kLong = 0.1;  // of the rows
  const ident::Record& record = source.record;
  if (source.run_folder || source.is_of_run || source.is_closed_loop || source.loop || !source.frozen.empty()) {
    return std::nullopt;
  }
  const Stretches stretches = ident::frozen_input(record.input, record.output);
  Index rows = 0;
  for (const auto& [first, last] : stretches) rows += last - first + 1;
  if (static_cast<double>(rows) >= kLong * static_cast<double>(record.input.size()) && rows > 0) {
    const auto part = longest_without(stretches, record.input.size());
    return WrongInput{frozen_text(stretches, record), part ? cut_to(*part, record) : std::string()};
  }
  if (!is_noise_beside_the_output(record)) return std::nullopt;
  const double rms = std::sqrt((record.input.array() - record.input.mean()).square().mean());
  return WrongInput{fmt::format(
      "The input is plain noise of {:.3g}{} (rms) in which the output, which moves, has no part: its wire is "
      "off, or it is another column than the input's",
      rms, ident::after_number(record.input_channel.unit))};
}

void reject_for(const WrongInput& wrong, const IdentificationTask& task, Identification& identification) {
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    model.provenance[wrong.are_times ? ident::kMovedRows : ident::kWrongInput] = wrong.sentence;
    if (wrong.are_times && !wrong.options.empty()) model.provenance[ident::kAsSampled] = wrong.options;
    const auto band = model.verdict ? model.verdict->usable_band : std::nullopt;
    model.verdict = ident::judge(model, task.acceptance, facts_of(task));
    model.verdict->usable_band = band;
  }
  // Neither another start nor another experiment mends a column.
  identification.next_experiment.reset();
  if (identification.rounds.size() > 1) identification.rounds.resize(1);
  identification.mended_input = wrong.options;
  choose(task, identification);
}

}  // namespace eha::identify
