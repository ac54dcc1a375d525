// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_experiment.hpp"

#include <fstream>
#include <set>
#include <sstream>

#include "core/error.hpp"
#include "daemon/record/file_io.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/unit/record/record_fixture.hpp"

namespace eha::record {
namespace {

using acquisition::Outcome;
using acquisition::State;
using acquisition::TickRecord;

class RunExperiment : public RecordTest {};

TEST_F(RunExperiment, LeavesEveryFileOfARunFolderAndReadsBackWhatWasPlayed) {
  const FinishedRun finished = run();
  ASSERT_EQ(finished.report.outcome, Outcome::completed) << acquisition::describe(finished.report);
  EXPECT_EQ(finished.write_error, "");
  for (const char* name : {"run.json", "raw.ehalog", "raw.h5", "data_40ms.csv", "models"}) {
    EXPECT_TRUE(std::filesystem::exists(finished.folder / name)) << name;
  }
  const LoadedRun loaded = read_run(finished.folder);
  EXPECT_EQ(loaded.outcome, Outcome::completed);
  EXPECT_EQ(loaded.interpolated_rows, 0u);
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

TEST_F(RunExperiment, GivesTheSameBytesTwiceInVirtualTime) {
  const FinishedRun first = run("a");
  const FinishedRun second = run("b");
  for (const char* name : {"raw.ehalog", "raw.h5", "data_40ms.csv"}) {
    EXPECT_EQ(read_file(first.folder / name), read_file(second.folder / name)) << name;
  }
}

}  // namespace
}  // namespace eha::record
