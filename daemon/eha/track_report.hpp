// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/error.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Whether track.json and track.csv are written into the run folder, or are there already.
enum class TrackFiles { write, keep };

/// Prints what a completed run of [track] shows beside the controller's promise.
/// @throws DataError, IoError, PermissionError  as track::track_result
ExitCode show_track(const std::filesystem::path& folder, TrackFiles files, const Console& console);

}  // namespace eha::cli
