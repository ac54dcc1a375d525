// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/recovery.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "daemon/record/manifest.hpp"
#include "daemon/record/report_json.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

using acquisition::Fault;

acquisition::RunReport ended_by(Fault fault, double value, double limit) {
  acquisition::RunReport report;
  report.outcome = acquisition::Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = fault, .at_ns = 343'000'000, .value = value, .limit = limit};
  return report;
}

/// What becomes of a machine's run that ehad did not survive.
Entry settled(const record::Manifest& written, bool keeps_last_rows = true) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "run");
  record::Manifest manifest = written;
  record::write_manifest(folder.path() / "run", manifest);
  Entry entry;
  entry.id = 7;
  entry.state = EntryState::running;
  entry.run = "run";
  entry.calibration = std::pair{0.31, 2.95};
  std::vector<Entry> entries{entry};
  settle(entries, folder.path(), keeps_last_rows);
  EXPECT_EQ(entries[0].state, EntryState::over);
  EXPECT_TRUE(entries[0].is_open_fault);
  return entries[0];
}

bool slips(const acquisition::RunReport& report) {
  record::Manifest manifest = record::manifest_from_header({{"name", "sine"}});
  record::put_report(manifest, report, "");
  return settled(manifest).has_open_slip;
}

TEST(Recovery, KeepsASlipWhoseEntryWasNotSaved) {
  EXPECT_TRUE(slips(ended_by(Fault::sensor_slip, 0.07, 0.05)));
  EXPECT_TRUE(slips(ended_by(Fault::velocity_limit, -122.3, -8.0)));
  EXPECT_FALSE(slips(ended_by(Fault::velocity_limit, -9.0, -8.0))) << "a rod may be that fast";
  EXPECT_FALSE(slips(ended_by(Fault::travel_limit, 5.9, 5.8)));
  acquisition::RunReport stands = ended_by(Fault::no_motion, 0.0, 0.01);
  EXPECT_FALSE(slips(stands));
  stands.fault.has_jumped = true;
  EXPECT_TRUE(slips(stands)) << "another fault ended it in the same moment";
}

TEST(Recovery, KeepsASlipThatOnlyTheJournalNames) {
  record::Manifest manifest = record::manifest_from_header({{"name", "sine"}});
  manifest.outcome = acquisition::Outcome::faulted;
  manifest.recovery = {.utc = record::utc_now(), .end = record::describe_end(ended_by(Fault::sensor_slip, 0.07, 0.05))};
  EXPECT_TRUE(settled(manifest).has_open_slip);
  manifest.recovery->end = nullptr;
  EXPECT_FALSE(settled(manifest).has_open_slip);
  manifest.other[record::kFaultOfRows] = "sensor_slip";
  EXPECT_TRUE(settled(manifest).has_open_slip) << "by its rows, killed before the end was written";
  manifest.other[record::kFaultOfRows] = "velocity_limit";
  EXPECT_TRUE(settled(manifest).has_open_slip) << "how fast is not known";
  manifest.other[record::kFaultOfRows] = "travel_limit";
  EXPECT_FALSE(settled(manifest).has_open_slip);
}

TEST(Recovery, TrustsNoRecoveredRunWhoseLastRowsDiedWithTheGuard) {
  record::Manifest manifest = record::manifest_from_header({{"name", "sine"}});
  manifest.outcome = acquisition::Outcome::recovered;
  manifest.recovery = {.utc = record::utc_now(), .end = nullptr};
  EXPECT_FALSE(settled(manifest, true).has_open_slip);
  EXPECT_TRUE(settled(manifest, false).has_open_slip);
  EXPECT_TRUE(settled(manifest, false).missed_motion);
}

}  // namespace
}  // namespace eha::service
