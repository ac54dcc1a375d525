// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/sheet/compared_sheets.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "ident/excitation/portable_draw.hpp"

namespace eha::sheet {
namespace {

constexpr double kNull_V = 0.006;  // half of a 95 % interval, as the others
constexpr double kDeadBand_V = 0.007;
constexpr double kGain = 0.002;
constexpr double kCreep = 0.0002;

/// A sheet of one valve, whose errors are as its intervals say.
RunSheet drawn_sheet(ident::PortableDraw& draw) {
  const auto measured = [&](double value, double half_width) {
    return ident::Measured{value + half_width / 1.96 * draw.normal(), half_width};
  };
  RunSheet run;
  run.folder = "runs/sheet";
  run.rig.name = "rig";
  run.sheet.null_V = measured(-0.2, kNull_V);
  run.sheet.dead_band_V = measured(0.15, kDeadBand_V);
  run.sheet.gain_positive_in_per_V_s = measured(0.15, kGain);
  run.sheet.gain_negative_in_per_V_s = measured(0.13, kGain);
  run.sheet.creep_in_per_s = measured(0.001, kCreep);
  return run;
}

bool shows_a_change(const ComparedSheets& compared) {
  return compared.heading.find("has changed") != std::string::npos;
}

TEST(ComparedSheets, SayOfAnUnchangedValveThatItHasChangedInOneOfAHundredCasesAtMost) {
  ident::PortableDraw draw(7);
  constexpr int kPairs = 3000;
  int alarms = 0;
  for (int i = 0; i < kPairs; ++i) {
    alarms += shows_a_change(compare_sheets({drawn_sheet(draw), drawn_sheet(draw)}, DisplayUnit("in"))) ? 1 : 0;
  }
  EXPECT_LE(alarms, kPairs / 100 + 15) << "and the scatter of the count";
  EXPECT_GE(alarms, kPairs / 1000) << "intervals that are too wide show no change";
}

TEST(ComparedSheets, SayToMeasureTheValveOfTheSheetThatChanged) {
  ident::PortableDraw draw(3);
  RunSheet before = drawn_sheet(draw);
  before.access.rig_file = "before.toml";
  RunSheet after = before;
  after.sheet.null_V.value += 0.1;
  after.access.rig_file = "after.toml";
  EXPECT_EQ(compare_sheets({before, after, before}, DisplayUnit("in")).rig.rig_file, "after.toml");
  EXPECT_EQ(compare_sheets({after, before, before}, DisplayUnit("in")).rig.rig_file, "before.toml");
}

TEST(ComparedSheets, KeepThatOfAllSheetsTogether) {
  ident::PortableDraw draw(11);
  constexpr int kSets = 1000;
  int alarms = 0;
  for (int i = 0; i < kSets; ++i) {
    const std::vector<RunSheet> sheets{drawn_sheet(draw), drawn_sheet(draw), drawn_sheet(draw), drawn_sheet(draw)};
    alarms += shows_a_change(compare_sheets(sheets, DisplayUnit("in"))) ? 1 : 0;
  }
  EXPECT_LE(alarms, kSets / 100 + 8) << "and the scatter of the count";
}

TEST(ComparedSheets, NameWhatHasChangedOnceAndHowSureThatIs) {
  ident::PortableDraw draw(3);
  const RunSheet before = drawn_sheet(draw);
  RunSheet after = before;
  after.sheet.gain_positive_in_per_V_s.value *= 0.9;
  const ComparedSheets compared = compare_sheets({before, after, after}, DisplayUnit("mm"));
  EXPECT_EQ(compared.heading, "The sheet has changed: gain extending");
  EXPECT_EQ(compared.sentences.back(), "At most 1 % false alarms for all quantities and sheets together.");
  EXPECT_EQ(to_json(compared).at("false_alarm"), 0.01);
}

}  // namespace
}  // namespace eha::sheet
