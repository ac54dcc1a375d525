// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/importer/array_table.hpp"
#include "daemon/record/hdf5_handle.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::importer {
namespace {

using record::Hdf5Attribute;
using record::Hdf5Dataset;
using record::Hdf5File;
using record::Hdf5Space;
using record::Hdf5Type;

constexpr std::size_t kMostDatasets = 1000;

herr_t note_dataset(hid_t /*group*/, const char* name, const H5O_info_t* info, void* names_address) {
  auto& names = *static_cast<std::vector<std::string>*>(names_address);
  if (info->type == H5O_TYPE_DATASET && names.size() < kMostDatasets) names.emplace_back(name);
  return 0;
}

bool is_numeric(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

/// The text of an attribute `unit` or `units`; empty without one.
std::string unit_attribute(hid_t dataset) {
  for (const char* name : {"unit", "units", "Unit", "Units"}) {
    if (H5Aexists(dataset, name) <= 0) continue;
    const Hdf5Attribute attribute(H5Aopen(dataset, name, H5P_DEFAULT));
    const Hdf5Type type(H5Aget_type(attribute.get()));
    if (H5Tget_class(type.get()) != H5T_STRING) continue;
    if (H5Tis_variable_str(type.get()) > 0) {
      const Hdf5Space space(H5Aget_space(attribute.get()));
      char* text = nullptr;
      if (H5Sget_simple_extent_npoints(space.get()) != 1 || H5Aread(attribute.get(), type.get(), &text) < 0) continue;
      std::string unit = text == nullptr ? "" : text;
      H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, &text);
      return unit;
    }
    std::string unit(H5Tget_size(type.get()), '\0');
    if (H5Aget_storage_size(attribute.get()) != unit.size() || H5Aread(attribute.get(), type.get(), unit.data()) < 0) {
      continue;
    }
    return unit.substr(0, unit.find('\0'));
  }
  return {};
}

class Hdf5Collector {
 public:
  Hdf5Collector(const std::filesystem::path& path, hid_t file) : path_(path.string()), file_(file) {}

  void add(const std::string& name) {
    const Hdf5Dataset dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT));
    if (!dataset) fail(name);
    const Hdf5Type type(H5Dget_type(dataset.get()));
    const Hdf5Space space(H5Dget_space(dataset.get()));
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1 || rank > 2) return;
    std::array<hsize_t, 2> size{0, 1};
    H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
    if (size[0] == 0 || size[1] == 0 || size[0] > kMostValues || size[1] > kMostValues) return;
    if (rank == 1 && H5Tget_class(type.get()) == H5T_COMPOUND) {
      add_compound(name, dataset.get(), type.get(), size[0]);
    } else if (is_numeric(type.get())) {
      add_matrix(name, dataset.get(), type.get(), size);
    }
  }

  [[nodiscard]] std::vector<ArrayColumn>& arrays() { return arrays_; }

 private:
  [[noreturn]] void fail(const std::string& name) const {
    throw DataError(fmt::format("{}: the dataset {} cannot be read: a damaged or truncated file", path_, name));
  }

  void take(std::size_t values) {
    total_ += values;
    if (total_ <= kMostValues) return;
    throw DataError(fmt::format("{}: more than {} numbers; save only time, input and output", path_, kMostValues));
  }

  void add_compound(const std::string& name, hid_t dataset, hid_t type, hsize_t rows) {
    const int members = H5Tget_nmembers(type);
    for (int i = 0; i < members; ++i) {
      const Hdf5Type member(H5Tget_member_type(type, static_cast<unsigned>(i)));
      if (!is_numeric(member.get())) continue;
      char* text = H5Tget_member_name(type, static_cast<unsigned>(i));
      const std::string field = text == nullptr ? "" : text;
      H5free_memory(text);
      const Hdf5Type wanted(H5Tcreate(H5T_COMPOUND, sizeof(double)));
      H5Tinsert(wanted.get(), field.c_str(), 0, H5T_NATIVE_DOUBLE);
      ArrayColumn column{.name = fmt::format("{}.{}", name, field), .unit = "", .values = {}};
      column.is_single = H5Tget_size(member.get()) < sizeof(double) && H5Tget_class(member.get()) == H5T_FLOAT;
      take(rows);
      column.values.resize(rows);
      if (H5Dread(dataset, wanted.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, column.values.data()) < 0) fail(name);
      arrays_.push_back(std::move(column));
    }
  }

  void add_matrix(const std::string& name, hid_t dataset, hid_t type, const std::array<hsize_t, 2>& size) {
    const bool lies = size[0] < size[1];
    const std::size_t rows = std::max(size[0], size[1]);
    const std::size_t columns = std::min(size[0], size[1]);
    if (columns > kMostMatrixColumns) return;
    take(rows * columns);
    std::vector<double> values(rows * columns);
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) fail(name);
    const std::string unit = unit_attribute(dataset);
    const bool is_single = H5Tget_size(type) < sizeof(double) && H5Tget_class(type) == H5T_FLOAT;
    for (std::size_t c = 0; c < columns; ++c) {
      ArrayColumn column{.name = name, .unit = unit, .values = {}, .is_single = is_single};
      if (columns == 1) {
        column.values = std::move(values);
      } else {
        column.name = lies ? fmt::format("{}[{},:]", name, c) : fmt::format("{}[:,{}]", name, c);
        column.values.reserve(rows);
        for (std::size_t k = 0; k < rows; ++k) column.values.push_back(values[lies ? c * rows + k : k * columns + c]);
      }
      arrays_.push_back(std::move(column));
    }
  }

  std::string path_;
  hid_t file_;
  std::vector<ArrayColumn> arrays_;
  std::size_t total_ = 0;
};

}  // namespace

std::unique_ptr<Table> open_hdf5(const std::filesystem::path& path, const Options& options) {
  os::open_file(path, O_RDONLY).close();
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (path.filename() == record::kRawFile && record::is_run_folder(folder)) {
    throw DataError(
        fmt::format("{}: the raw record of a run; name the run instead: `eha fit {}`", path.string(), folder.string()));
  }
  const record::QuietHdf5 quiet;
  const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file) throw DataError(fmt::format("{}: a damaged or truncated HDF5 file; save it again", path.string()));
  std::vector<std::string> names;
  if (H5Ovisit(file.get(), H5_INDEX_NAME, H5_ITER_INC, note_dataset, &names) < 0) {
    throw DataError(fmt::format("{}: a damaged HDF5 file; save it again", path.string()));
  }
  Hdf5Collector collector(path, file.get());
  for (const std::string& name : names) collector.add(name);
  static_cast<void>(options);
  return table_of_arrays(path, "HDF5", std::move(collector.arrays()),
                         "expected one dataset a column: time, input, output");
}

}  // namespace eha::importer
