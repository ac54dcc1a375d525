// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/first_step.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

/// A judged model of this name.
Model judged(Model model) {
  model.name = "io";
  model.verdict = judge(model, {});
  return model;
}

Model at_a_stop() {
  Model model = good_model();
  model.validation->end_stop = EndStop{.level = 5.7, .from_s = 28.0, .percent = 1.4, .clean_to_s = 27.68};
  return model;
}

/// A model of a record whose output is noise alone.
Model of_noise() {
  Model model = good_model();
  model.estimation->score.r2_percent = 0.2;
  model.validation->score.r2_percent = -0.6;
  return model;
}

TEST(NextStep, CutsBeforeItRecordsLonger) {
  Model model = at_a_stop();
  model.validation->tests = ResidualTests{1, {20.0, 21, 0.5}, {19.0, 19, 0.5}};
  model.validation->score.samples = 12;  // too few to judge
  model = judged(model);
  ASSERT_TRUE(needs_longer_record(*model.verdict));
  const NextStep next = next_step({&model}, "io");
  EXPECT_EQ(next.first, FirstStep::cut);
  EXPECT_EQ(next.cut_options, "--to 27.68");
  model.validation->end_stop.reset();
  model = judged(model);
  EXPECT_EQ(next_step({&model}, "io").first, FirstStep::longer_record);
  model.validation->saturated_percent = 3.0;
  model = judged(model);
  EXPECT_EQ(next_step({&model}, "io").first, FirstStep::smaller_amplitude);
  model.provenance[kCutOfRecord] = "--from 3";
  EXPECT_EQ(next_step({&model}, "io").cut_options, "--from 3") << "as the record's remarks have it";
  model.provenance.clear();
  model.validation->saturated_percent.reset();
  model.validation->jump = ErrorJump{.time_s = 2.0, .change = 0.3};
  model = judged(model);
  EXPECT_EQ(next_step({&model}, "io").first, FirstStep::cut);
  model.provenance[kLongerPart] = "--from 2.1";
  EXPECT_EQ(next_step({&model}, "io").cut_options, "--from 2.1");
}

TEST(NextStep, LooksAtTheComputerWhereARunLostTicksAndRecordsNoLonger) {
  Model model = good_model();
  model.name = "io";
  model.verdict = judge(model, {}, {.unmeasured = {.rows = 20, .without_input = 20, .in_gaps = 19, .of_rows = 1000}});
  ASSERT_FALSE(model.verdict->accepted);
  EXPECT_EQ(next_step({&model}, "").first, FirstStep::none) << "of a file";
  model.provenance[kAgainstLostRows] = kAgainstLateTicks;
  EXPECT_EQ(next_step({&model}, "").first, FirstStep::against_lost_rows);
  model.verdict = judge(model, {});
  EXPECT_EQ(next_step({&model}, "io").first, FirstStep::none) << "so few lost rows that no check fails";
}

TEST(NextStep, KeepsTheLongerPartBesideAChangeOfTheGain) {
  Model model = good_model();
  model.name = "io";
  model.provenance[kGainChanged] = "at about 34.2 s, by a factor of 1.6";
  model.provenance[kLongerPart] = "--to 33.3";
  Model worse = good_model();  // shows no change, as it follows nothing
  worse.name = "fo";
  worse.validation->score.mse = 40.0;
  for (const char* recommended : {"", "io"}) {
    const NextStep next = next_step({&worse, &model}, recommended);
    EXPECT_EQ(next.first, FirstStep::cut);
    EXPECT_EQ(next.cut_options, "--to 33.3");
  }
  EXPECT_EQ(next_step({&worse}, "").first, FirstStep::none);
}

/// A model of a record in whose second part the sensor froze.
Model with_frozen_sensor() {
  Model model = good_model();
  model.provenance[kFrozenOfRecord] = "from 30 to 49.98 s";
  model.provenance[kWithoutFrozen] = "--to 29.98";
  return model;
}

