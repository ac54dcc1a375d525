// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/size_hint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ident/uncertainty/usable_band.hpp"

namespace eha::identify {
namespace {

constexpr double kQuickRows = 15'000.0;     // by the ladder in some ten seconds
constexpr double kGraveRows = 1'000'000.0;  // ten million took six minutes for one structure
constexpr double kEnoughRows = 5'000.0;     // that determine the parameters of any structure
constexpr double kRowsAPeriod = 20.0;       // of the highest frequency that moves the input
constexpr double kLeastGain = 1.5;          // below, a decimation is not worth the words

/// The greatest of 1, 2, 4, 5, 8, 10, 20, ... up to a number.
int round_below(double most) {
  constexpr std::array kSteps{1.0, 2.0, 4.0, 5.0, 8.0};
  double best = 1.0;
  for (double decade = 1.0; decade <= most; decade *= 10.0) {
    for (const double step : kSteps) {
      if (step * decade <= most) best = std::max(best, step * decade);
    }
  }
  return static_cast<int>(best);
}

}  // namespace

std::optional<SizeHint> size_hint(const Source& source, int decimation,
                                  const std::function<std::string(int)>& command) {
  const int parts = source.record.parts;
  const double step_s = source.record.step_s * parts;
  const double rows = static_cast<double>(source.record.input.size()) / parts;
  const double compared = std::floor(rows / std::max(1, decimation));
  if (compared <= kQuickRows) return std::nullopt;
  SizeHint hint{fmt::format("{:.0f} rows are compared, which may take minutes", compared), compared > kGraveRows};
  const auto band = ident::excited_band(source.record.input, source.record.step_s);
  const double by_band = band ? 1.0 / (kRowsAPeriod * band->highest_Hz * step_s) : 1.0;
  const int every = round_below(std::min(rows / kEnoughRows, by_band));
  if (every < kLeastGain * std::max(1, decimation)) {
    if (band)
      hint.sentence += fmt::format("; fewer would miss what the input moves, up to {:.3g} Hz", band->highest_Hz);
    return hint;
  }
  hint.sentence +=
      fmt::format("; {:.0f}, one every {:.3g} s, filtered, show as much of an input that moves up to {:.3g} Hz: {}",
                  std::floor(rows / every), every * step_s, band->highest_Hz,
                  command ? "`" + command(every) + "`" : fmt::format("--decimate {}", every));
  return hint;
}

}  // namespace eha::identify
