// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "config/valve_estimate.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/valve/leak.hpp"

// What the valve sheets beside a run say of its rig.

namespace eha::record {

/// Name of a valve sheet in the run folder of a characterisation.
inline constexpr std::string_view kSheetFile = "valve_sheet.json";

/// Returns the newest run of [characterise] on the same rig beside a run, or the run itself; none without one. A rig is
/// the same by its name and, of a simulated one, its plant.
/// @throws DataError, IoError, PermissionError  as read_manifest() and list_runs()
[[nodiscard]] std::optional<std::filesystem::path> newest_sheet_run(const std::filesystem::path& run);

/// What dead_band_V of [following] has beyond a measured half dead band [V].
inline constexpr double kSpareOfFollowing_V = config::kDeadBandSpare_V;

/// The valve by the sheet of a run.
struct MeasuredValve {
  std::filesystem::path run = {};
  config::DeadZone zone = {};
  std::optional<std::pair<double, double>> gains = {};  ///< extending and retracting [in/(V s)]

  /// Whether null and half dead band found elsewhere are of this valve.
  [[nodiscard]] bool is_one_with(double null_V, double dead_band_V) const noexcept {
    return config::is_of_one_valve(zone, {null_V, dead_band_V});
  }
};

/// None where the sheet of the run folder lacks null or dead band.
[[nodiscard]] std::optional<MeasuredValve> valve_in(const std::filesystem::path& sheet_run);

/// The leak that the valve sheet in a run folder shows; none without a leak, and without a sheet that can be read.
[[nodiscard]] std::optional<ident::Leak> leak_in(const std::filesystem::path& sheet_run);

/// What the newest sheet beside a run says.
struct SheetBeside {
  std::optional<MeasuredValve> valve = {};
  std::optional<ident::Leak> leak = {};
  ident::SheetSays says = ident::SheetSays::nothing;  ///< whether it saw the rod rest within the valve's dead band
};

/// Nothing without a sheet, and for a folder that the caller may not read. Cost: the run.json of every run beside it.
[[nodiscard]] SheetBeside sheet_beside(const std::filesystem::path& run);

/// The leak of sheet_beside() alone.
[[nodiscard]] std::optional<ident::Leak> leak_beside(const std::filesystem::path& run);

/// What sheet_beside() says alone.
[[nodiscard]] ident::SheetSays sheet_says_beside(const std::filesystem::path& run);

}  // namespace eha::record
