// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/identify/fit_table.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/report/page.hpp"
#include "daemon/track/track_result.hpp"
#include "daemon/tune/axis_trial.hpp"

namespace eha::cli {

/// Whether track.json, track.csv, axis_table.csv and report.html can be written into the run folder, or exist there.
enum class TrackFiles { write, keep };

/// Prints the results of a completed run of [track] with the controller's promise.
/// @throws DataError, IoError, PermissionError  as track::track_result
ExitCode show_track(const record::OpenRun& run, TrackFiles files, const Console& console);

/// The trial's reference, rod and command; rod and reference as means over track::kMean_s, without the ends where those
/// have fewer rows.
[[nodiscard]] tune::TrialTrace trace_of(const track::TrackResult& result);

/// The trial as read, as the report of one that ended early shows it.
[[nodiscard]] identify::FitTable table_of(const track::TrackResult& result);

/// Writes the controller's page with the results of the run.
/// @param title  of the page   @param lead_html  first part of the page
[[nodiscard]] report::Page track_page(const track::TrackResult& result, const DisplayUnit& unit,
                                      const std::string& title = {}, const std::string& lead_html = {});

/// Whether the record of a run that a fault ended shows more of the cause than the list of what is likely: a trial
/// (track::EndedTrial::is_cause_known()), or a run at a limit (identify::trip_cause()).
[[nodiscard]] bool shows_its_cause(const std::filesystem::path& folder);

/// Reports a trial that ended early: by a fault, so that the promise is not kept, or because it was stopped. Prints the
/// valve that the rod's motion shows until a fault, writes it to track.json, and leads on with one command.
/// @param remedy  of a [following] that is not of the newest valve sheet; none: it is
void explain_ended_trial(const std::filesystem::path& folder, const std::string& rig_units, TrackFiles files,
                         const Console& console, const std::optional<std::string>& remedy = {});

}  // namespace eha::cli
