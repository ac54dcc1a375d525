// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "ident/estimation/fit_rows.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/search/global_search.hpp"
#include "ident/search/realisation.hpp"
#include "ident/validation/signal_facts.hpp"

namespace eha::ident {

/// Data that all fits to the same rows of a record share, made at the first request. The record must outlive it.
/// Thread-safe.
class PreparedRecord {
 public:
  /// @param options  whose decimation, discarded time and split apply to all fits
  /// @throws DataError    the record is not finite or constant, or too few rows are left to estimate from
  /// @throws ConfigError  decimation or split make no sense
  PreparedRecord(const Record& whole, const FitOptions& options);

  const Record& record;
  SignalFacts facts;
  FitRows rows;

  /// Which simulation of the record is wanted.
  struct Kind {
    bool past = false;        ///< an input before t = 0 is wanted
    bool keep_input = false;  ///< a map before G is
    auto operator<=>(const Kind&) const = default;
  };

  /// The compared rows.
  [[nodiscard]] const ComparedRecord& compared(const Kind& kind) const;

  /// What searches from afar simulate: the compared rows where a simulation of them is the cheapest; else fewer rows of
  /// the record, filtered; else the coarse records of coarsen().
  [[nodiscard]] std::vector<const ComparedRecord*> searched(const Kind& kind) const;

  /// Poles guessed from the coarse records and from the compared rows.
  [[nodiscard]] std::vector<PoleGuess> guesses(int poles, bool delay_free) const;

 private:
  [[nodiscard]] const std::vector<CoarseRecord>& coarse() const;
  [[nodiscard]] std::unique_ptr<const ComparedRecord> sparse(const Kind& kind) const;
  [[nodiscard]] std::size_t coarse_effort() const;
  [[nodiscard]] double bandwidth() const;

  mutable std::recursive_mutex making_;
  mutable std::optional<double> bandwidth_;
  mutable std::vector<CoarseRecord> coarse_;
  mutable std::optional<std::vector<ImpulseResponses>> responses_;
  mutable std::map<Kind, std::unique_ptr<const ComparedRecord>> compared_;
  mutable std::map<Kind, std::vector<std::unique_ptr<const ComparedRecord>>> searched_;
};

}  // namespace eha::ident
