// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/trial.hpp"

#include <utility>

#include "core/error.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"

namespace eha::identify {

std::optional<ident::Model> fit_that_holds(const IdentificationTask& task, const ident::PreparedRecord& prepared,
                                           const ident::StructureOptions& asked, const Manner& manner) {
  ident::FitOptions options = task.options;
  options.search = manner.search;
  options.intervals = ident::IntervalMethod::straight;
  options.most_mse = manner.most_mse;
  try {
    ident::FitResult result = ident::fit(prepared, asked, options, thread_executor(), manner.known);
    judge(task, std::nullopt, result);
    return result.model.verdict->accepted ? std::optional(std::move(result.model)) : std::nullopt;
  } catch (const Error&) {  // the record does not allow it
    return std::nullopt;
  }
}

}  // namespace eha::identify
