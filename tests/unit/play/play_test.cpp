// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"
#include "hal/faults/fault_rig.hpp"
#include "tests/unit/record/record_fixture.hpp"
#include "tests/unit/record/some_ticks.hpp"
#include "tests/unit/small_disk.hpp"

namespace eha::play {
namespace {

using acquisition::Outcome;
using acquisition::TickRecord;
using record::kJournalFile;
using record::kRawFile;
using record::list_runs;
using record::LoadedRun;
using record::read_manifest;
using record::read_run;
using record::read_ticks;
using test::FileSizeLimit;
using test::SmallDisk;

class Play : public record::RecordTest {
 protected:
  /// Plays ten repetitions of 2 s in virtual time, which a judge may end.
  Outcome outcome_with(EarlyEnd& judge) {
    set_duration(2.0);
    experiment_.repetitions = 10;
    PlayRequest judged = request();
    judged.early_end = &judge;
    const auto rig = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), rig_config_.limits.safe_V);
    acquisition::StateMachine machine;
    EXPECT_TRUE(machine.reset() && machine.arm());
    return play::play(*rig, machine, judged, stop_).report.outcome;
  }
};

TEST_F(Play, LeavesEveryFileOfARunFolderAndReadsBackWhatWasPlayed) {
  const FinishedRun finished = run();
  ASSERT_EQ(finished.report.outcome, Outcome::completed) << acquisition::describe(finished.report);
  EXPECT_EQ(finished.write_error, "");
  for (const char* name : {"run.json", "raw.ehalog", "raw.h5", "data_40ms.csv", "models"}) {
    EXPECT_TRUE(std::filesystem::exists(finished.folder / name)) << name;
  }
  const LoadedRun loaded = read_run(finished.folder);
  EXPECT_EQ(loaded.outcome, Outcome::completed);
  EXPECT_EQ(loaded.record.unmeasured.size(), 0u);
  EXPECT_EQ(loaded.samples_per_repetition, table_V_.size());
  EXPECT_DOUBLE_EQ(loaded.record.step_s, 0.001);
  ASSERT_EQ(loaded.record.input.size(), static_cast<Eigen::Index>(table_V_.size()));
  const double half_lsb_V = 0.5 * 20.0 / 65535.0;
  for (std::size_t k = 0; k < table_V_.size(); ++k) {
    ASSERT_NEAR(loaded.record.input[static_cast<Eigen::Index>(k)], table_V_[k], 1.01 * half_lsb_V) << "row " << k;
  }
  EXPECT_EQ(loaded.experiment_text, experiment_.text);
  EXPECT_EQ(loaded.rig_text, rig_config_.text);
}

TEST_F(Play, GivesTheSameBytesTwiceInVirtualTime) {
  const FinishedRun first = run("a");
  const FinishedRun second = run("b");
  for (const char* name : {"raw.ehalog", "raw.h5", "data_40ms.csv"}) {
    EXPECT_EQ(os::read_file(first.folder / name), os::read_file(second.folder / name)) << name;
  }
}

TEST_F(Play, PlaysNoRowBeforeThePressureHasBuiltUp) {
  rig_config_.limits.following = config::Following{.gain_positive_in_per_V_s = 0.07,
                                                   .gain_negative_in_per_V_s = 0.07,
                                                   .null_V = 0.02,
                                                   .dead_band_V = 0.2,
                                                   .pressure_delay_s = 1.5};
  const FinishedRun finished = run();
  ASSERT_EQ(finished.report.outcome, Outcome::completed);
  const std::vector<TickRecord> ticks = read_ticks(finished.folder);
  std::size_t played = 0;
  for (const TickRecord& tick : ticks) {
    if (tick.state == acquisition::State::running) ++played;
    if (tick.scheduled_ns < 1'500'000'000) {
      ASSERT_NE(tick.state, acquisition::State::running) << tick.scheduled_ns;
      ASSERT_LE(std::abs(tick.requested_V), 0.02) << tick.scheduled_ns;
    }
  }
  EXPECT_EQ(played, table_V_.size());
}

TEST_F(Play, WritesTheSameTicksToTheJournalAndToHdf5) {
  const FinishedRun finished = run();
  std::vector<TickRecord> journal;
  record::read_journal(finished.folder / kJournalFile, [&](std::span<const TickRecord> ticks) {
    journal.insert(journal.end(), ticks.begin(), ticks.end());
  });
  EXPECT_EQ(journal.size(), finished.report.counters.ticks);
  EXPECT_TRUE(record::same_bits(journal, read_ticks(finished.folder)));
}

