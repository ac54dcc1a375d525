// SPDX-License-Identifier: GPL-3.0-or-later
// What lowers the grade of a model that no limit rejects, and how it is said.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "ident/fractional/stability.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

TEST(Verdict, GradesAModelWhoseResidualTellsSomethingAsUsable) {
  Model model = good_model();
  // Single lags out of their bounds and colour say nothing: the joint tests do.
  model.validation->ccf.values = {0.9, 0.5, 0.3, -0.4};
  model.validation->ljung_box_p = 1e-5;
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  model.validation->tests->input.p = 0.009;
  model.validation->tests->whiteness.p = 1e-5;
  const Verdict verdict = judge(model, AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  EXPECT_EQ(verdict.grade, Grade::usable);
  Model resting = model;
  resting.transfer_function = {{{1.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  resting.estimation->compared_step_s = 0.02;
  const Verdict beside = judge(resting, AcceptanceLimits{}, {.beside_ladder = true});
  EXPECT_TRUE(beside.beside_ladder);
  EXPECT_NE(beside.reasons.front().find("try more poles (`eha fit --model io --poles 5"), std::string::npos)
      << beside.reasons.front();
  EXPECT_EQ(beside.reasons.front().find("--input-map"), std::string::npos) << "which the ladder has tried";
  Model clipped = model;
  clipped.validation->saturated_percent = 5.0;
  EXPECT_EQ(judge(clipped, {}).reasons.front().rfind("Sensor or actuator saturate", 0), 0U)
      << "what explains the others comes first";
  EXPECT_EQ(verdict.reasons,
            (std::vector<std::string>{
                "A part of the plant may be missing: the input still moves what the model leaves over (p = 0.009, lags "
                "up to 20); try the valve map (--input-map valve), or ignore it "
                "where an error of 0.1 in (rms) "
                "does not matter."}))
      << "what past input moves is no plain noise either";
  model.validation->tests->input.p = 0.5;
  EXPECT_EQ(judge(model, {}).reasons,
            (std::vector<std::string>{
                "Something that is not the input moves the output, such as a load, hum or vibration: what the model "
                "leaves over is no plain noise (p = 1e-05 for lags 1 to 20); ignore it where an error "
                "of 0.1 in (rms) does not matter, else record longer."}));
}

TEST(Verdict, RejectsAPieceOfAMotionWhoseErrorNothingJudges) {
  const RecordFacts piece{.piece = RecordFacts::Piece{5.0, 38.0}};
  Model model = good_model();
  EXPECT_EQ(judge(model, {}, piece).grade, Grade::good) << "its tests judge it";
  model.validation->tests.reset();
  EXPECT_EQ(judge(model, {}).grade, Grade::usable);
  const Verdict verdict = judge(model, {}, piece);
  EXPECT_EQ(verdict.grade, Grade::rejected);
  EXPECT_EQ(verdict.word, kNotDetermined);
  EXPECT_EQ(verdict.reasons.front(),
            "Too short to judge: 5 s, record at least 38 s; other models follow such a piece of the input's motion as "
            "well, with another gain.");
}

TEST(Verdict, RejectsAModelOfASmallPartOfARunThatEndedEarlyWhateverItsTestsSay) {
  const RecordFacts part{.piece = RecordFacts::Piece{3.0, 12.7, true}};
  const Verdict verdict = judge(good_model(), {}, part);
  EXPECT_EQ(verdict.grade, Grade::rejected);
  EXPECT_TRUE(verdict.reasons.front().starts_with("Too short to judge: 3 s, record at least 12.7 s"));
}

TEST(Verdict, NamesTheEffectThatTheModelsOwnRecordShowsBesideThatOfAnotherOne) {
  Model model = good_model();
  NonlinearityTest test{.test = {.statistic = 60.0, .degrees = 9, .p = 1e-6}};
  model.validation->tests->nonlinearity = test;
  test.kind = NonlinearKind::motion;
  model.provenance[kEffectOnOwnRecord] = std::string(effect_of(test));
  const std::string reason = judge(model, {}).reasons.front();
  EXPECT_NE(
      reason.find(
          "or, as its own record has it, on the direction of motion, for instance with dry friction or play (p ="),
      std::string::npos)
      << reason;
}

TEST(Verdict, NamesBothEffectsThatTheRecordDoesNotTellApart) {
  Model model = good_model();
  NonlinearityTest test{.test = {.statistic = 60.0, .degrees = 9, .p = 1e-6}, .kind = NonlinearKind::motion};
  test.or_kind = NonlinearKind::direction;
  model.validation->tests->nonlinearity = test;
  const std::string reason = judge(model, {}).reasons.front();
  EXPECT_NE(
      reason.find(
          "depends on the direction of motion, for instance with dry friction or play, or on the direction of the "
          "input, for instance with play, hysteresis or a limited rate, which this record does not tell apart (p ="),
      std::string::npos)
      << reason;
}

TEST(Verdict, OffersADeadTimeForALagThatWasFittedWithoutOne) {
  Model model = good_model();
  model.transfer_function = {{{0.06, 0.0}}, {{0.018, 0.0}, {1.0, 1.0}}, 0.0};
  model.estimation->compared_step_s = 1.0;
  model.estimation->score.samples = 3600;
  model.validation->tests->input.p = 0.009;
  const auto first = [&](const RecordFacts& facts = {}) { return judge(model, {}, facts).reasons.front(); };
  EXPECT_NE(first().find("; let a dead time be estimated (--delay free), or try the valve map"), std::string::npos)
      << first();
  model.input_map.emplace();
  EXPECT_EQ(first().find("valve map"), std::string::npos) << first();
  model.input_map.reset();
  EXPECT_EQ(first({.beside_ladder = true}).find("--delay"), std::string::npos) << "which the ladder has tried";
  model.parameters.push_back({"delay_s", 0.0, 0.1, 0.0, 0.2, false, ParameterRole::delay});
  EXPECT_EQ(first().find("--delay"), std::string::npos) << "it was estimated";
  model.parameters.clear();
  model.transfer_function.denominator.front().coefficient = 1e-5;
  EXPECT_EQ(first().find("--delay"), std::string::npos) << "an integrator";
}

const Criterion& criterion_of(const Verdict& verdict, const std::string& name) {
  return *std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                       [&](const auto& c) { return name_of(c) == name; });
}

TEST(Verdict, DoesNotJudgeResidualsByTooFewSamples) {
  Model model = good_model();
  model.validation->score.samples = 60;
  Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "residual_input_p").judged);
  EXPECT_FALSE(criterion_of(verdict, "residual_whiteness_p").judged);
  EXPECT_TRUE(needs_longer_record(verdict));
  EXPECT_TRUE(may_miss_a_part(verdict));
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("with 60 validating samples the test would more likely miss"), std::string::npos);
  // What it shows all the same, it shows.
  model.validation->tests->input.p = 0.001;
  verdict = judge(model, {});
  EXPECT_TRUE(criterion_of(verdict, "residual_input_p").judged);
  EXPECT_NE(verdict.reasons[0].find("still moves what the model leaves over"), std::string::npos);
  model.validation->tests.reset();
  verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "residual_whiteness_p").judged);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("are too few for the residual's tests"), std::string::npos);
}

