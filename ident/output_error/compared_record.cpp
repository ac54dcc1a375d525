// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "ident/output_error/output_error.hpp"

namespace eha::ident {
namespace {

constexpr int kPastWindows = 8;

/// Returns the number of rows before t = 0 at which each window of the past begins, the latest window first.
std::vector<std::size_t> past_edges(std::size_t rows) {
  std::vector<std::size_t> edges;
  for (int k = kPastWindows - 1; k >= 0; --k) {
    const auto edge = static_cast<std::size_t>(std::llround(std::ldexp(static_cast<double>(rows), -k)));
    if (edge > (edges.empty() ? 0 : edges.back())) edges.push_back(edge);
  }
  return edges;
}

std::size_t compared_length(const Comparison& comparison, std::size_t rows) {
  return rows == 0 ? 0 : comparison.first + (rows - 1) * comparison.every + 1;
}

/// @param before  rows of the past, at the beginning of the simulation
OutputSelection selection(const Record& record, const Comparison& comparison, std::size_t rows, double resolved,
                          std::size_t before) {
  OutputSelection s;
  s.resolved = resolved;
  s.step_s = record.step_s;
  s.first = before + comparison.first;
  s.every = comparison.every;
  s.count = rows;
  s.filter_taps = comparison.taps;
  // Samples after the last row's window cannot reach it.
  s.samples = rows == 0 ? 0 : before + compared_length(comparison, rows) + comparison.taps.size() / 2;
  return s;
}

Thinning means_over(Eigen::Index block, Eigen::Index count) {
  const std::vector<double> taps(static_cast<std::size_t>(block), 1.0 / static_cast<double>(block));
  return {taps, taps.size(), static_cast<std::ptrdiff_t>(block - 1),
          std::vector<double>(static_cast<std::size_t>(count), 1.0)};
}

}  // namespace

ComparedRecord::ComparedRecord(const Record& record, const Comparison& comparison, std::size_t rows,
                               const Options& options)
    : ComparedRecord(record, comparison, rows, options,
                     options.past ? past_edges(compared_length(comparison, rows)) : std::vector<std::size_t>{}) {}

ComparedRecord::ComparedRecord(const Record& record, const Comparison& comparison, std::size_t rows,
                               const Options& options, const std::vector<std::size_t>& edges)
    : response_(selection(record, comparison, rows, options.resolved, edges.empty() ? 0 : edges.back()), options.guard),
      before_(edges.empty() ? 0 : edges.back()),
      block_(options.block),
      step_(response_.step_spectrum(edges.empty() ? 0 : edges.back())),
      rows_(record, comparison),
      measured_(rows_.of(picked(record.output, comparison).head(static_cast<Eigen::Index>(rows)))) {
  const std::size_t before = before_;
  // If a filter leaves low frequencies only, a tenth of the memory suffices.
  const auto spectrum = [&](const Eigen::Ref<const Eigen::VectorXd>& input) {
    return comparison.taps.empty() ? response_.input_spectrum(input) : response_.quick_input_spectrum(input);
  };
  if (before == 0) {
    input_ = spectrum(record.input);
  } else {
    Eigen::VectorXd input = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(before) + record.input.size());
    input.tail(record.input.size()) = record.input;
    input_ = spectrum(input);
  }
  if (options.keep_input) {
    const Eigen::VectorXd& fine = options.fine_input.size() > 0 ? options.fine_input : record.input;
    // A map is not evaluated for rows that no compared row depends on.
    const auto simulated = static_cast<Eigen::Index>(response_.samples() - before) * block_;
    const Eigen::Index rows_of_it = std::min(fine.size(), simulated);
    edges_.emplace(block_ == 1 ? response_.edge_thinning(fine, before)
                               : EdgeThinning(fine.head(rows_of_it), means_over(block_, rows_of_it / block_)));
  }
  std::size_t end = 0;
  InputSpectrum off = step_;
  for (const std::size_t edge : edges) {
    InputSpectrum on = response_.step_spectrum(before - edge);
    InputSpectrum pulse = on;
    for (std::size_t j = 0; j < pulse.size(); ++j) pulse[j] -= off[j];
    past_.push_back(std::move(pulse));
    past_windows_.push_back(
        {-record.step_s * static_cast<double>(edge), -record.step_s * static_cast<double>(end), 0.0});
    end = edge;
    off = std::move(on);
  }
}

InputSpectrum ComparedRecord::spectrum_of(const Eigen::VectorXd& thinned) const {
  if (block_ == 1) return response_.thinned_input_spectrum(thinned);
  Eigen::VectorXd input = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(before_) + thinned.size());
  input.tail(thinned.size()) = thinned;
  return response_.quick_input_spectrum(input);
}

}  // namespace eha::ident
