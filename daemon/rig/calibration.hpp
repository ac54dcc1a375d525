// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "core/display_unit.hpp"
#include "hal/conversion.hpp"

namespace eha {

/// A position by the ruler and the sensor's voltage at it.
struct CalibrationPoint {
  double position_in = 0.0;
  double voltage_V = 0.0;
};

inline constexpr std::size_t kFewestCalibrationPoints = 3;

/// position = offset + scale voltage.
struct Calibration {
  double scale_in_per_V = 0.0;
  double offset_in = 0.0;
  double scale_std = 0.0;  ///< standard errors [in/V], [in]
  double offset_std = 0.0;
  double interval_factor = 0.0;  ///< half the 95 % interval of scale and offset over their standard errors
  double residual_std = 0.0;     ///< of the positions about the line [in]
  std::vector<double> residuals_in = {};
  double voltage_squares_V2 = 0.0;  ///< of the voltages about their mean
  double mean_V = 0.0;
};

/// Fits a line through the points by least squares.
/// @param unit  of the lengths in messages
/// @throws DataError  fewer than kFewestCalibrationPoints, one that is not finite, voltages or positions that hardly
///                    differ, or points that lie on no line (a scale known worse than 10 %); says what to do
[[nodiscard]] Calibration calibrated(std::span<const CalibrationPoint> points,
                                     const DisplayUnit& unit = DisplayUnit("in"));

/// The one point without which all others lie on a line, within a tolerance of it.
struct LonePoint {
  std::size_t index = 0;
  double off_in = 0.0;     ///< of the line through the others
  double others_in = 0.0;  ///< the greatest residual of the others
};

/// Returns it where each other choice leaves a residual beyond the tolerance; none for fewer than five points, of which
/// three lie on a line by chance.
[[nodiscard]] std::optional<LonePoint> lone_point(std::span<const CalibrationPoint> points, double tolerance_in);

/// Standard deviation of the sensor's rounding: positions that lie nearer to a line than it do so by chance, and their
/// ruler's error is not in the standard errors. @param range_V  of the converter, of 16 bits
[[nodiscard]] double rounding_in(const Calibration& found, double range_V);

/// Says that the scale is known badly, and which reading to take again; empty for one whose 95 % interval is within 5 %
/// of it.
/// @param unit  of the lengths in the sentence
[[nodiscard]] std::string doubt_about(std::span<const CalibrationPoint> points, const Calibration& found,
                                      const DisplayUnit& unit = DisplayUnit("in"));

/// How far a calibration moves a place of the travel against the one before, where it moves it farthest.
struct PlaceShift {
  double at_in = 0.0;  ///< by the calibration before [in]
  double by_in = 0.0;  ///< towards greater displacements where positive [in]
};
[[nodiscard]] PlaceShift greatest_shift(const config::RigLimits& limits, const hal::Conversion& before,
                                        const hal::Conversion& after);
/// The same against the calibration of a rig file.
[[nodiscard]] PlaceShift greatest_shift(const config::RigConfig& rig, const Calibration& calibration);

/// Says that a calibration puts the rod of a voltage more than 0.1 in away from where the rig file's has it, somewhere
/// within its travel limits; empty for others. Every reading of the ruler may be off by the same length, which no line
/// through them shows, and travel limits and end stops then no longer meet.
[[nodiscard]] std::string shift_text(const config::RigConfig& rig, const Calibration& calibration,
                                     const DisplayUnit& unit);

/// Replaces scale and offset in a rig file's text, and the calibration date if the backend has one. Keeps all other
/// text, comments and order included, but that the gains of a [following] that was measured with the old scale, and its
/// sums, become those of the new one. Adds a missing key below the head of its table. With units = "mm" keys in inches
/// become those in millimetres, and so does "[in/V]" in the comment of their lines. Reads the text back as a rig file.
/// @param date  YYYY-MM-DD
/// @throws ConfigError  the new file would be wrong, for example with limits outside the sensor's new range
[[nodiscard]] std::string calibrated_rig_text(const config::RigConfig& rig, const Calibration& calibration,
                                              const std::string& date);

/// Replaces the numbers of [following] in a rig file's text, or adds that table at its end, in the units of
/// calibrated_rig_text. Keeps all other text. Reads the text back as a rig file.
/// @throws ConfigError  the new file would be wrong
[[nodiscard]] std::string rig_text_with(const config::RigConfig& rig, const config::Following& following);

/// Comments [following] out, the line of its head and all of its keys. Keeps all other text. Reads the text back as a
/// rig file. @throws ConfigError  the table is not written below a head of its own
[[nodiscard]] std::string rig_text_without_following(const config::RigConfig& rig);

/// Replaces the tick in a rig file's text. Keeps all other text. Reads the text back as a rig file.
/// @throws ConfigError  the new file would be wrong
[[nodiscard]] std::string rig_text_with_tick(const config::RigConfig& rig, double sample_period_s);

}  // namespace eha
