// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/inside_fits.hpp"

#include <utility>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/sub_structures.hpp"
#include "ident/estimation/valve_starts.hpp"

namespace eha::ident {
namespace {

/// A signature tells neither requests nor the initial state.
bool is_plain(const StructureOptions& asked) {
  return asked.parameters.empty() && asked.initial_state == InitialState::automatic;
}

}  // namespace

InsideFits::InsideFits(const PreparedRecord& prepared, const FitOptions& options, Executor executor)
    : prepared_(prepared), options_(options), executor_(std::move(executor)) {
  options_.intervals = IntervalMethod::straight;
  options_.reported = Reported::score;
}

Work InsideFits::fit(const StructureOptions& asked, const FitProgress& progress) {
  if (!shares_ || !is_plain(asked)) forget();
  shares_ = is_plain(asked);
  counted_.clear();
  count(asked);
  done_ = 0;
  work_ = {};
  fit_inside(asked, progress);
  // The asked structure's own for two: its search is wider and its intervals are determined.
  if (progress) progress(static_cast<double>(done_) / (static_cast<double>(counted_.size()) + 2.0), asked.name);
  return work_;
}

void InsideFits::take(const StructureOptions& asked, const Model& fitted) {
  if (!shares_ || !is_plain(asked) || !fitted.estimation || !fitted_.insert(signature(asked)).second) return;
  if (fitted.estimation->information) structures_.push_back({signature(asked), fitted.estimation->information->ar_bic});
  models_.push_back(fitted);
}

void InsideFits::forget() {
  fitted_.clear();
  models_.clear();
  structures_.clear();
}

void InsideFits::count(const StructureOptions& asked) {
  for (const StructureOptions& smaller : sub_structures(asked)) {
    const std::string name = signature(smaller);
    if (!fitted_.contains(name) && counted_.insert(name).second) count(smaller);
  }
}

void InsideFits::fit_inside(const StructureOptions& asked, const FitProgress& progress) {
  for (const StructureOptions& smaller : sub_structures(asked)) {
    const std::string name = signature(smaller);
    if (!fitted_.insert(name).second) continue;
    fit_inside(smaller, progress);
    if (progress) {
      progress(static_cast<double>(done_) / (static_cast<double>(counted_.size()) + 2.0), smaller.name);
    }
    ++done_;
    try {
      // The basin of a fractional optimum need not hold a structure of integer order.
      const bool is_integer = has_finite_state(smaller.structure) || asked_behind_valve(smaller);
      options_.search = is_integer ? Search::known : Search::global;
      FitResult fitted = fit_by_default(prepared_, smaller, options_, executor_, models_);
      if (fitted.model.estimation->information) {
        structures_.push_back({name, fitted.model.estimation->information->ar_bic});
      }
      models_.push_back(std::move(fitted.model));
      work_ += total(fitted.work);
    } catch (const DataError&) {
      // No stable model, or no map where the input does not pass the dead band on both sides: nothing to start from.
    }
  }
}

}  // namespace eha::ident
