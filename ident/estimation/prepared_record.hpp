// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "ident/estimation/fit_rows.hpp"
#include "ident/estimation/output_error.hpp"
#include "ident/search/global_search.hpp"

namespace eha::ident {

/// What every fit to the same rows of a record needs. The record must outlive it.
class PreparedRecord {
 public:
  /// @param options  whose decimation, discarded time and split apply to all fits
  /// @throws DataError  too few rows are left to estimate from
  PreparedRecord(const Record& whole, const FitOptions& options)
      : record(whole), rows(fit_rows(whole, options)), coarse(coarsen(whole, rows.discarded, rows.last)) {}

  const Record& record;
  FitRows rows;
  std::vector<CoarseRecord> coarse;

  /// The compared rows, computed once for each pair of options. Not thread-safe.
  [[nodiscard]] const ComparedRecord& compared(bool past, bool keep_input) const {
    std::unique_ptr<const ComparedRecord>& one = compared_[{past, keep_input}];
    if (!one) {
      one = std::make_unique<ComparedRecord>(record, rows.comparison, rows.estimating,
                                             ComparedRecord::Options{.past = past, .keep_input = keep_input});
    }
    return *one;
  }

 private:
  mutable std::map<std::pair<bool, bool>, std::unique_ptr<const ComparedRecord>> compared_;
};

}  // namespace eha::ident
