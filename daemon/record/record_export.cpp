// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/record_export.hpp"

#include <fmt/format.h>
#include <matio.h>
#include <unistd.h>

#include <array>
#include <iterator>
#include <memory>
#include <vector>

#include "core/code_text.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/csv_field.hpp"
#include "daemon/record/hdf5_handle.hpp"
#include "daemon/record/record_csv.hpp"

namespace eha::record {
namespace {

constexpr std::size_t kPiece = 60000;
constexpr const char* kMatHeader = "MATLAB 5.0 MAT-file, record exported by eha";

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

/// Calls `write` with a temporary name, then renames the file.
template <typename Write>
void publish(const std::filesystem::path& path, std::size_t rows, Write&& write) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  // The libraries report a full disk as a failure without a reason; HDF5 1.10 even crashes at the end.
  os::try_space(temporary, rows * 3 * sizeof(double) + (1U << 20), path);
  try {
    write(temporary);
    os::publish_file(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

void write_csv_file(const ident::Record& record, const std::filesystem::path& path) {
  os::AtomicFile file(path);
  write_record_csv(record, [&](std::string_view text) { file.write(text); });
  file.commit();
}

void write_mat_file(const ident::Record& record, const std::filesystem::path& path) {
  publish(path, static_cast<std::size_t>(record.input.size()), [&](const std::filesystem::path& temporary) {
    const auto require = [&](bool condition) {
      if (!condition) throw IoError("cannot write " + path.string() + ": the MAT library failed; is the disk full?");
    };
    const std::unique_ptr<mat_t, int (*)(mat_t*)> file(Mat_CreateVer(temporary.c_str(), kMatHeader, MAT_FT_MAT5),
                                                       [](mat_t* open) { return Mat_Close(open); });
    require(file != nullptr);
    std::vector<ExportedColumn> all = columns(record);
    for (ExportedColumn& column : all) {
      std::array<std::size_t, 2> size{static_cast<std::size_t>(column.values.size()), 1};
      const std::unique_ptr<matvar_t, void (*)(matvar_t*)> variable(
          Mat_VarCreate(column.name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), column.values.data(), 0),
          &Mat_VarFree);
      require(variable != nullptr && Mat_VarWrite(file.get(), variable.get(), MAT_COMPRESSION_NONE) == 0);
    }
  });
}

void write_hdf5_file(const ident::Record& record, const std::filesystem::path& path) {
  const QuietHdf5 quiet;
  publish(path, static_cast<std::size_t>(record.input.size()), [&](const std::filesystem::path& temporary) {
    const auto require = [&](bool condition) {
      if (!condition) throw IoError("cannot write " + path.string() + ": the HDF5 library failed; is the disk full?");
    };
    Hdf5File file(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    require(static_cast<bool>(file));
    for (const ExportedColumn& column : columns(record)) {
      const auto rows = static_cast<hsize_t>(column.values.size());
      const Hdf5Space space(H5Screate_simple(1, &rows, nullptr));
      const Hdf5Dataset dataset(H5Dcreate2(file.get(), column.name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT));
      require(dataset &&
              H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.values.data()) >= 0);
      const std::string unit = column.unit.empty() ? std::string(1, '\0') : column.unit;
      const Hdf5Type type(H5Tcopy(H5T_C_S1));
      H5Tset_size(type.get(), unit.size());
      const Hdf5Space one(H5Screate(H5S_SCALAR));
      const Hdf5Attribute attribute(H5Acreate2(dataset.get(), "unit", type.get(), one.get(), H5P_DEFAULT, H5P_DEFAULT));
      require(attribute && H5Awrite(attribute.get(), type.get(), unit.data()) >= 0);
    }
    require(file.close());
  });
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