TEST_F(Play, KeepsTheRecordWhenTheProgressDisplayFails) {
  set_duration(20.0);
  const std::unique_ptr<hal::Rig> rig =
      hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), rig_config_.limits.safe_V);
  acquisition::StateMachine machine;
  ASSERT_TRUE(machine.reset() && machine.arm());
  const auto fail = [](const acquisition::Snapshot&) { throw IoError("the terminal is gone"); };
  EXPECT_THROW(static_cast<void>(play(*rig, machine, request(), stop_, fail)), IoError);
  EXPECT_EQ(machine.state(), acquisition::State::idle);
  const std::vector<std::filesystem::path> runs = list_runs(folder_ / "runs");
  ASSERT_EQ(runs.size(), 1u);
  // Stopped if it was still going, which is a matter of speed.
  const nlohmann::ordered_json manifest = to_json(read_manifest(runs.front()));
  EXPECT_TRUE(manifest["outcome"] == "completed" || manifest["outcome"] == "interrupted") << manifest["outcome"];
  EXPECT_EQ(read_ticks(runs.front()).size(), manifest["report"]["counters"]["ticks"]);
}

TEST_F(Play, KeepsTheRecordOfAFaultedRunAndSaysWhatHappened) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
  hal::FaultRig rig(*sim, {{hal::FaultKind::emergency_stop, 800, hal::InjectedFault::kAlways, 0.0}});
  const FinishedRun finished = run_on(rig);
  EXPECT_EQ(finished.report.outcome, Outcome::faulted);
  const nlohmann::ordered_json manifest = to_json(read_manifest(finished.folder));
  EXPECT_EQ(manifest["outcome"], "faulted");
  EXPECT_EQ(manifest["report"]["fault"]["cause"], "emergency_stop");
  // In times of the record, which the ramp before is no part of.
  const record::LoadedRun run = read_run(finished.folder);
  const double end_s = static_cast<double>(run.record.output.size()) * run.record.step_s;
  EXPECT_LT(end_s, 0.8);
  EXPECT_NEAR(manifest["report"]["fault"]["at_s"], end_s, 1e-9);
  EXPECT_NE(acquisition::describe(finished.report).find(fmt::format("emergency_stop at {:.3f} s", end_s)),
            std::string::npos)
      << acquisition::describe(finished.report);
  EXPECT_EQ(read_ticks(finished.folder).size(), 801u);
  EXPECT_EQ(read_run(finished.folder).outcome, Outcome::faulted);
}

TEST_F(Play, InterpolatesAHeldSampleAndSaysSo) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
  hal::FaultRig rig(*sim,
                    {{hal::FaultKind::read_timed_out, 800, 1, 0.0}, {hal::FaultKind::read_timed_out, 900, 2, 0.0}});
  const FinishedRun finished = run_on(rig);
  EXPECT_EQ(finished.report.outcome, Outcome::completed);
  EXPECT_EQ(read_run(finished.folder).record.unmeasured.size(), 3u);
}

TEST_F(Play, LeavesNoFolderBehindWhenTheRunIsRefused) {
  rig_config_.limits.slew_V_per_s = 0.0;
  EXPECT_THROW(static_cast<void>(run()), ConfigError);
  EXPECT_TRUE(list_runs(folder_ / "runs").empty());
}

TEST_F(Play, RampsOutOnAStopAndKeepsWhatItHas) {
  stop_.request();
  const FinishedRun finished = run();
  EXPECT_EQ(finished.report.outcome, Outcome::interrupted);
  EXPECT_EQ(record::outcome_text(read_manifest(finished.folder)), "interrupted");
  EXPECT_FALSE(read_ticks(finished.folder).empty());
}

TEST_F(Play, ShowsTheCallerTheLastState) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  acquisition::Snapshot last;
  static_cast<void>(
      play(*rig, machine, request(), stop_, [&](const acquisition::Snapshot& snapshot) { last = snapshot; }));
  EXPECT_EQ(last.state, acquisition::State::idle);
  EXPECT_EQ(last.experiment_row, 2000u);
  EXPECT_EQ(last.experiment_rows, 2000u);
}

