// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/run_folder_check.hpp"

#include <gtest/gtest.h>

#include <cerrno>

#include "tests/unit/temporary_folder.hpp"

namespace eha::doctor {
namespace {

RunsFolder with_room_for(double seconds) {
  RunsFolder runs;
  runs.folder = runs.existing = "/data";
  runs.available_bytes = static_cast<std::uint64_t>(seconds * 1000 * 144);
  return runs;
}

TEST(RunsFolder, IsLookedForWhereItWillBeCreated) {
  const test::TemporaryFolder folder;
  const RunsFolder runs = look_at_runs_folder(folder.path() / "not" / "yet");
  EXPECT_EQ(runs.existing, folder.path());
  EXPECT_EQ(runs.write_error, 0);
  EXPECT_EQ(runs.space_error, 0);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "not"));
}

TEST(RunsFolder, CannotBeAFile) {
  const test::TemporaryFolder folder;
  const RunsFolder runs = look_at_runs_folder(folder.write("runs", "text"));
  EXPECT_EQ(runs.write_error, ENOTDIR);
  EXPECT_EQ(exit_code(check_runs_folder(runs, 0.001)), ExitCode::io);
}

TEST(RunsFolder, MustBeWritable) {
  RunsFolder runs = with_room_for(1e6);
  EXPECT_EQ(exit_code(check_runs_folder(runs, 0.001)), ExitCode::ok);
  runs.write_error = EACCES;
  EXPECT_EQ(exit_code(check_runs_folder(runs, 0.001)), ExitCode::permission);
  runs.write_error = EROFS;
  EXPECT_EQ(exit_code(check_runs_folder(runs, 0.001)), ExitCode::io);
}

TEST(RunsFolder, MustHoldTenMinutesOfTicksAndShouldHoldAnHour) {
  EXPECT_EQ(check_runs_folder(with_room_for(3700), 0.001).back().level, Level::ok);
  EXPECT_EQ(check_runs_folder(with_room_for(3500), 0.001).back().level, Level::warn);
  EXPECT_EQ(check_runs_folder(with_room_for(610), 0.001).back().level, Level::warn);
  EXPECT_EQ(check_runs_folder(with_room_for(590), 0.001).back().level, Level::fail);
  EXPECT_EQ(check_runs_folder(with_room_for(590), 0.01).back().level, Level::ok);
}

}  // namespace
}  // namespace eha::doctor
