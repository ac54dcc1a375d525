// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/experiment_rows.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace eha::record {
namespace {

using acquisition::State;
using acquisition::TickRecord;

TickRecord tick(std::uint32_t sequence, State state = State::running, std::uint16_t flags = 0) {
  TickRecord row{};
  row.sequence = sequence;
  row.state = state;
  row.flags = flags;
  row.applied_V = 0.1 * sequence;
  row.displacement_in = (flags & acquisition::kSkipped) != 0 ? std::numeric_limits<double>::quiet_NaN() : sequence;
  return row;
}

struct Rows {
  std::vector<double> voltage_V;
  std::vector<double> displacement_in;
  std::size_t interpolated = 0;
};

Rows rows_of(const std::vector<TickRecord>& ticks) {
  Rows result;
  ExperimentRows rows("run", [&](std::size_t row, double voltage_V, double displacement_in) {
    EXPECT_EQ(row, result.voltage_V.size());
    result.voltage_V.push_back(voltage_V);
    result.displacement_in.push_back(displacement_in);
  });
  rows.add(ticks);
  rows.finish();
  result.interpolated = rows.interpolated().size();
  return result;
}

TEST(ExperimentRows, TakeOnlyTheRunningTicks) {
  const Rows rows =
      rows_of({tick(4, State::armed), tick(5, State::ramp_in), tick(6), tick(7), tick(8, State::ramp_out)});
  EXPECT_EQ(rows.displacement_in, (std::vector<double>{6, 7}));
  EXPECT_EQ(rows.interpolated, 0u);
}

TEST(ExperimentRows, InterpolateSkippedAndHeldTicksAndCountThem) {
  const Rows rows = rows_of({tick(10), tick(11, State::running, acquisition::kSkipped),
                             tick(12, State::running, acquisition::kFeedbackHeld), tick(13)});
  ASSERT_EQ(rows.displacement_in.size(), 4u);
  EXPECT_DOUBLE_EQ(rows.displacement_in[1], 11.0);
  EXPECT_DOUBLE_EQ(rows.displacement_in[2], 12.0);
  EXPECT_DOUBLE_EQ(rows.voltage_V[1], 1.1);  // the voltage is known even where the sensor missed
  EXPECT_EQ(rows.interpolated, 2u);
}

TEST(ExperimentRows, FillAGapInTheSequenceWithTheVoltageThatWasHeld) {
  const Rows rows = rows_of({tick(10), tick(14)});
  ASSERT_EQ(rows.displacement_in.size(), 5u);
  EXPECT_DOUBLE_EQ(rows.displacement_in[2], 12.0);
  EXPECT_DOUBLE_EQ(rows.voltage_V[3], 1.0);
  EXPECT_EQ(rows.interpolated, 3u);
}

std::string refusal_of(const std::vector<TickRecord>& ticks) {
  try {
    rows_of(ticks);
  } catch (const DataError& error) {
    return error.what();
  }
  return "none";
}

TEST(ExperimentRows, AreRefusedWhereTicksFallOrMoreThanAMillionHaveNoRow) {
  // Each missing row takes memory, and a file of two rows can name any tick.
  EXPECT_EQ(refusal_of({tick(1000), tick(1'001'001)}), "none");
  EXPECT_EQ(refusal_of({tick(1000), tick(1'001'002)}),
            "run: tick 1001002 comes after tick 1000, so that more than 1000000 ticks have no row: damaged; play the "
            "experiment again");
  EXPECT_NE(refusal_of({tick(0), tick(600'000), tick(1'200'000)}), "none");
  EXPECT_EQ(refusal_of({tick(1000), tick(1001), tick(999)}),
            "run: tick 999 comes after tick 1001: damaged; play the experiment again");
  EXPECT_NE(refusal_of({tick(1000), tick(1000)}), "none");
}

TEST(ExperimentRows, HoldTheNearestMeasurementAtBothEnds) {
  const Rows rows = rows_of({tick(10, State::running, acquisition::kFeedbackHeld), tick(11), tick(12),
                             tick(13, State::running, acquisition::kSkipped)});
  ASSERT_EQ(rows.displacement_in.size(), 4u);
  EXPECT_DOUBLE_EQ(rows.displacement_in[0], 11.0);
  EXPECT_DOUBLE_EQ(rows.displacement_in[3], 12.0);
}

TEST(ExperimentRows, AreNoneWhenNothingWasMeasured) {
  EXPECT_TRUE(rows_of({tick(10, State::running, acquisition::kSkipped)}).voltage_V.empty());
  EXPECT_TRUE(rows_of({}).voltage_V.empty());
}

}  // namespace
}  // namespace eha::record
