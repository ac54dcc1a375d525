// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <hdf5.h>
#include <matio.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/os/files.hpp"
#include "daemon/record/raw_file.hpp"
#include "tests/unit/importer/foreign_fixtures.hpp"
#include "tests/unit/temporary_folder.hpp"

// Further sound files, to be damaged: what the readers leave out, convert or refuse.

namespace eha::importer::foreign {

/// Integers, text, a cell, a sparse matrix, a complex one and a struct within a struct.
inline void write_mixed_mat(const std::filesystem::path& path, matio_compression compression) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  require(file != nullptr);
  std::array<std::size_t, 2> size{kRows, 2};
  std::array<std::size_t, 2> one{1, 1};
  const auto write = [&](matvar_t* variable) {
    require(variable != nullptr && Mat_VarWrite(file, variable, compression) == 0);
    Mat_VarFree(variable);
  };
  std::vector<std::int16_t> integers(2 * kRows, 7);
  write(Mat_VarCreate("raw", MAT_C_INT16, MAT_T_INT16, 2, size.data(), integers.data(), 0));
  std::string text = "hydraulic";
  std::array<std::size_t, 2> letters{1, text.size()};
  write(Mat_VarCreate("note", MAT_C_CHAR, MAT_T_UTF8, 2, letters.data(), text.data(), 0));
  std::vector<float> singles(2 * kRows, 0.5F);
  std::array<std::size_t, 2> lying{2, kRows};
  write(Mat_VarCreate("lying", MAT_C_SINGLE, MAT_T_SINGLE, 2, lying.data(), singles.data(), 0));
  std::vector<double> parts(2 * kRows, 1.0);
  mat_complex_split_t both{parts.data(), parts.data()};
  write(Mat_VarCreate("both", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), &both, MAT_F_COMPLEX));
  std::array<matvar_t*, 2> cells{Mat_VarCreate("", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), parts.data(), 0),
                                 Mat_VarCreate("", MAT_C_INT16, MAT_T_INT16, 2, size.data(), integers.data(), 0)};
  std::array<std::size_t, 2> pair{1, 2};
  write(Mat_VarCreate("cells", MAT_C_CELL, MAT_T_CELL, 2, pair.data(), cells.data(), 0));
  std::vector<mat_uint32_t> rows{0, 3, 4};
  std::vector<mat_uint32_t> starts{0, 2, 3};
  mat_sparse_t sparse{};
  sparse.nzmax = 3;
  sparse.ir = rows.data();
  sparse.nir = 3;
  sparse.jc = starts.data();
  sparse.njc = 3;
  sparse.ndata = 3;
  sparse.data = parts.data();
  write(Mat_VarCreate("sparse", MAT_C_SPARSE, MAT_T_DOUBLE, 2, size.data(), &sparse, MAT_F_DONT_COPY_DATA));
  std::array<const char*, 2> fields{"inner", "u"};
  std::array<const char*, 1> inner_fields{"y"};
  matvar_t* outer = Mat_VarCreateStruct("outer", 2, pair.data(), fields.data(), 2);
  for (std::size_t i = 0; i < 2; ++i) {
    matvar_t* inner = Mat_VarCreateStruct("inner", 2, one.data(), inner_fields.data(), 1);
    Mat_VarSetStructFieldByName(inner, "y", 0,
                                Mat_VarCreate("y", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), parts.data(), 0));
    Mat_VarSetStructFieldByName(outer, "inner", i, inner);
    Mat_VarSetStructFieldByName(outer, "u", i,
                                Mat_VarCreate("u", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), parts.data(), 0));
  }
  write(outer);
  Mat_Close(file);
}

