// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/array_table.hpp"
#include "daemon/importer/hdf5_heaps.hpp"
#include "daemon/importer/header_facts.hpp"
#include "daemon/record/hdf5_handle.hpp"

namespace eha::importer {
namespace {

using record::Hdf5Attribute;
using record::Hdf5Dataset;
using record::Hdf5File;
using record::Hdf5Space;
using record::Hdf5Type;
using Hdf5Object = record::Hdf5Handle<H5Oclose>;

constexpr std::size_t kMostDatasets = 1000;
constexpr std::size_t kMostObjects = 20'000;
constexpr int kDeepestGroup = 32;

struct Visited {
  std::vector<std::string> datasets;
  std::vector<std::string> groups;
  std::size_t objects = 0;
  std::string refusal;
};

/// @returns positive to end the visit
herr_t note_object(hid_t /*group*/, const char* name, const H5O_info_t* info, void* visited_address) {
  auto& visited = *static_cast<Visited*>(visited_address);
  const std::string_view path(name);
  if (std::count(path.begin(), path.end(), '/') > kDeepestGroup) {
    visited.refusal = fmt::format("more than {} groups within each other", kDeepestGroup);
  }
  if (++visited.objects > kMostObjects) visited.refusal = fmt::format("more than {} groups and datasets", kMostObjects);
  if (info->type == H5O_TYPE_DATASET && visited.datasets.size() < kMostDatasets) visited.datasets.emplace_back(name);
  if (info->type == H5O_TYPE_GROUP && visited.groups.size() < kMostDatasets) visited.groups.emplace_back(name);
  return visited.refusal.empty() ? 0 : 1;
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
    constexpr std::size_t kLongestUnit = 1000;
    if (H5Tget_size(type.get()) > kLongestUnit) continue;
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
  Hdf5Collector(std::string path, hid_t file) : path_(std::move(path)), file_(file) {}

  void add(const std::string& name) {
    const Hdf5Dataset dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT));
    if (!dataset) fail(name);
    if (record::is_elsewhere(dataset.get())) {
      throw DataError(fmt::format("{}: the numbers of {} are in another file; save time, input and output in one file",
                                  path_, name));
    }
    const Hdf5Type type(H5Dget_type(dataset.get()));
    const Hdf5Space space(H5Dget_space(dataset.get()));
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1 || rank > 2) return;
    std::array<hsize_t, 2> size{0, 1};
    H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
    if (size[0] == 0 || size[1] == 0 || size[0] > kMostValues || size[1] > kMostValues) return;
    // A dataset without storage is all fill value, and one of a few bytes may ask for gigabytes.
    if (!can_hold(H5Dget_storage_size(dataset.get()), size[0] * size[1], H5Tget_size(type.get()))) {
      throw DataError(fmt::format("{}: the dataset {} is said to have {} values in {} bytes: damaged, or never written",
                                  path_, name, size[0] * size[1], H5Dget_storage_size(dataset.get())));
    }
    if (rank == 1 && H5Tget_class(type.get()) == H5T_COMPOUND) {
      add_compound(name, dataset.get(), type.get(), size[0]);
    } else if (is_numeric(type.get())) {
      add_matrix(name, dataset.get(), type.get(), size);
    }
  }

  /// Of an object's attributes those that are a sample period or rate, as arrays of one value.
  void add_periods(const std::string& name) {
    constexpr hsize_t kMostAttributes = 100;
    constexpr std::size_t kMostBytes = 16;
    const Hdf5Object object(H5Oopen(file_, name.c_str(), H5P_DEFAULT));
    H5O_info_t info{};
    if (!object || H5Oget_info2(object.get(), &info, H5O_INFO_NUM_ATTRS) < 0) return;
    for (hsize_t i = 0; i < std::min<hsize_t>(info.num_attrs, kMostAttributes); ++i) {
      const Hdf5Attribute attribute(
          H5Aopen_by_idx(object.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, H5P_DEFAULT, H5P_DEFAULT));
      if (!attribute) continue;
      const Hdf5Type type(H5Aget_type(attribute.get()));
      const Hdf5Space space(H5Aget_space(attribute.get()));
      const std::size_t bytes = H5Tget_size(type.get());
      if (!is_numeric(type.get()) || H5Sget_simple_extent_npoints(space.get()) != 1 || bytes > kMostBytes) continue;
      std::array<char, 64> label{};
      double value = 0.0;
      if (H5Aget_name(attribute.get(), label.size(), label.data()) <= 0 ||
          H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value) < 0 || !period_named(label.data(), value)) {
        continue;
      }
      arrays_.push_back({name == "." ? label.data() : fmt::format("{}/{}", name, label.data()), "", {value}});
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

Arrays read_hdf5(const std::filesystem::path& path, const std::string& name) {
  const record::QuietHdf5 quiet;
  const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file) throw DataError(fmt::format("{}: a damaged or truncated HDF5 file; save it again", name));
  check_heaps(path, name);
  Visited visited;
  if (H5Ovisit(file.get(), H5_INDEX_NAME, H5_ITER_INC, note_object, &visited) < 0) {
    throw DataError(fmt::format("{}: a damaged HDF5 file; save it again", name));
  }
  if (!visited.refusal.empty()) {
    throw DataError(fmt::format("{}: {}; save only time, input and output", name, visited.refusal));
  }
  Hdf5Collector collector(name, file.get());
  for (const std::string& dataset : visited.datasets) collector.add(dataset);
  for (const auto* objects : {&visited.groups, &visited.datasets}) {
    for (const std::string& object : *objects) collector.add_periods(object);
  }
  return {"HDF5", std::move(collector.arrays()), "expected one dataset a column: time, input, output"};
}

}  // namespace eha::importer
