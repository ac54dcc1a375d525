// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <hdf5.h>
#include <matio.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/os/files.hpp"
#include "tests/unit/temporary_folder.hpp"

// Small sound MAT-files and HDF5 files, to be read and to be damaged.

namespace eha::importer::foreign {

constexpr std::size_t kRows = 50;

inline std::vector<double> numbers(double first, double step) {
  std::vector<double> values;
  for (std::size_t k = 0; k < kRows; ++k) values.push_back(first + step * static_cast<double>(k));
  return values;
}

inline void require(bool holds) {
  if (!holds) throw std::runtime_error("a fixture cannot be written");
}

/// The struct `rec` with the fields t, u, y, or the same three as variables.
inline void write_mat(const std::filesystem::path& path, mat_ft version, bool is_struct,
                      matio_compression compression) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  require(file != nullptr);
  std::array<std::size_t, 2> one{1, 1};
  std::array<const char*, 3> fields{"t", "u", "y"};
  matvar_t* whole = is_struct ? Mat_VarCreateStruct("rec", 2, one.data(), fields.data(), 3) : nullptr;
  double first = 0.0;
  for (const char* name : fields) {
    std::array<std::size_t, 2> size{kRows, 1};
    const std::vector<double> values = numbers(first, 0.01);
    first += 1.0;
    matvar_t* column =
        Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), const_cast<double*>(values.data()), 0);
    if (whole != nullptr) {
      Mat_VarSetStructFieldByName(whole, name, 0, column);
    } else {
      require(Mat_VarWrite(file, column, compression) == 0);
      Mat_VarFree(column);
    }
  }
  if (whole != nullptr) {
    require(Mat_VarWrite(file, whole, compression) == 0);
    Mat_VarFree(whole);
  }
  Mat_Close(file);
}

/// Datasets /a/b/t, /a/b/u (with gzip) and /a/b/y.
inline void write_hdf5(const std::filesystem::path& path) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t groups = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(groups, 1);
  const hid_t packed = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t size = kRows;
  H5Pset_chunk(packed, 1, &size);
  H5Pset_deflate(packed, 6);
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  double first = 0.0;
  for (const char* name : {"/a/b/t", "/a/b/u", "/a/b/y"}) {
    const std::vector<double> values = numbers(first, 0.01);
    const hid_t data = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, groups,
                                  first > 0.5 && first < 1.5 ? packed : H5P_DEFAULT, H5P_DEFAULT);
    require(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    H5Dclose(data);
    first += 1.0;
  }
  H5Sclose(space);
  H5Pclose(packed);
  H5Pclose(groups);
  require(H5Fclose(file) >= 0);
}

struct Fixture {
  std::string kind;  ///< of kForeignReaders
  std::string name;
  std::string content;
};

inline std::vector<Fixture> fixtures() {
  const test::TemporaryFolder folder;
  write_mat(folder.path() / "plain.mat", MAT_FT_MAT5, false, MAT_COMPRESSION_NONE);
  write_mat(folder.path() / "struct.mat", MAT_FT_MAT5, true, MAT_COMPRESSION_NONE);
  write_mat(folder.path() / "packed.mat", MAT_FT_MAT5, true, MAT_COMPRESSION_ZLIB);
  write_mat(folder.path() / "old.mat", MAT_FT_MAT4, false, MAT_COMPRESSION_NONE);
  write_mat(folder.path() / "new.mat", MAT_FT_MAT73, true, MAT_COMPRESSION_NONE);
  write_hdf5(folder.path() / "datasets.h5");
  std::vector<Fixture> all;
  for (const char* name : {"plain.mat", "struct.mat", "packed.mat", "old.mat", "new.mat", "datasets.h5"}) {
    const bool is_mat = std::string(name).ends_with(".mat");
    all.push_back({is_mat ? "mat" : "hdf5", name, os::read_file(folder.path() / name)});
  }
  return all;
}

}  // namespace eha::importer::foreign
