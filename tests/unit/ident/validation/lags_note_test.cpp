// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/lags_note.hpp"

#include <gtest/gtest.h>

#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

Model model_with_lags(double acf, double ccf, double p_input) {
  Model model = good_model();
  model.output_unit = "mm";
  model.validation->acf.values = {1.0, acf};
  model.validation->ccf.values = {0.0, ccf, ccf, ccf};
  model.validation->tests->input.p = p_input;
  return model;
}

std::string lags_note_on(const Model& model, const AcceptanceLimits& limits = {}) {
  return lags_note(model, judge(model, limits));
}

TEST(LagsNote, IsSilentWhereNoLagIsOutside) { EXPECT_EQ(lags_note_on(model_with_lags(0.01, 0.02, 0.5)), ""); }

TEST(LagsNote, SaysWhyLagsOutsideDoNotReject) {
  const std::string note = lags_note_on(model_with_lags(0.9, 0.5, 1e-6));
  EXPECT_NE(note.find("lacks a part of the plant"), std::string::npos) << note;
  EXPECT_NE(note.find("lower the verdict to usable"), std::string::npos) << note;
  EXPECT_NE(note.find("0.1 mm rms, 12 % of the output's standard deviation"), std::string::npos) << note;
}

TEST(LagsNote, CallsColouredNoiseNoPartOfThePlant) {
  const std::string note = lags_note_on(model_with_lags(0.9, 0.02, 0.5));
  EXPECT_NE(note.find("the input has no part in it"), std::string::npos) << note;
}

TEST(LagsNote, SaysThatTheTestOfAllLagsGrades) {
  const std::string note = lags_note_on(model_with_lags(0.01, 0.5, 0.5));
  EXPECT_NE(note.find("the test of all together"), std::string::npos) << note;
}

TEST(LagsNote, SaysThatTheTestOfAllLagsFindsWhatNoSingleOneShows) {
  for (const double acf : {0.01, 0.9}) {
    const std::string note = lags_note_on(model_with_lags(acf, 0.02, 1e-21));
    EXPECT_NE(note.find("the test of all lags together finds"), std::string::npos) << note;
    EXPECT_NE(note.find("two tests"), std::string::npos) << note;
  }
}

TEST(LagsNote, CountsLagsAsThe95PercentBoundThatIsPrintedDoes) {
  Model model = model_with_lags(0.01, 0.02, 1e-21);
  Correlation& ccf = model.validation->ccf;
  ccf.values.assign(20, 0.0);
  ccf.lags.resize(20);
  for (int lag = 0; lag < 20; ++lag) ccf.lags[static_cast<std::size_t>(lag)] = lag;
  // Five of twenty beyond 95 %, none beyond 99 %: more than chance puts there.
  for (std::size_t k = 0; k < 5; ++k) ccf.values[k] = 0.5 * (ccf.bound95 + ccf.bound99);
  EXPECT_EQ(lags_note_on(model).find("No more lags"), std::string::npos) << lags_note_on(model);
  for (std::size_t k = 2; k < 5; ++k) ccf.values[k] = 0.0;
  EXPECT_NE(lags_note_on(model).find("No more lags"), std::string::npos) << lags_note_on(model);
}

TEST(LagsNote, LeavesNoGapWhereTheRecordHasNoUnit) {
  Model model = model_with_lags(0.9, 0.02, 0.5);
  model.output_unit.clear();
  EXPECT_NE(lags_note_on(model).find("what is left, 0.1 rms,"), std::string::npos) << lags_note_on(model);
  model.validation->tests->input.p = 1e-9;
  for (const std::string& reason : judge(model, {}).reasons) EXPECT_EQ(reason.find("  "), std::string::npos) << reason;
}

TEST(LagsNote, LeavesARejectedModelToItsReasons) {
  AcceptanceLimits limits;
  limits.min_validation_r2_percent = 99.9;
  const std::string note = lags_note_on(model_with_lags(0.9, 0.5, 1e-6), limits);
  EXPECT_NE(note.find("its reasons say"), std::string::npos) << note;
}

}  // namespace
}  // namespace eha::ident
