// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/most_moving_part.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace eha::ident {
namespace {

constexpr double kLeastMotion = 0.1;  // of the signal's standard deviation

double squares_about_mean(std::span<const double> part) {
  const double mean = std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(part.size());
  return std::accumulate(part.begin(), part.end(), 0.0,
                         [&](double sum, double y) { return sum + (y - mean) * (y - mean); });
}

}  // namespace

std::optional<std::pair<std::size_t, std::size_t>> most_moving_part(
    std::span<const double> signal, const std::vector<std::pair<std::size_t, std::size_t>>& without) {
  if (signal.empty()) return std::nullopt;
  const double of_all = squares_about_mean(signal) / static_cast<double>(signal.size());
  std::optional<std::pair<std::size_t, std::size_t>> best;
  double most = 0.0;
  std::size_t begin = 0;
  const auto take = [&](std::size_t end) {
    if (end <= begin + 1) return;
    const auto rows = static_cast<double>(end - begin);
    const double squares = squares_about_mean(signal.subspan(begin, end - begin));
    if (!(squares > most) || !(squares >= kLeastMotion * kLeastMotion * of_all * rows)) return;
    best = {begin, end};
    most = squares;
  };
  for (const auto& [first, last] : without) {
    take(std::min(first, signal.size()));
    begin = std::max(begin, last + 1);
  }
  take(signal.size());
  return best;
}

}  // namespace eha::ident
