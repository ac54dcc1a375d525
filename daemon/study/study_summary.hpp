// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/study/paper_study.hpp"

namespace eha::study {

/// R2 of FO less that of IO, as printed in the paper's table 2: 88.68 % and 82.35 % [points].
inline constexpr double kPrintedGain = 6.33;

/// Quartiles of several values.
struct Quartiles {
  double lower = 0.0;
  double median = 0.0;
  double upper = 0.0;
};

/// By linear interpolation between sorted values. @param values  at least one
[[nodiscard]] Quartiles quartiles(std::vector<double> values);

/// The records of one kind of plant by one treatment.
struct Cell {
  std::size_t plant = 0;
  Treatment treatment = Treatment::published;
  std::size_t records = 0;
  Quartiles io_r2_percent;
  Quartiles fo_r2_percent;
  Quartiles gain;                    ///< [points]
  std::size_t gains_as_printed = 0;  ///< records on which FO gains kPrintedGain or more
  std::size_t stable_io = 0;
  std::size_t stable_fo = 0;
  Quartiles fo_order;  ///< highest order of FO
};

/// By plant and treatment; those without records are left out.
[[nodiscard]] std::vector<Cell> cells_of(const PaperStudy& study);

/// Returns the conclusions from the figures, one sentence each, and their limits.
[[nodiscard]] std::vector<std::string> conclusions(const std::vector<Cell>& cells);

/// Writes one line a row of the study, with a header.
[[nodiscard]] std::string to_csv(const PaperStudy& study);

}  // namespace eha::study
