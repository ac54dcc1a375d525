// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/recover.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/raw_hdf5.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "tests/unit/readers_lock.hpp"
#include "tests/unit/record/record_fixture.hpp"
#include "tests/unit/record/some_ticks.hpp"

namespace eha::record {
namespace {

using acquisition::Outcome;

class Recover : public RecordTest {
 protected:
  /// A run folder as a killed process leaves it.
  std::filesystem::path torn_run(std::size_t bytes_missing) {
    const play::FinishedRun finished = run();
    whole_ = read_ticks(finished.folder);
    std::filesystem::remove(finished.folder / kRawFile);
    std::filesystem::remove(finished.folder / "data_40ms.csv");
    nlohmann::ordered_json manifest = to_json(read_manifest(finished.folder));
    manifest["outcome"] = kInProgress;
    manifest["files"] = nullptr;
    manifest["report"] = nullptr;
    os::write_file_atomically(finished.folder / kManifestFile, manifest.dump());
    const std::filesystem::path journal = finished.folder / kJournalFile;
    std::filesystem::resize_file(journal, std::filesystem::file_size(journal) - bytes_missing);
    return finished.folder;
  }

  std::vector<acquisition::TickRecord> whole_;
};

TEST_F(Recover, MakesAReadableRunOfATornOneAndLosesOnlyItsLastBlock) {
  const std::filesystem::path folder = torn_run(1000);
  EXPECT_THROW(static_cast<void>(read_run(folder)), DataError);
  EXPECT_EQ(find_torn_runs(folder_ / "runs"), std::vector{folder});
  const Recovery recovery = recover_run(folder);
  EXPECT_TRUE(recovery.changed);
  EXPECT_EQ(recovery.outcome, Outcome::recovered);
  EXPECT_GT(recovery.torn_bytes, 0u);
  EXPECT_GE(recovery.rows + 100, whole_.size());
  const std::vector<acquisition::TickRecord> ticks = read_ticks(folder);
  ASSERT_EQ(ticks.size(), recovery.rows);
  EXPECT_TRUE(same_bits(ticks, {whole_.begin(), whole_.begin() + static_cast<std::ptrdiff_t>(ticks.size())}));
  const LoadedRun loaded = read_run(folder);
  EXPECT_EQ(loaded.outcome, Outcome::recovered);
  EXPECT_GT(loaded.record.input.size(), 1900);
  EXPECT_TRUE(std::filesystem::exists(folder / "data_40ms.csv"));
  EXPECT_TRUE(find_torn_runs(folder_ / "runs").empty());
}

TEST_F(Recover, TakesTheOutcomeFromTheJournalsEndWhenThatWasWritten) {
  const std::filesystem::path folder = torn_run(0);
  EXPECT_EQ(recover_run(folder).outcome, Outcome::completed);
  EXPECT_EQ(read_run(folder).outcome, Outcome::completed);
}

TEST_F(Recover, TakesTheFaultFromTheRowsOfARunKilledAfterItsTrip) {
  const std::filesystem::path folder = torn_run(1000);
  const std::filesystem::path journal = folder / kJournalFile;
  const nlohmann::ordered_json header = read_journal(journal, [](auto) {}).header;
  std::filesystem::remove(journal);
  whole_.back().fault = acquisition::Fault::sensor_slip;
  {
    JournalWriter writer(journal, header, 100);
    writer.append(whole_);
    writer.write_pending();
  }
  recover_run(folder);
  const Manifest manifest = read_manifest(folder);
  EXPECT_EQ(manifest.outcome, Outcome::recovered);
  EXPECT_EQ(manifest.other.at(kFaultOfRows), "sensor_slip");
  EXPECT_TRUE(reading_jumped(manifest));
}

TEST_F(Recover, MayBeRepeatedAndThenChangesNothing) {
  const std::filesystem::path folder = torn_run(1000);
  const Recovery first = recover_run(folder);
  const std::string manifest = os::read_file(folder / kManifestFile);
  const Recovery second = recover_run(folder);
  EXPECT_FALSE(second.changed);
  EXPECT_EQ(second.rows, first.rows);
  EXPECT_EQ(os::read_file(folder / kManifestFile), manifest);
}

TEST_F(Recover, NeedsNoManifest) {
  const std::filesystem::path folder = torn_run(1000);
  std::filesystem::remove(folder / kManifestFile);
  EXPECT_EQ(find_torn_runs(folder_ / "runs").size(), 1u);
  recover_run(folder);
  const LoadedRun loaded = read_run(folder);
  EXPECT_EQ(loaded.experiment_text, experiment_.text);
  EXPECT_EQ(loaded.manifest.other["seed"]["sensor_noise"], std::get<hal::SimOptions>(rig_config_.backend).seed);
}

TEST_F(Recover, ClaimsNeitherItsOwnHostNorItsOwnKernelForARunThatNamesNone) {
  const std::filesystem::path folder = torn_run(1000);  // in virtual time, where equal runs have equal journals
  std::filesystem::remove(folder / kManifestFile);
  recover_run(folder);
  const nlohmann::ordered_json manifest = to_json(read_manifest(folder));
  for (const char* key : {"host", "kernel", "utc_start"}) EXPECT_TRUE(manifest.at(key).is_null()) << key;
}

TEST_F(Recover, TakesHostKernelAndTimeOfARealRunFromItsJournal) {
  const std::unique_ptr<hal::Rig> rig =
      hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), rig_config_.limits.safe_V);
  nlohmann::ordered_json header = describe_run(
      rig->capabilities(),
      {rig_config_, experiment_, table_V_.size(), acquisition::TimeBase::monotonic, "2026-01-02T03:04:05Z"});
  EXPECT_FALSE(header.at("host").get<std::string>().empty());
  EXPECT_TRUE(header.at("kernel").contains("release"));
  header["host"] = "rig";
  header["kernel"]["release"] = "6.1.0-rt";
  const std::filesystem::path folder = create_run_folder(folder_ / "runs", "real");
  {
    JournalWriter writer(folder / kJournalFile, header, 100);
    writer.append(some_ticks(95));
  }
  recover_run(folder);
  const nlohmann::ordered_json manifest = to_json(read_manifest(folder));
  EXPECT_EQ(manifest["host"], "rig");
  EXPECT_EQ(manifest["kernel"]["release"], "6.1.0-rt");
  EXPECT_EQ(manifest["utc_start"], "2026-01-02T03:04:05Z");
}

