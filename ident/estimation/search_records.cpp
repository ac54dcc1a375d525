// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/search_records.hpp"

#include <utility>

#include "ident/signal/decimation.hpp"

namespace eha::ident {
namespace {

// What the search's simulations may be wrong by, relative to the response: far below what tells optima apart.
constexpr double kSearchGuard = 1.6;
constexpr double kSearchResolved = 1e-7;

}  // namespace

std::vector<SearchRecord> search_records(const std::vector<CoarseRecord>& coarse, const StructureOptions& asked,
                                         bool past, bool behind_map) {
  std::vector<SearchRecord> all;
  for (const CoarseRecord& shortened : coarse) {
    const auto length = static_cast<std::size_t>(shortened.record.input.size());
    std::vector<PoleGuess> guesses;
    if (has_finite_state(asked.structure)) {
      guesses = guess_poles(shortened.record, length, static_cast<int>(state_count(asked.structure)),
                            asked.structure.delay.freedom == Freedom::free);
    }
    ComparedRecord::Options options{past, kSearchGuard, kSearchResolved, {}, 1, behind_map};
    if (behind_map) {
      options.fine_input = shortened.fine_input;
      options.block = shortened.block;
    }
    all.push_back({ComparedRecord(shortened.record, compare_every(length, 1, shortened.first), shortened.rows, options),
                   std::move(guesses)});
  }
  return all;
}

std::vector<Eigen::VectorXd> pole_starts(const Parametrisation& parametrisation, const SearchRecord& record) {
  std::vector<Eigen::VectorXd> starts;
  for (const PoleGuess& guess : record.guesses) {
    if (const auto theta = parametrisation.at_poles(guess.poles, guess.delay_s)) starts.push_back(*theta);
  }
  return starts;
}

}  // namespace eha::ident
