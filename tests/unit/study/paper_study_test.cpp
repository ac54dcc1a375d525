// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/study/paper_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "daemon/study/study_page.hpp"
#include "daemon/study/study_summary.hpp"

namespace eha::study {
namespace {

/// FO gains `published` points by the paper's procedure and `both` by the default one, on records of the first plant.
PaperStudy made_up(const std::vector<double>& published, const std::vector<double>& both) {
  PaperStudy study{.seeds = static_cast<int>(published.size()), .rows = {}, .failures = {}};
  for (std::size_t i = 0; i < published.size(); ++i) {
    for (const Treatment treatment : kTreatments) {
      StudyRow row{.plant = 0, .seed = i + 1, .treatment = treatment, .io = {}, .fo = {}};
      row.io.validation_r2_percent = 80.0;
      row.fo.validation_r2_percent = 80.0 + (treatment == Treatment::both ? both[i] : published[i]);
      row.fo.highest_order = 1.5;
      row.fo.stable = treatment == Treatment::both;
      study.rows.push_back(row);
    }
  }
  return study;
}

std::string joined(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += sentence + "\n";
  return text;
}

TEST(Quartiles, InterpolateBetweenSortedValues) {
  const Quartiles q = quartiles({4.0, 1.0, 3.0, 2.0, 5.0});
  EXPECT_DOUBLE_EQ(q.lower, 2.0);
  EXPECT_DOUBLE_EQ(q.median, 3.0);
  EXPECT_DOUBLE_EQ(q.upper, 4.0);
  EXPECT_DOUBLE_EQ(quartiles({1.0, 2.0}).median, 1.5);
  EXPECT_DOUBLE_EQ(quartiles({7.0}).upper, 7.0);
}

TEST(PaperStudy, GivesTheShareOfTheGainThatATreatmentLeaves) {
  const std::string text = joined(conclusions(cells_of(made_up({2.0, 8.0, 4.0}, {1.0, 1.0, 1.0}))));
  EXPECT_NE(text.find("FO scores +4.00 points (quartiles +3.00 .. +6.00) above IO"), std::string::npos) << text;
  EXPECT_NE(text.find("1 of 3 records reach the printed 6.33 points"), std::string::npos) << text;
  EXPECT_NE(text.find("With both it is +1.00 points (quartiles +1.00 .. +1.00), 25 % of it."), std::string::npos)
      << text;
}

TEST(PaperStudy, SpeaksOfNoShareWhereThereIsNoGain) {
  const std::string text = joined(conclusions(cells_of(made_up({-1.0, 0.05, 0.0}, {0.0, 0.0, 0.0}))));
  EXPECT_EQ(text.find("% of it"), std::string::npos) << text;
  EXPECT_NE(text.find("0 of 3 records reach"), std::string::npos) << text;
}

TEST(PaperStudy, NamesARecordThatCouldNotBeFitted) {
  PaperStudy study = made_up({1.0}, {1.0});
  study.failures.push_back({1, 7, "no <stable> model"});
  const std::string html = page_of(study).html;
  EXPECT_NE(html.find("Rig without friction, seed 7: no &lt;stable&gt; model"), std::string::npos);
}

TEST(PaperStudy, WritesARowARecordAndTreatment) {
  const std::string csv = to_csv(made_up({1.0, 2.0}, {0.0, 0.0}));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9);
  EXPECT_NE(csv.find("\nrig_with_friction,2,published,2,"), std::string::npos) << csv;
}

TEST(Plants, GiveTheSameRecordForTheSameSeedAndAnotherForAnother) {
  const PlantKind& kind = plant_kinds()[3];
  const ident::Record record = kind.record(5);
  EXPECT_EQ(record.output.size(), 50'000);
  EXPECT_EQ((record.output - kind.record(5).output).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_GT((record.output - kind.record(6).output).cwiseAbs().maxCoeff(), 0.1);
}

TEST(PaperStudy, FindsTheOrdersOfKnownPlantsByTheDefaultProcedure) {
  const PaperStudy study = study_paper(1, ident::run_in_order);
  ASSERT_TRUE(study.failures.empty()) << study.failures.front().reason;
  ASSERT_EQ(study.rows.size(), 16U);
  for (const StudyRow& row : study.rows) {
    const PlantKind& kind = plant_kinds()[row.plant];
    if (row.treatment != Treatment::both) continue;
    EXPECT_GT(row.io.validation_r2_percent, 95.0) << kind.name;
    if (kind.true_order) {
      EXPECT_NEAR(row.fo.highest_order, *kind.true_order, 0.1) << kind.name;
    }
  }
}

}  // namespace
}  // namespace eha::study
