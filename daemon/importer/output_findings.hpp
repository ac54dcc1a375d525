// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace eha::importer {

/// First and last row of the longest part of `count` rows without these. @param rows  ascending
[[nodiscard]] std::pair<std::size_t, std::size_t> longest_part_without(const std::vector<std::size_t>& rows,
                                                                       std::size_t count);

/// Why what is taken for input and output may be exchanged: the output is so much rougher than the input, while a plant
/// smooths what moves it; or a lag of the output explains the input clearly better than a lag of the input the output,
/// while a cause comes before its effect. Empty where neither holds.
/// @param input, output  of equal length. Cost O(N), some 10 ms
[[nodiscard]] std::string why_exchanged(const std::vector<double>& input, const std::vector<double>& output);
/// The second reason alone, which noise of the sensor does not make.
[[nodiscard]] std::string why_later_than_its_output(const std::vector<double>& input,
                                                    const std::vector<double>& output);

/// Rows to keep of a record, as times [s]; none: from its start, to its end.
struct Cut {
  std::optional<double> from_s = {};
  std::optional<double> to_s = {};

  [[nodiscard]] bool keeps_all() const { return !from_s && !to_s; }
  /// Whether a time is kept.
  [[nodiscard]] bool keeps(double time_s) const {
    return time_s >= from_s.value_or(time_s) && time_s <= to_s.value_or(time_s);
  }
};

/// "--from 26 --to 60"; empty for a cut that keeps all.
[[nodiscard]] std::string cut_options(const Cut& cut);

struct OutputFindings {
  std::vector<std::string> remarks = {};  ///< a sentence each, the last of them with the cut
  Cut cut = {};                           ///< the part without any of what spoils a model that moves most
  std::string frozen = {};  ///< where the sensor froze, "from 30 to 49.98 s", of several the longest; may be empty
};

/// What a person should know of an output: that the sensor is read more slowly than the rows, that it is clipped (the
/// same greatest or least value again and again, for more than one row at a time; where it is at one end, a few rows at
/// the other end count), that the rod stands at an end while the input pushes on, that the sensor froze (the same value
/// for long while the input moves), and gaps that were filled, behind which an integrating rod is shifted.
/// @param input  of equal length
/// @param filled  rows whose input was not measured, ascending
/// @param may_be_exchanged  with the input: a command keeps its values as a sensor that is read slowly does
[[nodiscard]] OutputFindings findings_on_output(const std::vector<double>& input, const std::vector<double>& output,
                                                const std::vector<std::size_t>& filled, double start_s, double step_s,
                                                bool may_be_exchanged = false);

/// Where gaps of 5 rows or more were filled: "from 42 to 42.29 s", of several the longest; empty without one.
[[nodiscard]] std::string gaps_text(const std::vector<std::size_t>& filled, double start_s, double step_s);

/// The longest part without such a gap. @param filled  ascending
[[nodiscard]] Cut part_without_gaps(const std::vector<std::size_t>& filled, std::size_t count, double start_s,
                                    double step_s);

}  // namespace eha::importer
