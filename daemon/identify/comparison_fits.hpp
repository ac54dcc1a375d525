// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <mutex>
#include <vector>

#include "daemon/identify/comparison.hpp"
#include "daemon/identify/progress.hpp"
#include "daemon/identify/source.hpp"
#include "ident/estimation/inside_fits.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/fit_options.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::identify {

/// Fits of one structure after another to every record of a comparison, several records at the same time. What is
/// inside two structures is fitted once.
class ComparisonFits {
 public:
  /// The sources must outlive it. @param options  of each @param progress  called from any thread, one at a time
  ComparisonFits(const std::vector<Source>& sources, const std::vector<ident::FitOptions>& options, Progress progress);

  /// One structure fitted to all records, each model with its verdict and usable band.
  /// @throws as ident::fit, a DataError with the record's name
  [[nodiscard]] std::vector<ComparedRun> of(const ident::StructureOptions& structure);

  /// The fit of a structure with a dead time where the records need one; empty where none does.
  /// @param without    the fits without one @param structure  theirs; becomes that with the dead time
  [[nodiscard]] std::vector<ComparedRun> with_dead_time(const std::vector<ComparedRun>& without,
                                                        ident::StructureOptions& structure);

 private:
  struct OfRecord {
    ident::PreparedRecord prepared;
    ident::InsideFits inside;
    OfRecord(const Source& source, const ident::FitOptions& options, const ident::Executor& executor);
  };

  [[nodiscard]] ident::FitResult fitted(std::size_t nth, const ident::StructureOptions& structure);
  /// Whether the dead time nearest to fits without one makes so much that it is worth a whole search.
  [[nodiscard]] bool promises_dead_time(const std::vector<ComparedRun>& without, ident::StructureOptions asked);

  const std::vector<Source>& sources_;
  const std::vector<ident::FitOptions>& options_;
  Progress progress_;
  std::mutex showing_;
  ident::Executor inner_;  ///< of one fit
  std::deque<OfRecord> records_;
};

}  // namespace eha::identify
