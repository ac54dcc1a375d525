// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/imported_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/array_table.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/foreign_reader.hpp"
#include "daemon/importer/text_table.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::importer {
namespace {

using Opener = std::unique_ptr<Table> (*)(const std::filesystem::path&, const Options&);

template <const std::string_view& kind>
std::unique_ptr<Table> open_foreign(const std::filesystem::path& path, const Options& /*options*/) {
  return table_of_arrays(path, read_foreign(kind, path));
}

constexpr std::string_view kMat = "mat";
constexpr std::string_view kHdf = "hdf5";
constexpr auto open_mat = open_foreign<kMat>;

std::unique_ptr<Table> open_hdf5(const std::filesystem::path& path, const Options& options) {
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (path.filename() == record::kRawFile && record::is_run_folder(folder)) {
    throw DataError(fmt::format("{}: the raw record of a run; name the run instead: `eha fit {}`", path.string(),
                                shell_word(folder.string())));
  }
  return open_foreign<kHdf>(path, options);
}

constexpr const char* kSaveAsCsv = "open it and save as CSV, then import the CSV file";

std::unique_ptr<Table> open_workbook(const std::filesystem::path& path, const Options& options) {
  os::FileDescriptor text = read_workbook(path);
  if (text) return open_text(path, options, std::move(text), "workbook, first sheet");
  throw DataError(
      fmt::format("{}: this is a workbook (.xlsx, .ods) or another archive; for .xlsx `sudo apt install xlsx2csv`, "
                  "then once more; or {}",
                  path.string(), kSaveAsCsv));
}

/// A kind of file that its first bytes tell.
struct Format {
  std::string_view magic;
  Opener open;               ///< none: it cannot be read
  std::string_view way_out;  ///< then: what it is, and what to do
};

constexpr std::string_view kMat5 = "MATLAB 5.0 MAT-file";
constexpr std::string_view kMat73 = "MATLAB 7.3 MAT-file";
constexpr std::string_view kHdf5 = "\x89HDF\r\n\x1a\n";
constexpr std::string_view kOldOffice{"\xD0\xCF\x11\xE0", 4};
constexpr std::string_view kZip{"PK\x03\x04", 4};
constexpr std::string_view kGzip{"\x1F\x8B", 2};

constexpr std::string_view kOctave = "in Octave's own format; in Octave, `save -v7 FILE.mat` writes a MAT-file";
constexpr std::array kFormats = std::to_array<Format>({
    {kMat5, open_mat, ""},
    {kMat73, open_mat, ""},
    {kHdf5, open_hdf5, ""},
    {kZip, open_workbook, ""},
    {kOldOffice, nullptr, "an old Excel workbook (.xls); open it and save as CSV, then import the CSV file"},
    {kGzip, nullptr, "compressed; unpack it first: `gunzip FILE`"},
    {"%PDF", nullptr, "a PDF document; export the record as CSV where it was made"},
    {"TDSm", nullptr, "a LabVIEW TDMS file; export it as CSV where it was made"},
    {"MDF     ", nullptr, "an MDF measurement; export it as CSV or MAT-file where it was made"},
    {"PAR1", nullptr, "a Parquet file; write it as CSV where it was made"},
    {"\x93NUMPY", nullptr, "a numpy array; in Python: numpy.savetxt(\"record.csv\", a, delimiter=\",\")"},
    {"# Created by Octave", nullptr, kOctave},
    {"Octave-1-", nullptr, kOctave},
    {"SQLite format 3", nullptr, "an SQLite database; export the table as CSV"},
    {"{", nullptr, "JSON, perhaps a model file; expected a record: CSV, MAT-file or HDF5"},
});

std::string beginning_of(const std::filesystem::path& path) {
  std::string bytes(128, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
}

/// A MAT-file of version 4 begins with a number, not with a name.
bool is_mat4(const std::filesystem::path& path, std::string_view beginning) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending == ".mat" && beginning.find('\0') != std::string_view::npos;
}

}  // namespace

std::size_t Rows::line_of(std::size_t row) const {
  const auto after = std::upper_bound(line_marks.begin(), line_marks.end(), row,
                                      [](std::size_t r, const auto& mark) { return r < mark.first; });
  if (after == line_marks.begin()) return header_line;
  const auto& mark = *(after - 1);
  return mark.second + (row - mark.first);
}

std::string Rows::where(std::size_t row) const {
  return has_lines ? fmt::format(":{}", line_of(row)) : fmt::format(", row {}", row + 1);
}

std::string Rows::header_place() const { return has_lines ? fmt::format(":{}", header_line) : ""; }

std::unique_ptr<Table> open_table(const std::filesystem::path& path, const Options& options) {
  std::error_code ignored;
  // What comes through a pipe can be read only once, and is text.
  if (!std::filesystem::is_regular_file(path, ignored)) return open_text(path, options);
  const std::string beginning = beginning_of(path);
  for (const Format& format : kFormats) {
    if (!std::string_view(beginning).starts_with(format.magic)) continue;
    if (format.open != nullptr) return format.open(path, options);
    throw DataError(fmt::format("{}: this is {}", path.string(), format.way_out));
  }
  if (is_mat4(path, beginning)) return open_mat(path, options);
  return open_text(path, options);
}

std::string period_options(const RowPeriod& period, double unit_s) {
  const double step_s = period.roundest_s * unit_s;
  std::string extra = fmt::format("--period {:.9g}", step_s);
  const auto time_of = [&](std::size_t row) { return step_s * static_cast<double>(row); };
  if (period.first_row > 0) extra += fmt::format(" --from {:.9g}", time_of(period.first_row));
  if (period.is_part) extra += fmt::format(" --to {:.9g}", time_of(period.end_row - 1));
  return extra;
}

std::string period_offer(const RowPeriod& period, const std::filesystem::path& path, const Options& options) {
  const std::string until =
      period.restart ? fmt::format(", until the clock goes back at row {}", *period.restart + 1) : "";
  std::string pause;
  if (period.longest_pause) {
    pause = fmt::format("; {} {:.6g} s before row {}{}; the longest part without a pause",
                        period.longest_pause->is_within ? "rows are missing within the" : "no row for",
                        period.longest_pause->length_s, period.longest_pause->row + 1,
                        period.pauses == 1 ? "" : fmt::format(", and {} more pauses", period.pauses - 1));
  }
  return fmt::format("its {} rows over {:.9g} s are one every {:.9g} s ({:.6g} to {:.6g} s){}{}: `{}`", period.rows,
                     period.span_s, period.roundest_s, period.lowest_s, period.highest_s, until, pause,
                     command_with(options, path, period_options(period)));
}

}  // namespace eha::importer
