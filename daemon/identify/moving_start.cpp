// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/moving_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "ident/estimation/judging_part.hpp"
#include "ident/signal/kept_values.hpp"

namespace eha::identify {
namespace {

constexpr double kFewestRows = 3.0;      // of a dead time
constexpr double kMostOfRecord = 0.1;    // of it, for the rows that are left out
constexpr double kBehindDeadTime = 1.1;  // times the dead time, whose estimate errs
constexpr std::size_t kSimpleTerms = 3;  // of a denominator, with one of a numerator: no pole and zero are one too many

std::ptrdiff_t free_count(const ident::Model& model) {
  return std::count_if(model.parameters.begin(), model.parameters.end(), [](const auto& p) { return !p.fixed; });
}

bool has_terms_to_spare(const ident::Model& model) {
  const ident::TransferFunction& g = model.transfer_function;
  return g.denominator.size() > kSimpleTerms || g.numerator.size() > 1 || ident::has_estimated_order(model);
}

/// Whether it answers late, or at first the wrong way, by which a zero stands for a dead time.
bool answers_late(const ident::TransferFunction& g) {
  return g.delay_s > 0.0 || std::any_of(g.numerator.begin(), g.numerator.end(), [&](const ident::Term& term) {
           return term.coefficient * g.numerator.front().coefficient < 0.0;
         });
}

/// The greatest dead time that an integer-order model of a record in motion has; 0 without one.
double dead_time_s(const Identification& identification) {
  double greatest = 0.0;
  for (const IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    const bool is_whole = !ident::has_estimated_order(model) && !model.grey_box;
    if (is_whole) greatest = std::max(greatest, model.transfer_function.delay_s);
  }
  return greatest;
}

/// Goes on with a task that leaves out rows. @returns its last remark, which says so
std::string taken(IdentificationTask later, Identification again, IdentificationTask& task,
                  Identification& identification) {
  task.options = later.options;
  task.remarks = std::move(later.remarks);
  identification = std::move(again);
  return task.remarks.back();
}

}  // namespace

std::string leave_out_moving_start(IdentificationTask& task, Identification& identification, const FitTask& fit) {
  if (task.options.procedure == ident::Procedure::paper || !task.structures.empty()) return {};
  const IdentifiedModel* best = recommended_model(identification);
  if (best != nullptr &&
      !(has_terms_to_spare(best->result.model) && answers_late(best->result.model.transfer_function))) {
    return {};
  }
  const double step_s = task.record.step_s;
  const double behind_s = std::ceil(kBehindDeadTime * dead_time_s(identification) / step_s) * step_s;
  const double length_s = step_s * static_cast<double>(task.record.output.size());
  const bool is_moving = std::any_of(identification.models.begin(), identification.models.end(),
                                     [](const auto& one) { return !one.result.model.initial_state.empty(); });
  if (!is_moving || behind_s < kFewestRows * step_s || behind_s > kMostOfRecord * length_s) return {};
  if (task.options.discard_s >= behind_s) return {};
  IdentificationTask later = task;
  later.options.discard_s = behind_s;
  later.remarks.push_back(fmt::format(
      "the record begins in motion: its first {:.3g} s count for nothing, as the input before the first row acts there "
      "for as long as the dead time; --discard {:.3g} does the same",
      behind_s, behind_s));
  try {
    Identification again = fit(later);
    const IdentifiedModel* anew = recommended_model(again);
    if (anew == nullptr || (best != nullptr && free_count(anew->result.model) >= free_count(best->result.model)))
      return {};
    return taken(std::move(later), std::move(again), task, identification);
  } catch (const DataError&) {  // too few rows are left
    return {};
  }
}

std::string leave_out_resting_start(IdentificationTask& task, Identification& identification, const FitTask& fit) {
  constexpr double kLongRest = 0.3;      // of the rows
  constexpr double kKeptRest = 0.05;     // of the rows behind it, by which the level is known
  constexpr Eigen::Index kFewest = 100;  // rows behind it
  if (task.options.procedure == ident::Procedure::paper || recommended_model(identification) != nullptr) return {};
  const Eigen::VectorXd& input = task.record.input;
  Eigen::Index moves = 0;
  while (moves < input.size() && ident::is_same_value(input[moves], input[0])) ++moves;
  const Eigen::Index behind = input.size() - moves;
  if (static_cast<double>(moves) < kLongRest * static_cast<double>(input.size()) || behind < kFewest) return {};
  const auto kept = static_cast<Eigen::Index>(kKeptRest * static_cast<double>(behind));
  const double rest_s = task.record.step_s * static_cast<double>(moves - kept);
  if (task.options.discard_s >= rest_s) return {};
  IdentificationTask later = task;
  later.options.discard_s = rest_s;
  if (!task.is_split_given) {
    if (const auto other = ident::covering_split(later.record, later.options)) later.options.split = other->share;
  }
  later.remarks.push_back(
      fmt::format("the input rests at first, for {:.0f} % of the record: the first {:.3g} s count for nothing, so that "
                  "the part that "
                  "estimates and the one that judges have motion; --discard {:.3g} does the same",
                  100.0 * static_cast<double>(moves) / static_cast<double>(input.size()), rest_s, rest_s));
  try {
    Identification again = fit(later);
    if (recommended_model(again) == nullptr) return {};
    return taken(std::move(later), std::move(again), task, identification);
  } catch (const DataError&) {  // too few rows are left
    return {};
  }
}

}  // namespace eha::identify