/// Text attributes of both kinds, a compound, a matrix with checksums in several chunks, an array of arrays.
inline void write_mixed_hdf5(const std::filesystem::path& path, bool is_newest) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (is_newest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const std::array<hsize_t, 2> size{kRows, 3};
  const hid_t space = H5Screate_simple(2, size.data(), nullptr);
  const hid_t chunks = H5Pcreate(H5P_DATASET_CREATE);
  const std::array<hsize_t, 2> chunk{20, 2};
  H5Pset_chunk(chunks, 2, chunk.data());
  H5Pset_shuffle(chunks);
  H5Pset_deflate(chunks, 1);
  H5Pset_fletcher32(chunks);
  const std::vector<float> values(3 * kRows, 0.25F);
  const hid_t matrix = H5Dcreate2(file, "matrix", H5T_IEEE_F32BE, space, H5P_DEFAULT, chunks, H5P_DEFAULT);
  require(H5Dwrite(matrix, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
  const hid_t scalar = H5Screate(H5S_SCALAR);
  const hid_t fixed = H5Tcopy(H5T_C_S1);
  H5Tset_size(fixed, 3);
  const hid_t unit = H5Acreate2(matrix, "unit", fixed, scalar, H5P_DEFAULT, H5P_DEFAULT);
  require(H5Awrite(unit, fixed, "mm") >= 0);
  const std::array<hsize_t, 1> rows{kRows};
  const hid_t line = H5Screate_simple(1, rows.data(), nullptr);
  struct Row {
    double time_s;
    std::int32_t count;
  };
  const std::vector<Row> table(kRows, Row{0.5, 3});
  const hid_t row = H5Tcreate(H5T_COMPOUND, sizeof(Row));
  H5Tinsert(row, "time_s", HOFFSET(Row, time_s), H5T_NATIVE_DOUBLE);
  H5Tinsert(row, "count", HOFFSET(Row, count), H5T_NATIVE_INT32);
  const hid_t compound = H5Dcreate2(file, "table", row, line, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  require(H5Dwrite(compound, row, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.data()) >= 0);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  const hid_t units = H5Acreate2(compound, "units", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
  const char* second = "s";
  require(H5Awrite(units, text, &second) >= 0);
  const std::vector<double> column(kRows, 1.5);
  const hid_t plain = H5Dcreate2(file, "y", H5T_NATIVE_DOUBLE, line, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  require(H5Dwrite(plain, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.data()) >= 0);
  const hid_t long_unit = H5Acreate2(plain, "units", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
  const char* inch = "inch of a ruler";
  require(H5Awrite(long_unit, text, &inch) >= 0);
  H5Lcreate_soft("/matrix", file, "again", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("other.h5", "/y", file, "elsewhere", H5P_DEFAULT, H5P_DEFAULT);
  for (const hid_t attribute : {unit, units, long_unit}) H5Aclose(attribute);
  for (const hid_t dataset : {matrix, compound, plain}) H5Dclose(dataset);
  for (const hid_t type : {fixed, row, text}) H5Tclose(type);
  for (const hid_t any : {space, scalar, line}) H5Sclose(any);
  H5Pclose(chunks);
  H5Pclose(access);
  require(H5Fclose(file) >= 0);
}

/// Records as text, of several programs and dialects.
inline std::vector<Fixture> text_fixtures() {
  std::vector<Fixture> all;
  const auto add = [&](const char* name, std::string content) { all.push_back({"csv", name, std::move(content)}); };
  add("record.csv", "# a comment\ntime_s,voltage_V,displacement_in\n0,1,2.5\n0.001,-1,2.25\n0.002,+1e-3,2.125\n");
  add("quoted.csv", "\xEF\xBB\xBFtime_s,\"a \"\"b\"\"_V\",c\r\n10,\"1\",2\r\n20,3,4\r\n");
  add("rounded.csv", "time_s,u,y\n0.000000,1,2\n0.000977,3,4\n0.001953,5,6\n0.002930,7,8\n");
  add("gap.csv", "time_s,u,y\n1e1,1,2\n2e1,1,2\n4e1,1,2\n");
  std::string wide = "\xFF\xFE";
  for (const char c : std::string_view("time_s,u,y\n0,1,2\n1,2,3\n2,3,4\n")) wide += {c, '\0'};
  add("utf16.csv", wide);
  add("dspace.csv",
      "descriptor,,,\npath,,Model Root/u,Model Root/y\ntrace,time,u,y\nunit,s,V,mm\n"
      "trace_values,0.0,0,50\ntrace_values,0.001,0.1,51\ntrace_values,0.002,0.2,52\n");
  add("mts.dat",
      "MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\nData Header:\tCyclic\tTime:\t0.5\tSec\n\n"
      "Time\tAxial Displacement\tAxial Command\nSec\tmm\tV\n0\t50\t0\n0.001\t51\t0.1\n0.002\t52\t0.2\n");
  add("rigol.csv",
      "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-01,1.0e-03,\n0,0,4.5,,\n1,0.1,4.6,,\n2,0.2,4.7,,\n");
  add("yokogawa.csv",
      "\"TraceName\",\"CH1\",\"CH2\"\n\"VUnit\",\"V\",\"V\"\n\"HResolution\",0.001,0.001\n\n,0,4.5\n,0.1,4.6\n,0.2,4.7"
      "\n");
  add("clock.csv",
      "Zeit;Ventil [V];Weg [mm]\n23.11.2026 10:00:00,000;0,5;45,2\n23.11.2026 10:00:00,010;0,6;45,3\n"
      "23.11.2026 10:00:00,020;0,7;#WERT!\n23.11.2026 10:00:00,030;0,8;45,5\n");
  add("days.csv", "Time,u,y\n46349.41670000,1,2\n46349.41670012,2,3\n46349.41670023,3,4\n");
  add("labview.lvm",
      "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n***End_of_Header***\t\n\n"
      "Channels\t2\nX_Dimension\tTime\tTime\nDelta_X\t0,001\t0,001\n***End_of_Header***\t\t\n"
      "X_Value\tu\ty\tComment\n0,000\t1,5\t2\n0,001\t1,6\t3\n0,002\t1,7\t4\n");
  return all;
}

/// Every sound file, of the kinds "mat", "hdf5", "csv" and "raw" (of a run).
inline std::vector<Fixture> fixtures_to_damage() {
  const test::TemporaryFolder folder;
  write_mixed_mat(folder.path() / "mixed.mat", MAT_COMPRESSION_NONE);
  write_mixed_mat(folder.path() / "mixed_packed.mat", MAT_COMPRESSION_ZLIB);
  write_mixed_hdf5(folder.path() / "mixed.h5", false);
  write_mixed_hdf5(folder.path() / "mixed_new.h5", true);
  std::vector<Fixture> all = fixtures();
  for (const char* name : {"mixed.mat", "mixed_packed.mat"}) {
    all.push_back({"mat", name, os::read_file(folder.path() / name)});
  }
  for (const char* name : {"mixed.h5", "mixed_new.h5"}) {
    all.push_back({"hdf5", name, os::read_file(folder.path() / name)});
  }
  const std::vector<acquisition::TickRecord> ticks(20);
  const auto source = [&](const auto& consume) { consume(std::span(ticks)); };
  record::write_raw_file(folder.path() / "raw.h5", {{"name", "a run"}}, ticks.size(), 0, source);
  all.push_back({"raw", "raw.h5", os::read_file(folder.path() / "raw.h5")});
  for (Fixture& text : text_fixtures()) all.push_back(std::move(text));
  return all;
}

}  // namespace eha::importer::foreign
