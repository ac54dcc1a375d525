// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/raw_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/confined_reader.hpp"
#include "daemon/record/hdf5_handle.hpp"
#include "daemon/record/raw_hdf5.hpp"
#include "tests/unit/record/some_ticks.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

RecordSource in_pieces(const std::vector<TickRecord>& ticks, std::size_t piece) {
  return [&ticks, piece](const auto& consume) {
    for (std::size_t k = 0; k < ticks.size(); k += piece) {
      consume(std::span(ticks).subspan(k, std::min(piece, ticks.size() - k)));
    }
  };
}

TEST(RawFile, GivesBackEveryBitOfEveryMember) {
  const test::TemporaryFolder folder;
  std::vector<TickRecord> ticks = some_ticks(1000);
  ticks[17].displacement_in = std::numeric_limits<double>::quiet_NaN();
  ticks[18].scheduled_ns = std::numeric_limits<std::int64_t>::min();
  ticks[19].lateness_ns = std::numeric_limits<std::int32_t>::min();
  const nlohmann::ordered_json header = {{"name", "test"}, {"text", "\u00b5m\nsecond line"}};
  write_raw_file(folder.path() / "raw.h5", header, ticks.size(), 3'000'000, in_pieces(ticks, 64));
  const RawFile raw = read_raw_file(folder.path() / "raw.h5");
  EXPECT_TRUE(same_bits(raw.records, ticks));
  EXPECT_EQ(raw.header, header);
}

TEST(RawFile, HasTheSameBytesWhateverThePiecesItCameIn) {
  const test::TemporaryFolder folder;
  const std::vector<TickRecord> ticks = some_ticks(500);
  write_raw_file(folder.path() / "a.h5", {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 1));
  write_raw_file(folder.path() / "b.h5", {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 505));
  EXPECT_EQ(os::read_file(folder.path() / "a.h5"), os::read_file(folder.path() / "b.h5"));
}

