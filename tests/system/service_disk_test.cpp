// SPDX-License-Identifier: GPL-3.0-or-later
// What becomes of a run whose folder or disk is taken from it while the rig is driven.
#include <gtest/gtest.h>
#include <sys/mount.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/own_mounts.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;
using std::chrono::steady_clock;

/// Longest time from the loss to the ramp-out.
constexpr std::chrono::seconds kNoticed{1};

class ServiceDisk : public ::testing::Test {
 protected:
  void start_long_run() {
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
    client_->call("arm");
    entry_ = submit(*client_, quiet_experiment_text("long", 600.0), false);
    follow(daemon_, entry_, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
    run_ = daemon_.runs() / entry_of(daemon_, entry_).at("run").get<std::string>();
    const auto deadline = steady_clock::now() + kGenerous;
    while (fs::file_size(run_ / "raw.ehalog") < 50'000 && steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  /// Does something to the disk and follows the run to its end.
  /// @returns the run's entry in the queue
  Json after(const std::function<void()>& loss) {
    const steady_clock::time_point lost = steady_clock::now();
    loss();
    std::string state = "running";
    while (state == "running" && steady_clock::now() - lost < kGenerous) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      state = client_->call("status").at("state");
    }
    EXPECT_LT(steady_clock::now() - lost, kNoticed) << "the rig is still " << state;
    Json over = follow(daemon_, entry_);
    EXPECT_EQ(over.at("outcome"), "write_failed") << over;
    EXPECT_EQ(over.at("exit_code"), static_cast<int>(ExitCode::io));
    const Json status = client_->call("status");
    EXPECT_EQ(status.at("state"), "idle");
    const std::string note = over.at("note");
    EXPECT_NE(status.at("reason").get<std::string>().find(note), std::string::npos) << status << note;
    return over;
  }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
  std::int64_t entry_ = 0;
  fs::path run_;
};

TEST_F(ServiceDisk, RampsOutWithinASecondWhenTheRunFolderIsDeletedAndSaysWhatIsLost) {
  start_long_run();
  const std::string note = after([this] { fs::remove_all(run_); }).at("note");
  EXPECT_NE(note.find("was deleted"), std::string::npos) << note;
  EXPECT_NE(note.find("rows recorded so far are lost"), std::string::npos) << note;
  // The next run has a folder of its own again.
  client_->call("arm");
  EXPECT_EQ(follow(daemon_, submit(*client_, experiment_text("next"))).at("outcome"), "completed") << daemon_.log();
}

TEST_F(ServiceDisk, RampsOutWhenTheJournalAloneIsDeleted) {
  start_long_run();
  const std::string note = after([this] { fs::remove(run_ / "raw.ehalog"); }).at("note");
  EXPECT_NE(note.find("raw.ehalog was deleted"), std::string::npos) << note;
}

TEST_F(ServiceDisk, KeepsTheRecordOfARunThatWasMovedAway) {
  start_long_run();
  const fs::path moved = daemon_.folder() / "moved";
  const std::uint64_t rows = record::read_journal(run_ / record::kJournalFile, [](auto) {}).rows;
  ASSERT_GT(rows, 100U);
  after([&] { fs::rename(run_, moved); });
  const Ended recovered = run_eha({"runs", "recover", moved, "--json"}, daemon_.folder());
  EXPECT_EQ(recovered.code, 0) << recovered.err;
  EXPECT_GE(Json::parse(recovered.out).at("runs").at(0).at("rows").get<std::uint64_t>(), rows);
}

TEST_F(ServiceDisk, RampsOutWhenTheFolderTakesNoMoreFiles) {
  if (!has_own_mounts()) GTEST_SKIP() << "this user may not mount";
  start_long_run();
  const Mounted runs(daemon_.runs());
  const std::string note =
      after([this] {
        // The journal stays open for writing under it.
        ASSERT_EQ(mount(daemon_.runs().c_str(), daemon_.runs().c_str(), nullptr, MS_BIND, nullptr), 0);
        ASSERT_EQ(mount(nullptr, daemon_.runs().c_str(), nullptr, MS_BIND | MS_REMOUNT | MS_RDONLY, nullptr), 0);
      }).at("note");
  EXPECT_NE(note.find("Read-only file system"), std::string::npos) << note;
  EXPECT_NE(note.find("eha runs recover"), std::string::npos) << note;
  umount2(daemon_.runs().c_str(), MNT_DETACH);
  const Ended recovered = run_eha({"runs", "recover", run_, "--json"}, daemon_.folder());
  EXPECT_EQ(recovered.code, 0) << recovered.err;
  const Json manifest = Json::parse(content_of(run_ / "run.json"));
  EXPECT_EQ(manifest.at("outcome"), "write_failed") << "the journal's end was written";
}

TEST_F(ServiceDisk, RampsOutWhenTheDiskGoesReadOnly) {
  if (!has_own_mounts()) GTEST_SKIP() << "this user may not mount";
  const fs::path state = daemon_.folder() / "state";
  fs::create_directory(state);
  if (!mount_disk(daemon_.folder() / "disk", state)) GTEST_SKIP() << "no ext4 on a loop device here";
  const Mounted disk(state);
  const std::string device = output_of_shell("findmnt -n -o SOURCE " + state.string());
  const fs::path trigger =
      fs::path("/sys/fs/ext4") / fs::path(device.substr(0, device.find('\n'))).filename() / "trigger_fs_error";
  if (!fs::exists(trigger)) GTEST_SKIP() << "this kernel cannot have an error of the disk";
  start_long_run();
  const std::string note = after([&] { std::ofstream(trigger) << "1"; }).at("note");
  EXPECT_NE(note.find("Read-only file system"), std::string::npos) << note;
  EXPECT_NE(note.find("rows before are kept"), std::string::npos) << note;
}

}  // namespace
}  // namespace eha::test
