// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict.hpp"

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
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

TEST(Verdict, AcceptsWithoutAWordWhatMeetsEveryLimit) {
  const Verdict verdict = judge(good_model(), AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  EXPECT_EQ(verdict.grade, Grade::good);
  EXPECT_TRUE(verdict.reasons.empty());
  for (const Criterion& c : verdict.criteria) EXPECT_TRUE(c.passed) << name_of(c);
}

TEST(Verdict, LowersWhatTheRecommendedModelClearlyBeats) {
  const auto beside = [](double gap) {
    return judge(good_model(), {}, {.recommended = RecordFacts::Recommended{"lag", gap}});
  };
  EXPECT_EQ(beside(9.9).grade, Grade::good);
  const Verdict beaten = beside(717.4);
  EXPECT_EQ(beaten.grade, Grade::usable);
  ASSERT_EQ(beaten.reasons.size(), 1U);
  EXPECT_NE(beaten.reasons.front().find("AR-BIC of lag is 717 lower"), std::string::npos) << beaten.reasons.front();
}

TEST(Verdict, RejectsWhatWasFittedToARodAtItsEnd) {
  Model model = good_model();
  model.validation->end_stop = EndStop{.level = 72.7, .from_s = 1.0, .percent = 4.9};
  EXPECT_TRUE(judge(model, {}).accepted);
  model.validation->end_stop->percent = 0.3;
  EXPECT_EQ(judge(model, {}).grade, Grade::usable) << "however few the samples";
  model.validation->end_stop->clean_to_s = 0.9;
  EXPECT_FALSE(judge(model, {}).accepted) << "the fit of the part without counts";
  model.validation->end_stop->clean_to_s.reset();
  model.validation->end_stop->percent = 30.0;
  EXPECT_FALSE(judge(model, {}).accepted);
  model.validation->end_stop.reset();
  model.validation->saturated_percent = 5.1;
  EXPECT_FALSE(judge(model, {}).accepted);
}

TEST(Verdict, RejectsARecordOfWhichTooLittleWasMeasured) {
  const auto lacking = [](std::size_t rows, std::size_t in_gaps) {
    return RecordFacts{.unmeasured = {.rows = rows, .without_input = rows, .in_gaps = in_gaps, .of_rows = 1000}};
  };
  EXPECT_TRUE(judge(good_model(), {}, lacking(100, 10)).accepted);
  const Verdict verdict = judge(good_model(), {}, lacking(151, 0));
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict.reasons.front(),
            "Too little of the record was measured: 15.1 % of its rows lack a value, more than 10 %; cut with --from "
            "and --to to a part that lacks fewer, or record again.");
  const Verdict gaps = judge(good_model(), {}, lacking(80, 11));
  EXPECT_FALSE(gaps.accepted);
  EXPECT_EQ(gaps.reasons.front(),
            "Part of the record was not measured: 1.1 % of its rows are interpolated in gaps, more than 1 %; cut with "
            "--from and --to to a part that was, or record again.");
  Model of_run = good_model();
  of_run.provenance[kAgainstLostRows] = kAgainstLateTicks;
  EXPECT_EQ(judge(of_run, {}, lacking(80, 11)).reasons.front(),
            "Part of the record was not measured: 1.1 % of its rows are interpolated in gaps, more than 1 %; `eha "
            "doctor` and `eha latency --load` say what makes ticks late or loses them; then record again.");
  Model paper = good_model();
  paper.procedure = "paper";
  EXPECT_FALSE(judge(paper, {}, lacking(80, 0)).accepted) << "it takes interpolated rows for measured ones";
}

TEST(Verdict, RejectsAnIntegratingRodWhoseErrorShowsBesideAGap) {
  const RecordFacts facts{.unmeasured = {.rows = 6, .without_input = 6, .in_gaps = 6, .of_rows = 1000}};
  Model model = good_model();
  model.transfer_function.denominator = {{1.0, 2.0}, {1.0, 1.0}};
  model.provenance[kGapsOfRecord] = "from 15 to 15.29 s";
  model.provenance[kWithoutGaps] = "--from 15.3";
  EXPECT_TRUE(judge(model, {}, facts).accepted) << "a gap in which nothing happened";
  model.validation->tests->input.p = 1e-6;
  const Verdict verdict = judge(model, {}, facts);
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(
      verdict.reasons.front(),
      "Rows are missing from 15 to 15.29 s, and what the input did there is not known, so that an integrating rod "
      "stands elsewhere afterwards; cut with --from 15.3.");
}

