// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace eha::test {

/// One record, with few enough decimals that every way of writing it keeps the numbers.
struct Measured {
  std::vector<double> time_s;
  std::vector<double> input_V;
  std::vector<double> output_in;
};

/// A lag with a deterministic disturbance, sampled every 10 ms.
[[nodiscard]] Measured measured(std::size_t rows);

/// A record as another program writes it.
struct ForeignFile {
  std::string made_by;  ///< "Excel, German settings"
  std::string name;     ///< "excel_de.csv"
};

/// Writes the record into a folder in many ways, after the documented formats of the programs. No program is called.
[[nodiscard]] std::vector<ForeignFile> write_foreign_files(const Measured& record, const std::filesystem::path& folder);

/// Writes numeric datasets to a new HDF5 file; the names may contain groups.
void write_hdf5(const std::filesystem::path& path,
                const std::vector<std::pair<std::string, std::vector<double>>>& datasets,
                const std::string& first_unit);

/// UTF-8 text in another character set, as iconv(1) names it.
[[nodiscard]] std::string in_charset(const std::string& text, const char* charset);

}  // namespace eha::test
