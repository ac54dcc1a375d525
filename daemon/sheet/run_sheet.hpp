// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/suggest/commands.hpp"
#include "ident/valve/valve_sheet.hpp"

namespace eha::sheet {

using record::kSheetFile;

/// A rig file that was written with the numbers of a sheet.
struct WrittenRig {
  std::string file;
  std::string command;  ///< that checks it, and puts it in force where a service uses another one
};

/// A valve sheet and the run that it is from.
struct RunSheet {
  std::filesystem::path folder;
  record::OpenRun opened;  ///< the same, held
  config::RigConfig rig;   ///< as used
  std::string utc_start;
  std::string rig_file = {};    ///< its path, as used
  std::string rig_sha256 = {};  ///< of the content that was read
  ident::ValveSheet sheet;
  suggest::RigAccess access = {};          ///< how the run reached its rig
  std::optional<WrittenRig> written = {};  ///< none: `eha characterise` had no -o
  std::optional<double> cut_at_s = {};     ///< time to which it was measured, where late ticks ended the run
};

/// Which runs a sheet is wanted of.
enum class SheetRuns {
  completed,
  cut_as_well,  ///< those, too, that late ticks ended after the triangles: what the rows until then tell. For people to
                ///< look at: without the response after them the delay is not measured, and nothing goes by it
};

/// Too many rows of a run were not measured: playing it again alone does not mend that.
class RowsMissing : public DataError {
 public:
  using DataError::DataError;
};

/// Computes the sheet of a run of [characterise], by default of a completed one.
/// @throws DataError  another run, one that did not complete, or one whose motion does not tell the valve; as
///                    RowsMissing, more than 1 % of its rows were not measured
/// @throws IoError, PermissionError  as record::read_run
[[nodiscard]] RunSheet sheet_of_run(const record::OpenRun& run, SheetRuns runs = SheetRuns::completed);
[[nodiscard]] RunSheet sheet_of_run(const std::filesystem::path& folder);

/// One quantity of the sheet; without a name it belongs to the row above.
struct SheetRow {
  std::string name;
  std::string value;
  std::string in_rig_file = {};  ///< what [following] of the rig file, as used, says of it; empty: nothing
  bool is_as_there = true;       ///< the two lie within their joint interval
};

/// The quantities of the sheet with their intervals or "not observed", in the unit of length for people.
[[nodiscard]] std::vector<SheetRow> sheet_rows(const RunSheet& run, const DisplayUnit& unit);

/// What a sheet is of.
struct Origin {
  std::string run;       ///< "20261122T101500Z-characterise, 2026-11-22 10:15:00 UTC"
  std::string rig_file;  ///< its path
  std::string sha256;    ///< the first digits, of the rig file as used
};
[[nodiscard]] Origin origin_of(const RunSheet& run);

/// For people: at most 80 columns, lengths in the unit.
[[nodiscard]] std::string sheet_text(const RunSheet& run, const DisplayUnit& unit);

/// What stands against using the sheet as it is, with what to do, as a sentence; empty: nothing.
[[nodiscard]] std::string warning_of(const RunSheet& run, const DisplayUnit& unit);

/// What to do with the sheet, as a sentence with its command in backticks: of a rig that leaks the repair, else what
/// brings the numbers into force. @param rig  of the commands
[[nodiscard]] std::string next_of(const RunSheet& run, const suggest::RigAccess& rig);

/// Whether [following] of the rig file, as used, is of a sheet and lies within the intervals of this one.
[[nodiscard]] bool is_in_rig_file(const RunSheet& run);

/// Whether the rig file of the run, as it is now, has the numbers of this sheet: they were written after the run.
/// Not known of a run that the service played.
[[nodiscard]] bool is_written_since(const RunSheet& run);

/// The factor of both gains over those of a measured [following] of the rig file, as used, where they changed alike:
/// the supply is to be looked at before these numbers are used.
[[nodiscard]] std::optional<double> supply_factor(const RunSheet& run);

/// What the rig file says of this valve from now on: [following] with its uncertainties. Limit and pressure delay are
/// those of the rig file, where it has them.
[[nodiscard]] config::Following following_of(const RunSheet& run);
[[nodiscard]] std::string rig_lines(const RunSheet& run);

/// What an experiment on this rig begins with: [start] in mid-travel, and where its `offset_V` comes from.
[[nodiscard]] std::string experiment_lines(const RunSheet& run);

/// The content of valve_sheet.json, schema eha-valve-sheet/1; lengths in inches.
[[nodiscard]] nlohmann::ordered_json to_json(const RunSheet& run);

/// The sheet as one HTML page. @param missing  receives the plots that could not be drawn
[[nodiscard]] std::string sheet_page(const RunSheet& run, const DisplayUnit& unit, std::vector<std::string>& missing);

/// Writes valve_sheet.json and report.html into the run folder and lists them in run.json.
/// @returns the plots that could not be drawn, one sentence each   @throws IoError, PermissionError
std::vector<std::string> write_sheet(const RunSheet& run, const DisplayUnit& unit);

}  // namespace eha::sheet