TEST(Verdict, DoesNotJudgeAPlantThatTheInputHardlyMoves) {
  Model model = good_model();
  model.validation->tests->nonlinearity = NonlinearityTest{{20.0, 21, 0.5}, NonlinearKind::level};
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  EXPECT_FALSE(may_miss_a_part(judge(model, {})));
  // A step or two: 40 of the 500 samples show an answer.
  model.validation->tests->moved = 40;
  const Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "residual_input_p").judged);
  EXPECT_FALSE(criterion_of(verdict, "nonlinearity_p").judged);
  EXPECT_TRUE(criterion_of(verdict, "residual_whiteness_p").passed) << "which needs no move of the input";
  ASSERT_EQ(verdict.reasons.size(), 1U) << "one sentence for one cause";
  EXPECT_NE(verdict.reasons[0].find(
                "within 20 samples the input covers 2 % of its range for only 40 of the 500 validating ones"),
            std::string::npos)
      << verdict.reasons[0];
}

TEST(Verdict, SaysWhatTheTestsCanSeeWhereTheGradeMayPuzzle) {
  Model noisy = good_model();
  noisy.validation->tests->error = PredictedError{0.0, 2.0};
  EXPECT_NE(sight_of(noisy, judge(noisy, {})).find("an error of up to 2 %"), std::string::npos);
  noisy.validation->tests->error = PredictedError{0.0, 0.1};
  EXPECT_EQ(sight_of(noisy, judge(noisy, {})), "");
  Model clean = noisy;
  clean.validation->tests->input.p = 1e-5;
  EXPECT_NE(sight_of(clean, judge(clean, {})).find("beside the noise of this record an error of at most 0.1 %"),
            std::string::npos);
  clean.validation->tests->error = PredictedError{3.0, 4.0};
  EXPECT_EQ(sight_of(clean, judge(clean, {})), "") << "an error that matters on any record";
}

