// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "daemon/acquisition/tick_record.hpp"

namespace eha::record {

/// Passes on every record of a run, in order, in pieces of any size.
using RecordSource = std::function<void(const std::function<void(std::span<const acquisition::TickRecord>)>&)>;

/// Writes the raw record as HDF5: one 1-D dataset a member of TickRecord, each with its `unit` and `description`, a
/// `time_s` counted from the first experiment row, and the journal's header as the text `header`. Opens in MATLAB
/// (h5read), Octave (load) and h5py. Written under a temporary name by eha-hdf5, synchronised, then renamed; equal
/// content gives equal bytes. Constant memory.
/// @param rows       how many records `source` hands over
/// @param zero_ns    scheduled time of the first experiment row [ns]; 0 when there is none
/// @throws IoError, PermissionError
void write_raw_file(const std::filesystem::path& path, const nlohmann::ordered_json& header, std::uint64_t rows,
                    std::int64_t zero_ns, const RecordSource& source);

}  // namespace eha::record