TEST_F(Recover, LosesAtMostThreeHundredRowsToOneFlippedBitAnywhere) {
  set_duration(10.0);
  const std::filesystem::path folder = torn_run(0);
  const std::filesystem::path journal = folder / kJournalFile;
  const std::string whole = os::read_file(journal);
  std::fstream file(journal, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](std::size_t offset, char byte) {
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(byte);
    file.flush();
  };
  const std::string manifest = os::read_file(folder / kManifestFile);
  std::size_t worst = 0;
  for (std::size_t i = 0; i < whole.size(); i += 1000) {
    put(i, static_cast<char>(static_cast<unsigned char>(whole[i]) ^ (1U << (i / 1000 % 8))));
    std::size_t intact = 0;
    std::size_t at = 0;
    const JournalFacts facts = read_journal(journal, [&](std::span<const acquisition::TickRecord> ticks) {
      for (const acquisition::TickRecord& tick : ticks) {
        const bool is_whole = std::memcmp(&tick, &whole_.at(at++), sizeof tick) == 0;
        ASSERT_NE(is_whole, (tick.flags & acquisition::kLost) != 0) << "byte " << i;
        intact += is_whole ? 1 : 0;
      }
    });
    ASSERT_EQ(facts.rows, whole_.size()) << "byte " << i;
    worst = std::max(worst, whole_.size() - intact);
    ASSERT_LE(worst, 300u) << "byte " << i;
    // The files are made again from some of them, header and end among them.
    if (i % 50'000 == 0 || i + 1000 >= whole.size()) {
      const Recovery recovery = recover_run(folder);
      EXPECT_EQ(recovery.rows, intact) << "byte " << i;
      EXPECT_GE(read_run(folder).record.input.size(), 10'000 - 300) << "byte " << i;
      std::filesystem::remove(folder / kRawFile);
      os::write_file_atomically(folder / kManifestFile, manifest);
    }
    put(i, whole[i]);
  }
  EXPECT_GT(worst, 0u);
}

TEST_F(Recover, MarksWhatWasLostAndTakesNoSuchRunForACompletedOne) {
  set_duration(10.0);
  const std::filesystem::path folder = torn_run(0);
  {
    std::fstream file(folder / kJournalFile, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(folder / kJournalFile) / 2));
    file.put('\x5a');
    file.put('\xa5');
  }
  const Recovery recovery = recover_run(folder);
  EXPECT_EQ(recovery.outcome, Outcome::recovered) << "only a completed run is fitted by itself";
  EXPECT_EQ(recovery.gaps, 1u);
  EXPECT_EQ(recovery.lost_rows, 100u);
  EXPECT_EQ(recovery.rows + recovery.lost_rows, whole_.size());
  const std::vector<acquisition::TickRecord> ticks = read_ticks(folder);
  ASSERT_EQ(ticks.size(), whole_.size());
  const LoadedRun loaded = read_run(folder);
  EXPECT_EQ(loaded.record.unmeasured.size(), 100u);
  ASSERT_EQ(loaded.record.input.size(), 10'000);
  ASSERT_EQ(loaded.manifest.recovery->gaps.size(), 1u);
  EXPECT_EQ(loaded.manifest.recovery->gaps[0].rows, 100u);
  // The sine between two known voltages of a tenth of a second: at most A w^2 T^2 / 8.
  const auto first = static_cast<Eigen::Index>(
      std::find_if(ticks.begin(), ticks.end(), [](const auto& t) { return (t.flags & acquisition::kLost) != 0; }) -
      std::find_if(ticks.begin(), ticks.end(), [](const auto& t) { return t.state == acquisition::State::running; }));
  for (Eigen::Index k = first - 1; k < first + 101; ++k) {
    EXPECT_NEAR(loaded.record.input[k], table_V_[static_cast<std::size_t>(k)], 0.02) << "row " << k;
  }
  EXPECT_NE(os::read_file(folder / "data_40ms.csv").find("# 100 ticks from "), std::string::npos);
}

TEST_F(Recover, TakesTheHeaderFromTheManifestWhenTheJournalsIsDamaged) {
  const std::filesystem::path folder = torn_run(0);
  const nlohmann::ordered_json header = read_journal(folder / kJournalFile, [](auto) {}).header;
  {
    std::fstream file(folder / kJournalFile, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(100);
    file.put('\x01');
  }
  const Recovery recovery = recover_run(folder);
  EXPECT_EQ(recovery.outcome, Outcome::completed) << "no row was lost";
  EXPECT_EQ(recovery.rows, whole_.size());
  const nlohmann::json taken = read_raw_file(folder / kRawFile).header;
  EXPECT_EQ(taken, nlohmann::json(header));
  std::filesystem::remove(folder / kRawFile);
  std::filesystem::remove(folder / kManifestFile);
  EXPECT_THROW(recover_run(folder), DataError) << "nobody knows the experiment any more";
}

TEST_F(Recover, IsNotStoppedByAManifestWithFieldsOfTheWrongKind) {
  for (const char* text : {R"({"schema": 1})", R"({"schema": "eha-run/1", "outcome": 7})",
                           R"({"schema": "eha-run/1", "outcome": "in_progress", "files": ["raw.h5"]})"}) {
    const std::filesystem::path folder = torn_run(1000);
    os::write_file_atomically(folder / kManifestFile, text);
    EXPECT_THROW(static_cast<void>(read_manifest(folder)), DataError) << text;
    EXPECT_EQ(find_torn_runs(folder_ / "runs"), std::vector{folder}) << text;
    EXPECT_EQ(recover_run(folder).outcome, Outcome::recovered) << text;
    EXPECT_NO_THROW(static_cast<void>(read_run(folder))) << text;
  }
}

TEST_F(Recover, LeavesARunAloneThatIsStillGoing) {
  const std::filesystem::path folder = create_run_folder(folder_ / "runs", "going");
  const JournalWriter writer(folder / kJournalFile, {{"name", "going"}}, 100);
  EXPECT_TRUE(find_torn_runs(folder_ / "runs").empty());
  EXPECT_THROW(recover_run(folder), IoError);
}

TEST_F(Recover, FindsATornRunThatAReaderHasLocked) {
  const std::filesystem::path folder = torn_run(1000);
  const os::FileDescriptor readers = test::locked_by_a_reader(folder / kJournalFile);
  EXPECT_EQ(find_torn_runs(folder_ / "runs"), std::vector{folder});
  EXPECT_TRUE(recover_run(folder).changed);
}

TEST_F(Recover, SaysWhichRunItSkipsBecauseItIsBeingWritten) {
  const std::filesystem::path folder = create_run_folder(folder_ / "runs", "going");
  const JournalWriter writer(folder / kJournalFile, {{"name", "going"}}, 100);
  std::string skipped;
  recover_torn_runs(folder_ / "runs", {.skipped = [&](const std::string& message) { skipped = message; },
                                       .recovered = [](const std::string& message) { FAIL() << message; },
                                       .failed = [](const std::string& message) { FAIL() << message; }});
  EXPECT_EQ(skipped, folder.string() +
                         ": not recovered: another process is writing it; once that has ended: eha runs "
                         "recover " +
                         folder.string());
}

TEST_F(Recover, CutsNoJournalWhoseLockSomebodyHas) {
  constexpr off_t kRoom = 1 << 20;
  const auto on_disk = [](const std::filesystem::path& journal) {
    struct stat facts {};
    EXPECT_EQ(::stat(journal.c_str(), &facts), 0);
    return facts.st_blocks * 512;
  };
  for (const bool is_locked : {true, false}) {
    const std::filesystem::path journal = torn_run(1000) / kJournalFile;
    const os::FileDescriptor file = os::open_file(journal, O_RDWR);
    const auto size = static_cast<off_t>(std::filesystem::file_size(journal));
    if (::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, size, kRoom) != 0) GTEST_SKIP() << "nothing can be reserved";
    if (is_locked) {
      ASSERT_EQ(::flock(file.get(), LOCK_SH | LOCK_NB), 0);
    }
    EXPECT_TRUE(recover_run(journal.parent_path()).changed);
    EXPECT_EQ(on_disk(journal) >= kRoom, is_locked);
    std::filesystem::remove_all(folder_ / "runs");
  }
}

TEST_F(Recover, SaysWhenThereIsNothingToRecoverFrom) {
  const std::filesystem::path folder = create_run_folder(folder_ / "runs", "empty");
  EXPECT_THROW(recover_run(folder), IoError);
  std::ofstream(folder / kJournalFile) << "garbage";
  EXPECT_THROW(recover_run(folder), DataError);
}

}  // namespace
}  // namespace eha::record