TEST(RawFile, GivesItsRowsThroughAConfinedProcessAsWell) {
  const test::TemporaryFolder folder;
  const std::vector<TickRecord> ticks = some_ticks(1000);
  const auto path = folder.path() / "raw.h5";
  write_raw_file(path, {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 64));
  EXPECT_TRUE(same_bits(read_raw_rows(path), ticks));
  // The reader refuses, or its library ends it: this process goes on.
  const std::string sound = os::read_file(path);
  for (std::size_t at = 0; at < 2000; at += 40) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(~damaged[at]);
    try {
      static_cast<void>(read_raw_rows(folder.write("damaged.h5", damaged)));
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find("damaged.h5"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(static_cast<void>(read_raw_rows(folder.write("cut.h5", sound.substr(0, 100)))), DataError);
}

TEST(RawFile, TakesNoRowsFromAnotherFile) {
  // A run folder of a stranger: its report would show what the reader may see, or wait for a pipe without end.
  const test::TemporaryFolder folder;
  const std::vector<TickRecord> ticks = some_ticks(10);
  const auto path = folder.path() / "raw.h5";
  write_raw_file(path, {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 10));
  const auto secret = folder.write("secret", std::string(10 * sizeof(double), 'S'));
  {
    const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    ASSERT_GE(H5Ldelete(file.get(), "displacement_in", H5P_DEFAULT), 0);
    const hsize_t rows = ticks.size();
    const Hdf5Space space(H5Screate_simple(1, &rows, nullptr));
    const Hdf5Properties how(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_external(how.get(), secret.c_str(), 0, rows * sizeof(double));
    const Hdf5Dataset outside(
        H5Dcreate2(file.get(), "displacement_in", H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, how.get(), H5P_DEFAULT));
    ASSERT_TRUE(outside);
  }
  EXPECT_THROW(read_raw_file(path), DataError);
}

TEST(RawFile, HasPlainDatasetsWithUnitsAndTimeFromTheExperimentsFirstRow) {
  const test::TemporaryFolder folder;
  const std::vector<TickRecord> ticks = some_ticks(4);
  const std::string path = (folder.path() / "raw.h5").string();
  write_raw_file(path, {{"x", 1}}, ticks.size(), ticks[3].scheduled_ns, in_pieces(ticks, 100));
  const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  const Hdf5Dataset time(H5Dopen2(file.get(), "time_s", H5P_DEFAULT));
  std::vector<double> times_s(ticks.size());
  ASSERT_GE(H5Dread(time.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times_s.data()), 0);
  EXPECT_DOUBLE_EQ(times_s[3], 0.0);
  EXPECT_DOUBLE_EQ(times_s[0], -0.003);
  EXPECT_DOUBLE_EQ(times_s[8], 0.005);
  const Hdf5Dataset displacement(H5Dopen2(file.get(), "displacement_in", H5P_DEFAULT));
  const Hdf5Attribute unit(H5Aopen(displacement.get(), "unit", H5P_DEFAULT));
  const Hdf5Type type(H5Aget_type(unit.get()));
  std::string text(H5Tget_size(type.get()), ' ');
  ASSERT_GE(H5Aread(unit.get(), type.get(), text.data()), 0);
  EXPECT_EQ(text, "in");
}

TEST(RawFile, CountsTheLatenessOfATickFromTheFirstThatItSkipped) {
  const test::TemporaryFolder folder;
  std::vector<TickRecord> ticks(4);
  const std::array<std::uint32_t, 4> sequences{0, 1, 2, 5};  // 3 flagged as skipped, 4 not even that
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    ticks[k].sequence = sequences[k];
    ticks[k].scheduled_ns = 100'000 * std::int64_t{sequences[k]};
    ticks[k].lateness_ns = 7'000;
  }
  TickRecord skipped{};
  skipped.sequence = 3;
  skipped.flags = acquisition::kSkipped;
  ticks.insert(ticks.begin() + 3, skipped);
  const std::string path = (folder.path() / "raw.h5").string();
  write_raw_file(path, {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 2));
  const Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  const Hdf5Dataset histogram(H5Dopen2(file.get(), "latency_histogram", H5P_DEFAULT));
  const Hdf5Space space(H5Dget_space(histogram.get()));
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  ASSERT_GE(H5Dread(histogram.get(), H5T_NATIVE_UINT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, counts.data()), 0);
  ASSERT_GT(counts.size(), 208u);
  EXPECT_EQ(counts[7], 3u);
  EXPECT_EQ(counts[207], 1u);
}

TEST(RawFile, HoldsARunWithoutARow) {
  const test::TemporaryFolder folder;
  write_raw_file(folder.path() / "raw.h5", {{"x", 1}}, 0, 0, in_pieces({}, 1));
  EXPECT_TRUE(read_raw_file(folder.path() / "raw.h5").records.empty());
}

TEST(RawFile, LeavesNothingBehindWhenItCannotBeWritten) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(write_raw_file(folder.path() / "no" / "raw.h5", {}, 0, 0, in_pieces({}, 1)), IoError);
  const std::vector<TickRecord> ticks = some_ticks(10);
  EXPECT_THROW(write_raw_file(folder.path() / "raw.h5", {}, 11, 0, in_pieces(ticks, 4)), IoError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(RawFile, RefusesWhatIsNoRawRecordOrIsCutShort) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(static_cast<void>(read_raw_file(folder.path() / "absent.h5")), IoError);
  EXPECT_THROW(static_cast<void>(read_raw_file(folder.write("text.h5", "not HDF5"))), DataError);
  const std::vector<TickRecord> ticks = some_ticks(200);
  write_raw_file(folder.path() / "raw.h5", {{"x", 1}}, ticks.size(), 0, in_pieces(ticks, 100));
  const std::string whole = os::read_file(folder.path() / "raw.h5");
  for (const std::size_t size : {whole.size() / 4, whole.size() / 2, whole.size() - 1}) {
    EXPECT_THROW(static_cast<void>(read_raw_file(folder.write("cut.h5", whole.substr(0, size)))), DataError);
  }
}

}  // namespace
}  // namespace eha::record