TEST(Verdict, DoesNotJudgeAnErrorWhoseNoiseIsNotKnown) {
  EXPECT_EQ(judge(good_model(), {}).grade, Grade::good) << "an excitation that does not repeat";
  const Verdict verdict = judge(good_model(), {}, {.lacks_periods = true});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "error_over_noise").judged);
  EXPECT_NE(verdict.reasons.at(0).find("too few periods"), std::string::npos);
}

TEST(Verdict, RejectsAnErrorFarAboveTheNoiseUnlessTheFitIsClose) {
  Model model = good_model();
  model.validation->score.mse = 0.04;
  model.validation->score.fit_percent = 94.0;
  EXPECT_EQ(judge(model, {}, {.noise_std = 0.019}).grade, Grade::rejected);
  EXPECT_EQ(judge(model, {}, {.noise_std = 0.021}).grade, Grade::usable);
  model.validation->score.fit_percent = 96.0;
  const Verdict close = judge(model, {}, {.noise_std = 0.019});
  EXPECT_EQ(close.grade, Grade::usable);
  // Beside another rejection nothing keeps it.
  model.stability.reset();
  const Verdict rejected = judge(model, {}, {.noise_std = 0.019});
  EXPECT_EQ(rejected.grade, Grade::rejected);
  for (const std::string& reason : rejected.reasons) {
    EXPECT_EQ(reason.find("keeps this alone"), std::string::npos) << reason;
  }
  EXPECT_NE(close.reasons.front().find(
                "a fit of 96 % keeps this alone from rejecting it, but expect the output up to 0.2 in from "
                "where the model puts it; try"),
            std::string::npos)
      << close.reasons.front();
}

TEST(Verdict, IsNotGoodWhereTheErrorJumps) {
  Model model = good_model();
  model.estimation->compared_step_s = 0.02;
  model.validation->jump = ErrorJump{129.98, -7.2, 0.5};
  const Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  const Criterion& jump = criterion_of(verdict, "error_jump");
  EXPECT_TRUE(has_failed(jump));
  EXPECT_EQ(jump.value, 7.2);
  EXPECT_EQ(jump.limit, 0.5);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("cut with --to 129.9 or --from 130.06."), std::string::npos) << verdict.reasons[0];
  model.validation->jump->estimating = true;
  const Verdict wrong = judge(model, {});
  EXPECT_EQ(wrong.grade, Grade::rejected) << "the parameters are wrong by it";
  EXPECT_EQ(wrong.reasons, verdict.reasons) << "the jump is the reason";
  const double spread = std::sqrt(model.validation->score.mse / (1.0 - 0.01 * model.validation->score.r2_percent));
  model.validation->jump->change = -0.09 * spread;
  EXPECT_EQ(judge(model, {}).grade, Grade::usable) << "little of the output's motion";
}

TEST(Verdict, LowersTheGradeOfARecordInClosedLoopWithTestsOrWithout) {
  Model tested = good_model();
  tested.provenance[kLoopOfRecord] = "-0.70";
  Model untested = tested;
  untested.validation->tests.reset();
  Model of_noisy_input = tested;
  of_noisy_input.validation->input_noise = InputNoise{};
  Model without_validation = tested;
  without_validation.validation.reset();
  for (const Model& model : {tested, untested, of_noisy_input, without_validation}) {
    const Verdict verdict = judge(model, {});
    EXPECT_EQ(verdict.grade, Grade::usable);
    EXPECT_FALSE(criterion_of(verdict, "future_input_p").passed);
    EXPECT_NE(verdict.reasons.at(0).find("A controller closes the loop"), std::string::npos) << verdict.reasons[0];
    for (std::size_t i = 1; i < verdict.reasons.size(); ++i) {
      EXPECT_EQ(verdict.reasons[i].find("The output moves the input"), std::string::npos) << verdict.reasons[i];
    }
  }
}

TEST(Verdict, GradesByTheErrorOnAFreshInput) {
  Model model = good_model();
  ResidualTests& tests = model.validation->tests.value();
  tests.error = PredictedError{0.5, 4.9};
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  tests.error = PredictedError{5.1, 8.0};
  EXPECT_FALSE(criterion_of(judge(model, {}), "predicted_error_percent").passed);
  tests.error = PredictedError{0.5, 8.0};
  const Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "predicted_error_percent").judged);
}

TEST(Verdict, SaysThatTwoLevelsTellNothingOfOtherAmplitudes) {
  Model model = good_model();
  model.validation->input_levels = InputLevels{-1.5, 1.5};
  Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_EQ(verdict.reasons.at(0),
            "Good for inputs of +-1.5 V as recorded; no statement about other amplitudes: play more levels.");
  model.validation->input_levels = InputLevels{0.0, 2.0};
  model.validation->extrapolated_percent = 100.0;
  verdict = judge(model, {});
  EXPECT_EQ(verdict.reasons.at(0),
            "Judged for inputs of 0 and 2 V as recorded; no statement about other amplitudes: play more levels.");
}

