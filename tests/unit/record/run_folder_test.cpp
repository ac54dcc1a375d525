// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_folder.hpp"

#include <sys/stat.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_files.hpp"
#include "daemon/record/sha256.hpp"
#include "tests/unit/record/record_fixture.hpp"

namespace eha::record {
namespace {

class RunFolder : public RecordTest {};

TEST_F(RunFolder, IsNamedAfterTheTimeAndTheExperimentAndNeverUsedTwice) {
  const std::filesystem::path first = create_run_folder(folder_ / "a" / "b", "paper/../x y");
  const std::filesystem::path second = create_run_folder(folder_ / "a" / "b", "paper/../x y");
  EXPECT_TRUE(std::regex_match(first.filename().string(), std::regex("[0-9]{8}T[0-9]{6}Z-paper-..-x-y")))
      << first.filename();
  EXPECT_NE(first, second);
  EXPECT_EQ(first.parent_path(), folder_ / "a" / "b");
}

TEST_F(RunFolder, ListsItsFilesWithTheirHashesInTheManifest) {
  const play::FinishedRun finished = run();
  const nlohmann::ordered_json manifest = to_json(read_manifest(finished.folder));
  EXPECT_EQ(manifest["outcome"], "completed");
  EXPECT_EQ(manifest["time_base"], "virtual");
  EXPECT_EQ(manifest["device"]["backend"], "sim");
  EXPECT_EQ(manifest["report"]["counters"]["experiment_rows"], 2000);
  std::vector<std::string> files;
  for (const auto& entry : manifest["files"]) {
    files.push_back(entry["path"]);
    EXPECT_EQ(entry["sha256"], sha256_of_file(finished.folder / files.back()));
    EXPECT_EQ(entry["bytes"], std::filesystem::file_size(finished.folder / files.back()));
  }
  EXPECT_EQ(files, (std::vector<std::string>{"data_40ms.csv", "raw.ehalog", "raw.h5"}));
}

TEST_F(RunFolder, TakesTheIdentificationIntoTheManifestWithTheModelsHashes) {
  const play::FinishedRun finished = run();
  os::write_file_atomically(finished.folder / kModelsFolder / "io.json", "{}");
  write_identification(finished.folder, {.accepted = true, .models = {}});
  const nlohmann::ordered_json manifest = to_json(read_manifest(finished.folder));
  EXPECT_EQ(manifest["identification"]["accepted"], true);
  EXPECT_EQ(manifest["files"].size(), 4u);
  EXPECT_EQ(manifest["files"][1]["path"], "models/io.json");
}

TEST_F(RunFolder, IsRefusedWithAPipeOrADeviceAmongItsFiles) {
  const play::FinishedRun finished = run();
  for (const char* name : {"fit.csv", "models/io.json", "models/rejected/fo.json"}) {
    const auto path = finished.folder / name;
    std::filesystem::create_directories(path.parent_path());
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    EXPECT_THROW(static_cast<void>(read_manifest(finished.folder)), DataError) << name;
    EXPECT_THROW(static_cast<void>(recover_run(finished.folder)), DataError) << name;
    std::filesystem::remove(path);
    std::filesystem::create_symlink("/dev/zero", path);
    EXPECT_THROW(static_cast<void>(read_manifest(finished.folder)), DataError) << name;
    std::filesystem::remove(path);
  }
  EXPECT_NO_THROW(static_cast<void>(read_run(finished.folder)));
}

/// A sparse file takes no space on the disk, and hours to read.
TEST_F(RunFolder, IsRefusedWithAFileThatNoRunHas) {
  for (const char* name : {"raw.ehalog", "raw.h5", "fit.csv", "models/io.json"}) {
    const play::FinishedRun finished = run();
    const auto path = finished.folder / name;
    if (!std::filesystem::exists(path)) std::ofstream(path) << "{}";
    std::filesystem::resize_file(path, std::uintmax_t{1} << 40U);
    for (const bool reads : {true, false}) {
      try {
        if (reads) {
          static_cast<void>(read_run(finished.folder));
        } else {
          static_cast<void>(recover_run(finished.folder));
        }
        ADD_FAILURE() << name;
      } catch (const DataError& error) {
        EXPECT_NE(std::string(error.what()).find(std::string(name) + ": 1024 GiB"), std::string::npos) << error.what();
      }
    }
  }
}

TEST_F(RunFolder, NoticesARawRecordThatWasChangedSinceTheRunEvenAfterTheManifestWasFinished) {
  const play::FinishedRun finished = run();
  std::string raw = os::read_file(finished.folder / kRawFile);
  raw[raw.size() / 2] = static_cast<char>(raw[raw.size() / 2] ^ 1);
  std::ofstream(finished.folder / kRawFile, std::ios::binary) << raw;
  EXPECT_THROW(static_cast<void>(read_run(finished.folder)), DataError);
  write_identification(finished.folder, {});
  EXPECT_THROW(static_cast<void>(read_run(finished.folder)), DataError);
}

TEST_F(RunFolder, IsReadFromTheJournalWhenTheHdf5FileIsGone) {
  const play::FinishedRun finished = run();
  const LoadedRun from_hdf5 = read_run(finished.folder);
  std::filesystem::remove(finished.folder / kRawFile);
  const LoadedRun from_journal = read_run(finished.folder);
  EXPECT_EQ(from_hdf5.record.input, from_journal.record.input);
  EXPECT_EQ(from_hdf5.record.output, from_journal.record.output);
}

TEST_F(RunFolder, LeavesAFileOfTheNameLatest) {
  const play::FinishedRun finished = run();
  const std::filesystem::path file = folder_ / "runs" / "latest";
  std::ofstream(file) << "precious";
  EXPECT_NE(what_stands_for_latest(OpenRun(finished.folder)).find("is a file and stays"), std::string::npos);
  publish_latest(OpenRun(finished.folder));
  EXPECT_EQ(os::read_file(file), "precious");
}

TEST_F(RunFolder, MovesLatestToARunAndItCanBeReadThroughTheLink) {
  const play::FinishedRun first = run();
  publish_latest(OpenRun(first.folder));
  const play::FinishedRun second = run();
  publish_latest(OpenRun(second.folder));
  const std::filesystem::path latest = folder_ / "runs" / "latest";
  EXPECT_EQ(std::filesystem::read_symlink(latest), second.folder.filename());
  EXPECT_EQ(read_run(latest).folder, std::filesystem::canonical(second.folder));
  EXPECT_EQ(list_runs(folder_ / "runs"), (std::vector{first.folder, second.folder}));
}

TEST_F(RunFolder, HoldsTheDecimatedRowsAfterTheDiscardedTimeUnfiltered) {
  experiment_.repetitions = 2;
  const play::FinishedRun finished = run();
  const LoadedRun loaded = read_run(finished.folder);
  std::ifstream file(finished.folder / "data_40ms.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "time_s,voltage_V,displacement_in");
  Eigen::Index row = 520;  // the first multiple of 40 from 0.5 s on
  while (std::getline(file, line)) {
    std::istringstream stream(line);
    double time_s = 0.0;
    double voltage_V = 0.0;
    double displacement_in = 0.0;
    char comma = 0;
    ASSERT_TRUE(stream >> time_s >> comma >> voltage_V >> comma >> displacement_in) << line;
    EXPECT_DOUBLE_EQ(time_s, static_cast<double>(row) / 1000.0);
    EXPECT_EQ(voltage_V, loaded.record.input[row]);
    EXPECT_EQ(displacement_in, loaded.record.output[row]);
    row += 40;
  }
  EXPECT_EQ(row, 4000);
}

TEST_F(RunFolder, RefusesWhatIsNoRun) {
  EXPECT_THROW(static_cast<void>(read_run(folder_ / "absent")), IoError);
  EXPECT_THROW(static_cast<void>(read_run(folder_)), IoError);
  std::ofstream(folder_ / kManifestFile) << "{\"schema\": \"other\"}";
  EXPECT_THROW(static_cast<void>(read_run(folder_)), DataError);
  std::ofstream(folder_ / kManifestFile) << "{\"schema\": \"eha-run/1\"}";
  EXPECT_THROW(static_cast<void>(read_run(folder_)), DataError);
  EXPECT_TRUE(list_runs(folder_ / "absent").empty());
  EXPECT_FALSE(is_run_folder(folder_ / "absent"));
}

TEST(SecondsText, NeverRounds) {
  EXPECT_EQ(seconds_text(0), "0");
  EXPECT_EQ(seconds_text(10'040'000'000), "10.04");
  EXPECT_EQ(seconds_text(7'199'999'000'000), "7199.999");
  EXPECT_EQ(seconds_text(1), "0.000000001");
}

TEST(DecimatedFileName, SaysTheSpacing) {
  EXPECT_EQ(decimated_file_name(0.04), "data_40ms.csv");
  EXPECT_EQ(decimated_file_name(0.001), "data_1ms.csv");
  EXPECT_EQ(decimated_file_name(0.0005), "data_0.5ms.csv");
  EXPECT_EQ(decimated_file_name(1.0), "data_1000ms.csv");
}

}  // namespace
}  // namespace eha::record
