// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/record_labels.hpp"

#include <gtest/gtest.h>

namespace eha::batch {
namespace {

using Labels = std::vector<std::string>;

TEST(RecordLabels, AreTheRigsOfOneExperimentWithTheTimeOnlyWhereTwoAreAlike) {
  EXPECT_EQ(labels_of({parts_of("runs/20261129T105158Z-paper", "simulated rig"),
                       parts_of("runs/20261129T105201Z-paper", "worn rig"),
                       parts_of("runs/20261129T105225Z-paper", "simulated rig")}),
            (Labels{"simulated rig 10:51:58", "worn rig", "simulated rig 10:52:25"}));
}

TEST(RecordLabels, HaveTheDayWhereTheRunsAreOfSeveral) {
  EXPECT_EQ(labels_of({parts_of("runs/20261129T105158Z-paper", "rig"), parts_of("runs/20261130T105158Z-paper", "rig")}),
            (Labels{"paper 2026-11-29 10:51:58", "paper 2026-11-30 10:51:58"}));
}

TEST(RecordLabels, AreNamesOfFilesOrTheirFoldersOrBoth) {
  EXPECT_EQ(labels_of({parts_of("a/pump 1.csv", ""), parts_of("a/pump 2.csv", "")}), (Labels{"pump 1", "pump 2"}));
  EXPECT_EQ(labels_of({parts_of("may/pump.csv", ""), parts_of("june/pump.csv", "")}), (Labels{"may", "june"}));
  EXPECT_EQ(labels_of({parts_of("may/a.csv", ""), parts_of("june/a.csv", ""), parts_of("may/b.csv", "")}),
            (Labels{"a may", "a june", "b may"}));
}

TEST(RecordLabels, CountRecordsThatNothingElseTellsApart) {
  EXPECT_EQ(labels_of({parts_of("x/a/p.csv", ""), parts_of("y/a/p.csv", "")}), (Labels{"p (no. 1)", "p (no. 2)"}));
  EXPECT_EQ(labels_of({parts_of("runs/20261129T105158Z-paper/", "rig")}), Labels{"paper"});
}

}  // namespace
}  // namespace eha::batch
