// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/column_files.hpp"

#include <matio.h>

#include <array>
#include <memory>

#include "core/error.hpp"
#include "daemon/record/hdf5_handle.hpp"

namespace eha::record {
namespace {

constexpr const char* kMatHeader = "MATLAB 5.0 MAT-file, record exported by eha";

void require_written(bool condition) {
  if (!condition) throw IoError("the library failed");
}

}  // namespace

void write_mat_columns(const std::filesystem::path& path, const ColumnSource& source) {
  const std::unique_ptr<mat_t, int (*)(mat_t*)> file(Mat_CreateVer(path.c_str(), kMatHeader, MAT_FT_MAT5),
                                                     [](mat_t* open) { return Mat_Close(open); });
  require_written(file != nullptr);
  source([&](NamedColumn& column) {
    std::array<std::size_t, 2> size{column.values.size(), 1};
    const std::unique_ptr<matvar_t, void (*)(matvar_t*)> variable(
        Mat_VarCreate(column.name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), column.values.data(), 0),
        &Mat_VarFree);
    require_written(variable != nullptr && Mat_VarWrite(file.get(), variable.get(), MAT_COMPRESSION_NONE) == 0);
  });
}

void write_hdf5_columns(const std::filesystem::path& path, const ColumnSource& source) {
  const QuietHdf5 quiet;
  Hdf5File file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  require_written(static_cast<bool>(file));
  source([&](NamedColumn& column) {
    const hsize_t rows = column.values.size();
    const Hdf5Space space(H5Screate_simple(1, &rows, nullptr));
    const Hdf5Dataset dataset(H5Dcreate2(file.get(), column.name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT,
                                         H5P_DEFAULT, H5P_DEFAULT));
    require_written(dataset && H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                        column.values.data()) >= 0);
    const std::string unit = column.unit.empty() ? std::string(1, '\0') : column.unit;
    const Hdf5Type type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.get(), unit.size());
    const Hdf5Space one(H5Screate(H5S_SCALAR));
    const Hdf5Attribute attribute(H5Acreate2(dataset.get(), "unit", type.get(), one.get(), H5P_DEFAULT, H5P_DEFAULT));
    require_written(attribute && H5Awrite(attribute.get(), type.get(), unit.data()) >= 0);
  });
  require_written(file.close());
}

}  // namespace eha::record
