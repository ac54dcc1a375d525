// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/prepared_record.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {
namespace {

// What the search's simulations may be wrong by, relative to the response: far below what tells optima apart.
constexpr double kSearchGuard = 1.6;
constexpr double kSearchResolved = 1e-7;
// Longer ones have a search on coarse records alone: the tables of their whole length would cost more than they save.
constexpr std::size_t kMostSparselySearched = 1'000'000;

/// The compared rows as a record of their own, the input averaged between them.
Record averaged(const Record& record, const FitRows& rows) {
  const auto every = static_cast<Eigen::Index>(rows.comparison.every);
  const auto first = static_cast<Eigen::Index>(rows.comparison.first);
  const Eigen::VectorXd output =
      picked(record.output, rows.comparison).head(static_cast<Eigen::Index>(rows.estimating));
  Record block;
  block.step_s = record.step_s * static_cast<double>(every);
  const Eigen::Index count = std::min(output.size(), (record.input.size() - first) / every);
  block.input.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) block.input[k] = record.input.segment(first + k * every, every).mean();
  block.output = output.head(count);
  return block;
}

}  // namespace

PreparedRecord::PreparedRecord(const Record& whole, const FitOptions& options) : record(whole), facts(whole) {
  check_record(whole, options);
  rows = fit_rows(whole, options);
}

const std::vector<CoarseRecord>& PreparedRecord::coarse() const {
  if (coarse_.empty()) coarse_ = coarsen(record, bandwidth(), rows.discarded, rows.last);
  return coarse_;
}

double PreparedRecord::bandwidth() const {
  if (!bandwidth_) bandwidth_ = output_bandwidth(record.output);
  return *bandwidth_;
}

const ComparedRecord& PreparedRecord::compared(const Kind& kind) const {
  const std::scoped_lock lock(making_);
  std::unique_ptr<const ComparedRecord>& one = compared_[kind];
  if (!one) {
    one = std::make_unique<ComparedRecord>(record, rows.comparison, rows.estimating,
                                           ComparedRecord::Options{.past = kind.past, .keep_input = kind.keep_input});
  }
  return *one;
}

std::size_t PreparedRecord::coarse_effort() const {
  std::size_t sum = 0;
  for (const CoarseRecord& shortened : coarse()) {
    sum += HeldResponse::effort_of(static_cast<std::size_t>(shortened.record.input.size()), kSearchGuard);
  }
  return sum;
}

std::unique_ptr<const ComparedRecord> PreparedRecord::sparse(const Kind& kind) const {
  const std::size_t every = search_spacing(bandwidth(), rows.last);
  if (every <= rows.comparison.every || rows.last > kMostSparselySearched) return {};
  const Comparison comparison = compare_every(static_cast<std::size_t>(record.input.size()), every, rows.discarded);
  // Windows end with the rows that estimate.
  const std::size_t end = comparison.first + comparison.taps.size() / 2;
  const std::size_t count = end > rows.last ? 0 : std::min(comparison.count, (rows.last - end) / every + 1);
  if (count < static_cast<std::size_t>(kFewestRows)) return {};
  return std::make_unique<ComparedRecord>(
      record, comparison, count,
      ComparedRecord::Options{
          .past = kind.past, .guard = kSearchGuard, .resolved = kSearchResolved, .keep_input = kind.keep_input});
}

std::vector<const ComparedRecord*> PreparedRecord::searched(const Kind& kind) const {
  const std::scoped_lock lock(making_);
  const ComparedRecord& whole = compared(kind);
  const std::size_t most = coarse_effort();
  if (whole.response().effort() <= most) return {&whole};
  std::vector<std::unique_ptr<const ComparedRecord>>& made = searched_[kind];
  if (made.empty()) {
    if (auto one = sparse(kind); one && one->response().effort() <= most) made.push_back(std::move(one));
  }
  if (made.empty()) {
    for (const CoarseRecord& shortened : coarse()) {
      const auto length = static_cast<std::size_t>(shortened.record.input.size());
      ComparedRecord::Options options{kind.past, kSearchGuard, kSearchResolved, {}, 1, kind.keep_input};
      if (kind.keep_input) {
        options.fine_input = shortened.fine_input;
        options.block = shortened.block;
      }
      made.push_back(std::make_unique<ComparedRecord>(shortened.record, compare_every(length, 1, shortened.first),
                                                      shortened.rows, options));
    }
  }
  std::vector<const ComparedRecord*> all;
  for (const auto& one : made) all.push_back(one.get());
  return all;
}

std::vector<PoleGuess> PreparedRecord::guesses(int poles, bool delay_free) const {
  const std::scoped_lock lock(making_);
  if (!responses_) {
    responses_.emplace();
    for (const CoarseRecord& shortened : coarse()) {
      responses_->emplace_back(shortened.record, static_cast<std::size_t>(shortened.record.input.size()));
    }
    if (rows.comparison.every > 1) {
      const Record block = averaged(record, rows);
      responses_->emplace_back(block, static_cast<std::size_t>(block.input.size()));
    }
  }
  std::vector<PoleGuess> all;
  for (const ImpulseResponses& responses : *responses_) {
    for (PoleGuess& guess : responses.poles(poles, delay_free)) all.push_back(std::move(guess));
  }
  return all;
}

}  // namespace eha::ident