TEST(Verdict, RejectsAMapThatTurnsBack) {
  Model model = good_model();
  model.estimation->correlation.emplace();
  model.parameters = {{"negative_gain_ratio", 0.8, 0.1, 0.6, 1.0, false, ParameterRole::negative_gain_ratio}};
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  ParameterEstimate& ratio = model.parameters.front();
  ratio.value = -0.04;  // a valve that acts to one side, beside noise
  EXPECT_TRUE(judge(model, {}).accepted);
  // However little the record determines it: the map that the model has is none of a valve.
  ratio.value = -1.38;
  ratio.upper95 = std::numeric_limits<double>::infinity();
  const Verdict verdict = judge(model, {});
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict_word(verdict), "rejected");
  EXPECT_EQ(verdict.reasons.front(),
            "The map is no valve's: its gain below the dead band is -1.38 times that above, so more volts to one side "
            "would turn the motion round; use the model without the map, or record both sides of the valve.");
  EXPECT_EQ(criterion_named("gain_ratio").kind, CriterionKind::gain_ratio);
  ratio.fixed = true;  // somebody's wish
  EXPECT_TRUE(judge(model, {}).accepted);
}

TEST(Verdict, LowersWhatErrsMoreThanTheMeasuredNoise) {
  Model model = good_model();
  model.validation->score.mse = 0.04;
  EXPECT_EQ(judge(model, {}, {.noise_std = 0.07}).grade, Grade::good);
  const Verdict verdict = judge(model, {}, {.noise_std = 0.05});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_EQ(
      verdict.reasons.front(),
      "The model misses a part of the plant: its validation error of 0.2 in (rms) is 4 times the noise of 0.05 in "
      "that differs between the record's periods, more than 3; try the valve map (--input-map valve), or ignore "
      "it where an error of 0.2 in (rms) does not matter.");
  EXPECT_EQ(judge(model, {}).grade, Grade::good) << "without a measured noise nothing is compared";
}

TEST(Verdict, NamesALimitOnTheGreatestErrorThatTheNoiseAloneExceeds) {
  Model model = good_model();
  model.validation->score.mse = 0.0049;
  model.validation->score.error_max = 0.2;
  AcceptanceLimits limits;
  limits.max_abs_error = 0.1;
  const std::string reason = judge(model, limits, {.noise_std = 0.05}).reasons.front();
  EXPECT_NE(reason.find("No model can keep the limit on the greatest error, 0.1 in: the noise alone, 0.05 in (rms)"),
            std::string::npos)
      << reason;
  EXPECT_EQ(
      judge(model, limits, {.noise_std = 0.025}).reasons.front().rfind("The model is too far off at one place", 0), 0U);
}

TEST(Verdict, LowersWhatErrsFarMoreOnUnseenDataThanWhereItWasEstimated) {
  Model model = good_model();
  model.estimation->score.mse = 0.0001;
  model.validation->score.mse = 0.0049;
  const Verdict verdict = judge(model, {}, {.holds_both_parts = true});
  EXPECT_EQ(verdict.grade, Grade::usable);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_EQ(verdict.reasons.front(),
            "The model errs more on unseen data than where it was estimated: 0.07 in (rms) there, 7 times the 0.01 in "
            "here, more than 3; record longer, and hold the model against another record (`eha validate`) before it is "
            "relied on.");
  EXPECT_EQ(judge(model, {}).grade, Grade::good) << "another record may move as much more";
  model.validation->score.fit_percent = 99.0;
  EXPECT_EQ(judge(model, {}, {.holds_both_parts = true}).grade, Grade::usable) << "of every model alike";
  model.validation->score.fit_percent = 99.9;
  EXPECT_EQ(judge(model, {}, {.holds_both_parts = true}).grade, Grade::good) << "a small error is no matter";
  model.validation->score.fit_percent = 88.0;
  model.validation->score.mse = 0.0008;
  EXPECT_EQ(judge(model, {}, {.holds_both_parts = true}).grade, Grade::good);
}