TEST_F(Play, RampsOutAndFailsWhenTheJournalCanGrowNoFurtherAndKeepsWhatItHolds) {
  set_duration(20.0);
  std::filesystem::path folder;
  {
    std::optional<FileSizeLimit> limit;
    PlayRequest limited = request();
    limited.before_driven = [&](hal::Rig&) { limit.emplace(100'000); };
    const std::unique_ptr<hal::Rig> rig = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
    acquisition::StateMachine machine;
    ASSERT_TRUE(machine.reset() && machine.arm());
    const FinishedRun finished = play(*rig, machine, limited, stop_);
    folder = finished.folder;
    EXPECT_EQ(finished.report.outcome, Outcome::write_failed);
    EXPECT_EQ(finished.report.final_state, acquisition::State::idle);
    EXPECT_TRUE(finished.report.safe_confirmed);
    EXPECT_LT(finished.report.counters.experiment_rows, 20'000u);
    EXPECT_NE(finished.write_error.find("File too large"), std::string::npos) << finished.write_error;
    EXPECT_EQ(acquisition::exit_code(finished.report), ExitCode::io);
    EXPECT_EQ(record::outcome_text(read_manifest(folder)), "write_failed");
    EXPECT_FALSE(std::filesystem::exists(folder / kRawFile));
  }
  // With room again, what was written comes back in whole blocks of 100 ticks.
  const record::Recovery recovery = record::recover_run(folder);
  EXPECT_EQ(recovery.outcome, Outcome::write_failed);
  EXPECT_GE(recovery.rows, 1000u);
  EXPECT_EQ(recovery.rows % 100, 0u);
  EXPECT_EQ(recovery.torn_bytes, 0u);
  EXPECT_EQ(read_ticks(folder).size(), recovery.rows);
}

TEST_F(Play, EndsInVirtualTimeWhenTheRowsThatAreToBeJudgedCannotBeWritten) {
  class NeverJudges final : public EarlyEnd {
    void note(int) override {}
  } judge;
  const FileSizeLimit limit(100'000);
  EXPECT_EQ(outcome_with(judge), Outcome::write_failed);
}

TEST_F(Play, EndsInVirtualTimeOnAStopWhileARepetitionIsJudged) {
  class StopsInstead final : public EarlyEnd {
   public:
    explicit StopsInstead(acquisition::StopRequest& stop) : stop_(stop) {}

   private:
    void note(int) override { stop_.request(); }

    acquisition::StopRequest& stop_;
  } judge(stop_);
  EXPECT_EQ(outcome_with(judge), Outcome::interrupted);
}

TEST_F(Play, RefusesToArmOnADiskThatIsTooSmallAndKeepsEveryRowOnOneThatFillsUp) {
  const SmallDisk disk(folder_ / "disk", "32m");
  if (!disk.mounted()) GTEST_SKIP() << "a small disk can be mounted by root only";
  set_duration(150.0);
  EXPECT_THROW(static_cast<void>(run("disk")), IoError);
  EXPECT_TRUE(list_runs(folder_ / "disk").empty());
  // 90 s fit; what takes the room comes after the check, from elsewhere.
  set_duration(90.0);
  std::fill(table_V_.begin(), table_V_.end(), 0.0);  // the sine drifts into a limit
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  PlayRequest filled = request("disk");
  filled.before_driven = [&](hal::Rig&) { disk.fill(); };
  const FinishedRun finished = play(*rig, machine, filled, stop_);
  EXPECT_EQ(finished.report.outcome, Outcome::write_failed);
  EXPECT_TRUE(finished.report.safe_confirmed);
  EXPECT_NE(finished.write_error.find("No space left"), std::string::npos) << finished.write_error;
  EXPECT_EQ(record::find_torn_runs(folder_ / "disk"), std::vector{finished.folder});
  // Every row was measured and is on the disk; only the files that are made of them wait for room.
  EXPECT_EQ(finished.report.counters.experiment_rows, 90'000U);
  disk.make_room();
  const record::Recovery recovery = record::recover_run(finished.folder);
  EXPECT_EQ(recovery.rows, finished.report.counters.ticks);
  EXPECT_EQ(recovery.outcome, Outcome::completed);
}

}  // namespace
}  // namespace eha::play
