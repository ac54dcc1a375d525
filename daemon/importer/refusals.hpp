// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/importer_options.hpp"
#include "daemon/importer/roles.hpp"
#include "ident/record.hpp"

// Tables whose rows are read, but not what a record needs: each refusal names the command that reads it.

namespace eha::importer {

/// No hydraulic rig is sampled faster.
inline constexpr double kShortestStep_s = 1.0 / 20e3;

/// A clock without a unit that rises by more than a rig's rows are apart counts seconds or parts of a second; nobody
/// can say which.
/// @throws DataError
void refuse_time_without_unit(const Rows& rows, const Column& time, const std::filesystem::path& path,
                              const Options& options);

/// An output that a slower device measured: filled rows would be most of the record, and no model is accepted of those.
/// @throws DataError
void refuse_slower_output(const Table& table, const Roles& roles, const std::filesystem::path& path,
                          const Options& options);

/// Of a file that eha wrote: a length as input and volts as output are a response read backwards. @throws DataError
void refuse_exchanged(const ident::Record& record, const Roles& roles, const std::filesystem::path& path,
                      const Options& options);

}  // namespace eha::importer
