// SPDX-License-Identifier: GPL-3.0-or-later
// MAT-files and HDF5 that are damaged, or made to harm their reader.
#include "daemon/importer/foreign_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/importer/foreign_fixtures.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

using foreign::Fixture;
using foreign::kRows;
using foreign::numbers;

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
  EXPECT_EQ(limits_for(5'000'000).cpu_time, std::chrono::seconds(20));
  EXPECT_LE(limits_for(5'000'000).memory_bytes, std::uint64_t{1} << 30U);
  EXPECT_EQ(limits_for(UINT64_MAX).cpu_time, std::chrono::seconds(600));
  EXPECT_LE(limits_for(UINT64_MAX).memory_bytes, std::uint64_t{8} << 30U);
}

TEST(ForeignReader, SaysThatAFileIsMissing) {
  EXPECT_THROW(static_cast<void>(read_foreign("mat", "/no/such/file.mat")), IoError);
}

}  // namespace
}  // namespace eha::importer