TEST(Verdict, SaysNothingOfAnUnjudgedPartOfThePlantWhereTheNoiseShowsIt) {
  Model model = good_model();
  model.validation->tests.reset();
  model.validation->score.mse = 0.04;
  const auto says = [](const Verdict& verdict, const char* text) {
    return std::any_of(verdict.reasons.begin(), verdict.reasons.end(),
                       [&](const std::string& reason) { return reason.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(says(judge(model, {}), "Not judged whether the model misses a part"));
  const Verdict missed = judge(model, {}, {.noise_std = 0.05});
  EXPECT_TRUE(says(missed, "The model misses a part of the plant"));
  EXPECT_FALSE(says(missed, "Not judged whether the model misses a part"));
}

TEST(Verdict, NotesAPoleAndAZeroThatNearlyCancel) {
  Model model = good_model();
  // (0.17 s + 1) / (s (0.156 s + 1) (0.01 s + 1))
  model.transfer_function = {{{0.17, 1.0}, {1.0, 0.0}}, {{0.00156, 3.0}, {0.166, 2.0}, {1.0, 1.0}}, 0.0};
  model.stability = stability_beside_integrator(model.transfer_function);
  const Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::good) << "a note";
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_EQ(verdict.reasons.front(),
            "A pole and a zero nearly cancel: T = 0.156 s and TD = 0.17 s together change the response by at most 9 %; "
            "take them for a small correction of the fit, not for time constants of the rig.");
  model.transfer_function.numerator.front().coefficient = 0.3;
  EXPECT_TRUE(judge(model, {}).reasons.empty());
}

TEST(Verdict, RejectsWithEveryReasonAtOnceGivingValueAndLimit) {
  Model model = good_model();
  model.estimation->converged = false;
  model.estimation->termination = "evaluation limit";
  model.validation->score.r2_percent = 85.1234;
  model.validation->offset_reestimated = Score{91.2, 0, 0, 0, 0, 500};
  model.validation->score.error_min = -0.75;
  model.stability = StabilityReport{false, "argument_principle", -0.25};
  AcceptanceLimits limits;
  limits.max_abs_error = 0.5;
  const Verdict verdict = judge(model, limits);
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(
      verdict.reasons,
      (std::vector<std::string>{
          // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): sentences of two lines
          "The search found no best parameters: after 20 evaluations it ended with \"evaluation limit\"; fit a simpler "
          "model, or record longer.",
          "The model does not follow the record: the validation R2 of 85.12 % is below the limit of 90 %; look at the "
          "error over time, and try "
          "the valve map (--input-map valve).",
          "The model is too far off at one place: the greatest validation error of 0.75 in is above the limit of 0.5 "
          "in; look there in the report, and cut a disturbance with --from or --to.",
          "The model is unstable (test: argument_principle, margin -0.25 rad), and the limits require a stable one; "
          "record longer, or fit a simpler model.",
          "Input and output may be exchanged, or a controller closes the loop: the residual correlates with future "
          "input more than with past input; check --input and --output, or record in open loop.",
          "The error of the validation part is mostly an offset: with one estimated anew there R2 is 91.20 %; the "
          "sensor, the null or the oil's temperature may have drifted between the two parts: record when the oil "
          "is warm, or shorter."}));
}

TEST(Verdict, SaysHowAnIntegratingModelIsAccepted) {
  Model model = good_model();
  model.transfer_function.numerator = {{1.0, 0.0}};
  model.transfer_function.denominator = {{1.0, 2.0}, {0.5, 1.0}, {0.0, 0.0}};
  model.stability = StabilityReport{false, "matignon", 0.0};
  EXPECT_FALSE(judge(model, {}).accepted);
  EXPECT_NE(judge(model, {}).reasons.front().find("require_stable = false"), std::string::npos);
  AcceptanceLimits limits;
  limits.require_stable = false;
  EXPECT_TRUE(judge(model, limits).accepted);
  // With another pole in the right half plane the model is not a mere integrator.
  model.transfer_function.denominator = {{1.0, 2.0}, {-1.0, 1.0}};
  EXPECT_NE(judge(model, {}).reasons.front().find("unstable"), std::string::npos);
}

TEST(Verdict, AcceptsAPoleAt0ThatTheStructureDeclares) {
  Model model = good_model();
  model.transfer_function = {{{1.0, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  model.stability = stability_beside_integrator(model.transfer_function);
  EXPECT_EQ(model.stability->integrator_order, 1.0);
  EXPECT_NEAR(model.stability->margin_rad, 0.5 * std::numbers::pi, 1e-12);
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  // Not with another pole that grows, or at 0.
  model.transfer_function.denominator = {{0.1, 2.0}, {-1.0, 1.0}};
  model.stability = stability_beside_integrator(model.transfer_function);
  EXPECT_FALSE(judge(model, {}).accepted);
}

TEST(Verdict, AcceptsAFlatRidgeWithANote) {
  Model model = good_model();
  model.estimation->termination = std::string(text(Termination::flat_ridge));
  const Verdict verdict = judge(model, {});
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("flat along a ridge"), std::string::npos);
}

TEST(Verdict, RejectsAMarginBelowItsLimitAndAStabilityNobodyDetermined) {
  Model model = good_model();
  AcceptanceLimits limits;
  limits.min_stability_margin_rad = 0.6;
  EXPECT_EQ(
      judge(model, limits).reasons,
      (std::vector<std::string>{"The model is nearly unstable: its stability margin of 0.5 rad is below the limit of "
                                "0.6 rad; record longer, or lower min_stability_margin_rad in [acceptance]."}));
  EXPECT_FALSE(judge(model, limits).accepted);
  model.stability.reset();
  EXPECT_EQ(
      judge(model, AcceptanceLimits{}).reasons,
      std::vector<std::string>{"The model's stability was not determined, and the limits require it; fit it again, "
                               "or allow it with require_stable = false in [acceptance]."});
}

TEST(Verdict, LetsAnUnstableModelPassOnlyWhereTheLimitsAllowItAndSaysSo) {
  Model model = good_model();
  model.stability = StabilityReport{false, "matignon", -0.1};
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  AcceptanceLimits limits;
  limits.require_stable = false;
  const Verdict verdict = judge(model, limits);
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
}

TEST(Verdict, DoesNotLetAFigureThatIsNotANumberPass) {
  Model model = good_model();
  model.validation->score.r2_percent = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  model = good_model();
  model.validation->score.error_max = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
}

}  // namespace
}  // namespace eha::ident
