// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/latency.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.hpp"

namespace eha::doctor {
namespace {

/// 1000 ticks, all but one at these times [us].
acquisition::RunReport report_of(std::int64_t latency_us, std::int64_t worst_us) {
  acquisition::RunReport report;
  for (int i = 0; i < 999; ++i) report.latency.add(latency_us * 1000, i);
  report.latency.add(worst_us * 1000, 999);
  report.execution.add(20'000, 0);
  return report;
}

std::vector<std::string> missed(const acquisition::RunReport& report) {
  std::vector<std::string> names;
  for (const Gate& gate : gates(report)) {
    if (!gate.met()) names.push_back(gate.name);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(LatencyGates, AreMetByAGoodLoop) { EXPECT_EQ(missed(report_of(49, 150)), Names{}); }

TEST(LatencyGates, AreMissedOneByOne) {
  EXPECT_EQ(missed(report_of(51, 52)), Names{"latency_p99_9_us"});
  EXPECT_EQ(missed(report_of(10, 151)), Names{"latency_max_us"});
  acquisition::RunReport report = report_of(10, 20);
  report.execution.add(301'000, 1);
  EXPECT_EQ(missed(report), Names{"execution_max_us"});
  report = report_of(10, 20);
  report.counters.skipped = 1;
  EXPECT_EQ(missed(report), Names{"skipped_ticks"});
  report = report_of(10, 20);
  report.counters.dropped = 1;
  EXPECT_EQ(missed(report), Names{"lost_records"});
}

TEST(Latency, IsMeasuredTickByTickForTheDuration) {
  const acquisition::StopRequest stop;
  const acquisition::RunReport report = measure_latency(0.3, {}, stop, {});
  EXPECT_EQ(report.outcome, acquisition::Outcome::completed);
  EXPECT_EQ(report.counters.experiment_rows, 300U);
  EXPECT_EQ(report.latency.count(), report.counters.ticks);
  EXPECT_EQ(report.execution.count(), report.counters.ticks);
  EXPECT_GT(report.execution.maximum_ns(), 0);
}

TEST(Latency, StopsWhenAsked) {
  acquisition::StopRequest stop;
  const acquisition::RunReport report = measure_latency(3600.0, {}, stop, [&](const acquisition::Snapshot& now) {
    if (now.state == acquisition::State::running && stop.count() == 0) stop.request();
  });
  EXPECT_EQ(report.outcome, acquisition::Outcome::interrupted);
  EXPECT_GT(report.latency.count(), 0U);
}

TEST(Latency, RefusesADurationThatIsNone) {
  const acquisition::StopRequest stop;
  for (const double duration_s : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(static_cast<void>(measure_latency(duration_s, {}, stop, {})), ConfigError) << duration_s;
  }
}

}  // namespace
}  // namespace eha::doctor
