// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/record_export.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/code_text.hpp"
#include "core/os/files.hpp"
#include "daemon/record/csv_field.hpp"
#include "daemon/record/file_writer.hpp"
#include "daemon/record/record_csv.hpp"

namespace eha::record {
namespace {

constexpr std::size_t kPiece = 60000;

double time_s(const ident::Record& record, Eigen::Index k) {
  return record.start_s + record.step_s * static_cast<double>(k);
}

struct ExportedColumn {
  std::string name;  ///< as a variable of every language
  std::string unit;
  Eigen::VectorXd values;
};

std::vector<ExportedColumn> columns(const ident::Record& record) {
  Eigen::VectorXd time(record.input.size());
  for (Eigen::Index k = 0; k < time.size(); ++k) time[k] = time_s(record, k);
  const auto name = [](const ident::Channel& channel) { return identifier(header_from_channel(channel)); };
  return {{"time_s", "s", std::move(time)},
          {name(record.input_channel), record.input_channel.unit, record.input},
          {name(record.output_channel), record.output_channel.unit, record.output},
          {"sample_period_s", "s", Eigen::VectorXd::Constant(1, record.step_s)}};
}

/// @param kind  of eha-hdf5
void write_columns(std::string_view kind, const ident::Record& record, const std::filesystem::path& path) {
  const std::vector<ExportedColumn> all = columns(record);
  constexpr std::uint64_t kOverhead = 1U << 20U;
  FileWriter writer(kind, path, static_cast<std::uint64_t>(record.input.size()) * 3 * sizeof(double) + kOverhead);
  writer.send_number(all.size());
  for (const ExportedColumn& column : all) {
    const auto size = static_cast<std::uint64_t>(column.values.size());
    writer.send_text(column.name);
    writer.send_text(column.unit);
    writer.send_number(size);
    writer.send(column.values.data(), size * sizeof(double));
  }
  writer.commit();
}

void write_csv_file(const ident::Record& record, const std::filesystem::path& path) {
  os::AtomicFile file(path);
  write_record_csv(record, [&](std::string_view text) { file.write(text); });
  file.commit();
}

void write_mat_file(const ident::Record& record, const std::filesystem::path& path) {
  write_columns(kMatColumns, record, path);
}

void write_hdf5_file(const ident::Record& record, const std::filesystem::path& path) {
  write_columns(kHdf5Columns, record, path);
}

constexpr std::array kFormats{RecordFormat{"csv", ".csv", "record as CSV, every row", &write_csv_file},
                              RecordFormat{"mat", ".mat", "record as a MAT file of version 5", &write_mat_file},
                              RecordFormat{"hdf5", ".h5", "record as HDF5 datasets", &write_hdf5_file}};

}  // namespace

std::span<const RecordFormat> record_formats() { return kFormats; }

void write_record_csv(const ident::Record& record, const std::function<void(std::string_view)>& write) {
  std::string text = fmt::format("time_s,{},{}\n", csv_name(header_from_channel(record.input_channel)),
                                 csv_name(header_from_channel(record.output_channel)));
  // Enough digits for evenly spaced times, without the rounding of k * step.
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{:.12g},{},{}\n", time_s(record, k), record.input[k], record.output[k]);
    if (text.size() > kPiece) {
      write(text);
      text.clear();
    }
  }
  write(text);
}

}  // namespace eha::record
