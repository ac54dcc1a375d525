// SPDX-License-Identifier: GPL-3.0-or-later
// MAT-files and HDF5 that are damaged, or made to harm their reader.
#include "daemon/importer/foreign_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/confined_reader.hpp"
#include "tests/unit/importer/damaged_fixtures.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

using foreign::Fixture;
using foreign::kRows;
using foreign::numbers;
using foreign::write_hdf5;
using foreign::write_mixed_hdf5;

/// What reading says: "" when there are arrays.
std::string refusal_of(std::string_view kind, const std::filesystem::path& path) {
  try {
    static_cast<void>(read_foreign(kind, path));
    return "";
  } catch (const DataError& error) {
    return error.what();
  }
}

/// The content of the fixture with that name.
std::string content_of(const std::string& name) {
  for (const Fixture& fixture : foreign::fixtures()) {
    if (fixture.name == name) return fixture.content;
  }
  throw std::runtime_error(name);
}

template <typename Number>
std::string bytes_of(std::initializer_list<Number> values) {
  std::string bytes(values.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

/// Replaces the first of two equally long texts.
std::string with(std::string content, const std::string& what, const std::string& by) {
  const std::size_t at = content.find(what);
  if (at == std::string::npos) throw std::runtime_error("the fixture has no such bytes");
  return content.replace(at, what.size(), by);
}

TEST(ForeignReader, HandsOverASingleNumberNamedTsForThePeriod) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "ts.mat";
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  foreign::require(file != nullptr);
  const std::vector<std::pair<const char*, std::vector<double>>> variables{
      {"u", numbers(0.0, 0.01)}, {"y", numbers(2.0, 0.02)}, {"Ts", {0.002}}, {"gain", {3.0}}};
  for (const auto& [name, values] : variables) {
    std::array<std::size_t, 2> size{values.size(), 1};
    matvar_t* column =
        Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), const_cast<double*>(values.data()), 0);
    foreign::require(Mat_VarWrite(file, column, MAT_COMPRESSION_NONE) == 0);
    Mat_VarFree(column);
  }
  Mat_Close(file);
  const Imported imported = import_record(path, {});
  EXPECT_EQ(imported.record.input.size(), kRows);
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.002);
  EXPECT_NE(imported.guess.find("a row every 0.002 s (the file's Ts)"), std::string::npos) << imported.guess;
  EXPECT_DOUBLE_EQ(import_record(path, {.period_s = 0.01}).record.step_s, 0.01);
}

/// Datasets u and y of HDF5, with an attribute each as `label` says; `rate` is an attribute of the file.
void write_labelled_hdf5(const std::filesystem::path& path, const std::string& label, double rate, hsize_t userblock) {
  const hid_t how = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_userblock(how, userblock);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, how, H5P_DEFAULT);
  const hsize_t size = kRows;
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  const hid_t one = H5Screate(H5S_SCALAR);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, label.size());
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  const auto first_of = [](const std::string& name) { return name == "u_V" ? 0.0 : 2.0; };
  for (const std::string name : {"u_V", "y_mm"}) {
    const std::vector<double> values = numbers(first_of(name), 0.01);
    const hid_t data = H5Dcreate2(file, name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    foreign::require(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    const hid_t kind = H5Acreate2(data, "MATLAB_class", text, one, H5P_DEFAULT, H5P_DEFAULT);
    foreign::require(H5Awrite(kind, text, label.data()) >= 0);
    H5Aclose(kind);
    H5Dclose(data);
  }
  const hid_t attribute = H5Acreate2(file, "sample_rate", H5T_NATIVE_DOUBLE, one, H5P_DEFAULT, H5P_DEFAULT);
  foreign::require(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &rate) >= 0);
  H5Aclose(attribute);
  H5Tclose(text);
  H5Sclose(one);
  H5Sclose(space);
  H5Pclose(how);
  foreign::require(H5Fclose(file) >= 0);
}

TEST(ForeignReader, TakesAnAttributeNamedSampleRateForThePeriod) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "rate.h5";
  write_labelled_hdf5(path, "double", 200.0, 0);
  const Imported imported = import_record(path, {});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.005);
  EXPECT_NE(imported.guess.find("(the file's sample_rate)"), std::string::npos) << imported.guess;
}

TEST(ForeignReader, TakesArraysWhoseClassMatioDoesNotKnow) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "new.mat";
  // Without the NUL at its end that MATLAB and matio write.
  write_labelled_hdf5(path, "double", 100.0, 512);
  std::string content = os::read_file(path);
  std::string header =
      "MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sat Mar 14 10:22:33 2026 HDF5 schema 1.00 .";
  header.resize(124, ' ');
  header += std::string("\x00\x02IM", 4);
  content.replace(0, header.size(), header);
  const Imported imported = import_record(folder.write("padded.mat", content), {});
  EXPECT_EQ(imported.record.input.size(), kRows);
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  EXPECT_EQ(imported.guess.find("HDF5"), std::string::npos) << imported.guess;
}