TEST(Verdict, GradesExtrapolationAsUsable) {
  Model model = good_model();
  model.validation->extrapolated_percent = 5.1;
  EXPECT_EQ(judge(model, {}).grade, Grade::usable);
}

/// What is wrong, the figure, what to do.
TEST(Verdict, SaysThreeThingsOfEveryCriterion) {
  Model model = good_model();
  model.parameters = {{.name = "n2", .value = 1.5, .std = 0.25, .lower95 = 1.0, .upper95 = 2.0}};
  model.validation->tests->nonlinearity = NonlinearityTest{{40.0, 9, 1e-5}, NonlinearKind::motion};
  model.validation->tests->error = PredictedError{6.0, 8.0};
  model.validation->input_levels = InputLevels{-1.5, 1.5};
  for (const CriterionTraits& traits : criterion_kinds()) {
    if (traits.kind == CriterionKind::other) continue;
    const Criterion failed{.kind = traits.kind, .parameter = "n2", .value = 0.25, .limit = 0.15};
    Criterion unknown = failed;
    unknown.judged = false;
    for (const Criterion& criterion : {failed, unknown}) {
      const std::vector<std::string> reasons = reasons_of(model, Verdict{.criteria = {criterion}});
      if (reasons.empty()) continue;  // of one that is always judged, or never fails
      const std::string& reason = reasons.front();
      EXPECT_NE(reason.find(": "), std::string::npos) << reason;
      EXPECT_TRUE(std::any_of(reason.begin(), reason.end(), [](char c) { return c >= '0' && c <= '9'; })) << reason;
      const bool has_remedy = reason.find("; ") != std::string::npos || reason.find(": play more") != std::string::npos;
      EXPECT_TRUE(has_remedy) << reason;
    }
  }
}

TEST(Verdict, TakesNoOutputForDeadThatAnsweredInThePartThatEstimated) {
  Model model = good_model();
  model.validation->score.r2_percent = -120.0;
  model.estimation->score.r2_percent = 99.0;
  EXPECT_EQ(judge(model, {}).reasons.front().find("hardly answers"), std::string::npos);
  model.estimation->score.r2_percent = 2.0;
  EXPECT_EQ(judge(model, {}).reasons.front().rfind("The output hardly answers to the input: ", 0), 0U);
  // A plant that comes to rest is followed by no rod with friction, however well it answers.
  model.grey_box = GreyBox{grey_box_kinds().front(), {}};
  EXPECT_EQ(judge(model, {}).reasons.front().rfind("This structure does not follow the record: ", 0), 0U);
}

TEST(Verdict, JudgesAModelWithoutValidationByItsEstimationAndSaysSo) {
  Model model = good_model();
  model.validation.reset();
  const Verdict verdict = judge(model, AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("Nothing was kept for validation"), std::string::npos);
  EXPECT_EQ(verdict.grade, Grade::usable);
  const Verdict at_rest = judge(model, {}, {.judging_part_rests = true});
  EXPECT_EQ(at_rest.grade, Grade::usable);
  EXPECT_EQ(at_rest.reasons[0].rfind("The input does not move in the part that would judge", 0), 0U);
  model.estimation->score.r2_percent = 50.0;
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  model.estimation.reset();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
}

TEST(Verdict, NamesAGapOfTheRecordBeforeWhatItDoesToTheError) {
  Model model = good_model();
  model.provenance[kGapsOfRecord] = "from 42 to 42.29 s";
  model.provenance[kWithoutGaps] = "--to 41.99";
  EXPECT_EQ(judge(model, {}).reasons, judge(good_model(), {}).reasons) << "it does no harm here";
  model.validation->score.r2_percent = 51.8;
  const std::vector<std::string> reasons = judge(model, {}).reasons;
  ASSERT_GE(reasons.size(), 2U);
  EXPECT_EQ(
      reasons.front(),
      "Rows are missing from 42 to 42.29 s, and what the input did there is not known, so that an integrating rod "
      "stands elsewhere afterwards; cut with --to 41.99.");
  model.transfer_function = {{{1.0, 0.0}}, {{1.0, 1.0}, {1.0, 0.0}}, 0.0};
  model.estimation->compared_step_s = 0.1;
  EXPECT_EQ(judge(model, {}).reasons.front(),
            "Rows are missing from 42 to 42.29 s, and what the input did there is not known, so that the output moves "
            "otherwise for some time afterwards; cut with --to 41.99.")
      << "a lag comes to rest again";
}

}  // namespace
}  // namespace eha::ident