TEST(NextStep, CutsAwayWhereASensorFroze) {
  Model model = with_frozen_sensor();
  EXPECT_EQ(judged(model).verdict->reasons, judged(good_model()).verdict->reasons) << "it does no harm here";
  EXPECT_EQ(next_step({&model}, "").first, FirstStep::none);
  model.validation->score.r2_percent = -8796.0;
  model.validation->tests->input.p = 1e-9;
  model.validation->tests->whiteness.p = 1e-9;
  model.validation->jump = ErrorJump{.time_s = 30.0, .change = 0.3};
  model = judged(model);
  const NextStep next = next_step({&model}, "");
  EXPECT_EQ(next.first, FirstStep::cut);
  EXPECT_EQ(next.cut_options, "--to 29.98");
  const std::vector<std::string>& reasons = model.verdict->reasons;
  ASSERT_EQ(reasons.size(), 2U) << "what is left over shows the sensor";
  EXPECT_EQ(reasons[0],
            "The sensor froze from 30 to 49.98 s: the output kept one value to the last digit while the input moved, "
            "and no model follows that; cut with --to 29.98.");
  EXPECT_TRUE(reasons[1].ends_with("; cut as said above, and fit again.")) << reasons[1];
}

TEST(Verdict, NamesAFrozenSensorWithoutAValidationToo) {
  Model model = with_frozen_sensor();
  model.validation.reset();
  model.estimation->score.r2_percent = 50.0;
  EXPECT_EQ(judged(model).verdict->reasons.front().rfind("The sensor froze from 30", 0), 0U);
}

TEST(Verdict, AsksForGreaterAmplitudesWhereTheInputHardlyLeavesTheDeadBand) {
  const std::string reach = "the volts went 0.22 V from the valve's null, of which its dead band takes 0.2 V";
  Model model = good_model();
  model.provenance[kWithinDeadBand] = reach;
  model.validation->tests->input.p = 1e-5;
  model.validation->saturated_percent = 3.0;
  model.name = "io";
  model.verdict = judge(model, {}, {.beside_ladder = true});
  std::string all;
  for (const std::string& reason : model.verdict->reasons) all += reason + "\n";
  EXPECT_EQ(all.find("smaller amplitudes"), std::string::npos) << all;
  EXPECT_NE(all.find("; record greater amplitudes, as " + reach), std::string::npos) << all;
  EXPECT_NE(next_step({&model}, "").first, FirstStep::smaller_amplitude);
}

TEST(NextStep, IsNoneForAGoodModelAndAnotherModelsStop) {
  const Model good = judged(good_model());
  EXPECT_EQ(next_step({&good}, "io").first, FirstStep::none);
  Model other = judged(at_a_stop());
  other.name = "fo";
  EXPECT_EQ(next_step({&good, &other}, "io").first, FirstStep::none);
  EXPECT_EQ(next_step({&good, &other}, "").first, FirstStep::cut) << "none is recommended";
}

TEST(NextStep, LooksAtASensorThatShowsNoiseAlone) {
  const Model model = judged(of_noise());
  EXPECT_EQ(next_step({&model}, "").first, FirstStep::look_at_sensor);
  ASSERT_EQ(model.verdict->reasons.size(), 1U) << "one statement";
  EXPECT_EQ(model.verdict->reasons[0].rfind("The sensor shows no motion", 0), 0U) << model.verdict->reasons[0];
  EXPECT_NE(model.verdict->reasons[0].find("`eha read`"), std::string::npos);
  Model answering = of_noise();
  answering.estimation->score.r2_percent = 40.0;
  EXPECT_FALSE(shows_no_motion(judged(answering), *judged(answering).verdict));
  Model wandering = of_noise();
  wandering.validation->ljung_box_p = 1e-9;
  EXPECT_FALSE(shows_no_motion(judged(wandering), *judged(wandering).verdict)) << "the output moves of itself";
}

TEST(Verdict, AddsNothingElseThatMovesTheOutputToANamedEndStop) {
  const auto says_something = [](const Model& model) {
    const Model one = judged(model);
    return std::any_of(one.verdict->reasons.begin(), one.verdict->reasons.end(), [](const std::string& reason) {
      return reason.rfind("Something that is not the input", 0) == 0;
    });
  };
  Model model = good_model();
  model.validation->tests = ResidualTests{1, {20.0, 21, 0.5}, {190.0, 19, 1e-9}};
  EXPECT_TRUE(says_something(model));
  model.validation->end_stop = EndStop{.level = 5.7, .from_s = 28.0, .percent = 1.4, .clean_to_s = 27.68};
  EXPECT_FALSE(says_something(model)) << "the stop explains it";
  model.validation->end_stop.reset();
  model.validation->saturated_percent = 3.0;
  EXPECT_FALSE(says_something(model)) << "the saturation explains it";
}

}  // namespace
}  // namespace eha::ident