TEST(ForeignReader, MakesNamesReadableBeforeATerminalShowsThem) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "names.h5";
  const hid_t h5 = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size = kRows;
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  const std::vector<double> values = numbers(0.0, 0.01);
  const hid_t data = H5Dcreate2(h5, "t\x1b[2J", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  H5Dclose(data);
  H5Fflush(h5, H5F_SCOPE_GLOBAL);
  const std::string one = os::read_file(file);
  // A second one without numbers is refused by its name.
  const hsize_t many = 10'000'000;
  const hid_t empty = H5Screate_simple(1, &many, nullptr);
  H5Dclose(H5Dcreate2(h5, "u\x1b]0;x\a", H5T_NATIVE_DOUBLE, empty, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(empty);
  H5Sclose(space);
  H5Fclose(h5);
  const Arrays arrays = read_foreign("hdf5", folder.write("one.h5", one));
  ASSERT_EQ(arrays.columns.size(), 1U);
  EXPECT_EQ(arrays.columns[0].name, "t?[2J");
  EXPECT_NE(refusal_of("hdf5", file).find("the dataset u?]0;x? is said"), std::string::npos)
      << refusal_of("hdf5", file);
}

TEST(ForeignReader, TakesAnArrayWithoutAName) {
  const test::TemporaryFolder folder;
  // MAT-file 4: type, rows, columns, imaginary, length of the name with its end.
  std::string mat = bytes_of<std::int32_t>({0, 2, 1, 0, 1}) + '\0' + bytes_of({1.0, 2.0});
  const auto table = table_of_arrays("unnamed.mat", read_foreign("mat", folder.write("unnamed.mat", mat)));
  ASSERT_EQ(table->columns().size(), 1U);
  EXPECT_EQ(table->columns()[0].name, "");
}

TEST(ForeignReader, ReadsAPartOfMoreThanThirtyMillionRows) {
  Arrays arrays{.guess = "MAT-file 5", .columns = {{.name = "u", .unit = "", .values = {}}}, .remark = ""};
  arrays.columns[0].values.resize(kMostRows + 1);
  const auto table = table_of_arrays("long.mat", std::move(arrays));
  Selection selection;
  selection.columns = {0};
  try {
    static_cast<void>(table->read(selection, {}));
    FAIL() << "all rows were read";
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()),
              "long.mat: u has 30000001 rows, more than 30000000; read a part of them with --from and --to");
  }
  selection.to = 9.0;
  EXPECT_EQ(table->read(selection, {}).columns[0].size(), 10U);
}

TEST(ForeignReader, GivesTheNumbersOfEveryKind) {
  const test::TemporaryFolder folder;
  for (const Fixture& fixture : foreign::fixtures()) {
    const Arrays arrays = read_foreign(fixture.kind, folder.write(fixture.name, fixture.content));
    ASSERT_EQ(arrays.columns.size(), 3U) << fixture.name;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(arrays.columns[i].values, numbers(static_cast<double>(i), 0.01)) << fixture.name;
      EXPECT_FALSE(arrays.columns[i].is_single);
    }
    EXPECT_TRUE(arrays.columns[1].name.ends_with("u")) << arrays.columns[1].name;
  }
}

TEST(ForeignReader, RefusesAStructThatHasFewerElementsThanItSays) {
  const test::TemporaryFolder folder;
  const std::string content = content_of("struct.mat");
  for (const std::int32_t size : {2, 1000, 0x7fffffff, -1}) {
    const std::string lying =
        with(content, bytes_of<std::int32_t>({5, 8, 1, 1}), bytes_of<std::int32_t>({5, 8, size, 1}));
    const std::string refusal = refusal_of("mat", folder.write("struct.mat", lying));
    // What is there of a few elements may be read; none of the sizes ends the reader.
    EXPECT_EQ(refusal.find("(signal"), std::string::npos) << size << refusal;
    if (size < 0 || size > 1000) {
      EXPECT_NE(refusal.find("struct.mat"), std::string::npos) << size << refusal;
    }
  }
}

TEST(ForeignReader, RefusesAFewBytesThatAskForGigabytes) {
  const test::TemporaryFolder folder;
  const std::string lying = with(content_of("plain.mat"), bytes_of<std::int32_t>({5, 8, kRows, 1}),
                                 bytes_of<std::int32_t>({5, 8, 30'000, 20'000}));
  const std::string refusal = refusal_of("mat", folder.write("large.mat", lying));
  EXPECT_NE(refusal.find("600000000 values, more than a file of"), std::string::npos) << refusal;

  const std::filesystem::path path = folder.path() / "unwritten.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size = 150'000'000;
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  H5Dclose(H5Dcreate2(file, "u", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  H5Fclose(file);
  EXPECT_NE(refusal_of("hdf5", path).find("150000000 values in 0 bytes"), std::string::npos);
}

/// Datasets t and u, and y with the properties `how`.
void write_with(const std::filesystem::path& path, hid_t how) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size = kRows;
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  const std::vector<double> values = numbers(0.0, 0.01);
  for (const char* name : {"t", "u"}) {
    const hid_t data = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
    H5Dclose(data);
  }
  const hid_t elsewhere = H5Dcreate2(file, "y", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, how, H5P_DEFAULT);
  EXPECT_GE(elsewhere, 0);
  H5Dclose(elsewhere);
  H5Sclose(space);
  H5Pclose(how);
  H5Fclose(file);
}

TEST(ForeignReader, TakesNoNumbersFromAnotherFile) {
  // A record of a stranger would carry what its reader may see: keys, passwords.
  const test::TemporaryFolder folder;
  const auto secret = folder.write("secret", std::string(kRows * sizeof(double), 'S'));
  const auto outside = folder.path() / "outside.h5";
  const hid_t external = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(external, secret.c_str(), 0, kRows * sizeof(double));
  write_with(outside, external);
  EXPECT_NE(refusal_of("hdf5", outside).find("the numbers of y are in another file"), std::string::npos)
      << refusal_of("hdf5", outside);

  write_hdf5(folder.path() / "other.h5");
  const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t size = kRows;
  const hid_t space = H5Screate_simple(1, &size, nullptr);
  H5Pset_virtual(layout, space, (folder.path() / "other.h5").c_str(), "/a/b/y", space);
  write_with(folder.path() / "virtual.h5", layout);
  H5Sclose(space);
  EXPECT_NE(refusal_of("hdf5", folder.path() / "virtual.h5").find("the numbers of y are in another file"),
            std::string::npos);
}

TEST(ForeignReader, RefusesTextsThatLieOutsideTheirPlace) {
  const test::TemporaryFolder folder;
  write_mixed_hdf5(folder.path() / "mixed.h5", false);
  const std::string sound = os::read_file(folder.path() / "mixed.h5");
  const std::size_t heap = sound.find("GCOL");
  ASSERT_NE(heap, std::string::npos);
  EXPECT_EQ(refusal_of("hdf5", folder.path() / "mixed.h5"), "");
  constexpr std::size_t kSizeOfHeap = 8;
  constexpr std::size_t kSizeOfFirst = 24;
  for (const std::size_t at : {kSizeOfHeap, kSizeOfFirst}) {
    for (const std::int64_t size : {std::int64_t{-1}, std::int64_t{-8}, std::int64_t{1} << 20, std::int64_t{5000}}) {
      const std::string lying = std::string(sound).replace(heap + at, sizeof size, bytes_of({size}));
      EXPECT_NE(refusal_of("hdf5", folder.write("lying.h5", lying)).find("a text in it lies outside its place"),
                std::string::npos)
          << at << " " << size;
    }
  }
}

TEST(ForeignReader, RefusesGroupsWithoutEnd) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "deep.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  hid_t group = H5Gopen2(file, "/", H5P_DEFAULT);
  for (int depth = 0; depth < 2000; ++depth) {
    const hid_t inner = H5Gcreate2(group, "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Gclose(group);
    group = inner;
  }
  H5Gclose(group);
  H5Fclose(file);
  EXPECT_NE(refusal_of("hdf5", path).find("groups within each other"), std::string::npos) << refusal_of("hdf5", path);
}

TEST(ForeignReader, HasLimitsInProportionToTheFile) {
  EXPECT_EQ(record::limits_for(5'000'000).cpu_time, std::chrono::seconds(20));
  EXPECT_LE(record::limits_for(5'000'000).memory_bytes, std::uint64_t{1} << 30U);
  EXPECT_EQ(record::limits_for(UINT64_MAX).cpu_time, std::chrono::seconds(600));
  EXPECT_LE(record::limits_for(UINT64_MAX).memory_bytes, std::uint64_t{8} << 30U);
}

TEST(ForeignReader, GivesAFileOfHolesNoMoreThanItsDiskSpaceAsksFor) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("holes.mat", "nothing");
  std::filesystem::resize_file(file, std::uintmax_t{1} << 38U);
  record::ConfinedReader reader("mat", file);
  EXPECT_LE(reader.limits().memory_bytes, record::limits_for(1U << 20U).memory_bytes);
  EXPECT_LE(reader.limits().cpu_time, record::limits_for(1U << 20U).cpu_time);
  reader.kill();
  static_cast<void>(reader.wait());
}

TEST(ForeignReader, SaysThatAFileIsMissing) {
  EXPECT_THROW(static_cast<void>(read_foreign("mat", "/no/such/file.mat")), IoError);
}

}  // namespace
}  // namespace eha::importer
