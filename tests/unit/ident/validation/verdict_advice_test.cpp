// SPDX-License-Identifier: GPL-3.0-or-later
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

TEST(VerdictAdvice, AdvisesInWholeSentencesBesideALadder) {
  Model model = good_model();
  model.transfer_function = {{{1.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  model.estimation->compared_step_s = 0.02;
  model.validation->tests->input.p = 1e-5;
  const std::string reason = judge(model, {}, {.beside_ladder = true}).reasons.at(0);
  EXPECT_NE(reason.find("; as every structure of the ladder was tried, try more poles"), std::string::npos) << reason;
  // A plant that is not linear, too, though that shows less.
  model.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 30.0, .degrees = 6, .p = 1e-4}, NonlinearKind::motion};
  const std::string bent = judge(model, {}, {.beside_ladder = true}).reasons.at(0);
  EXPECT_NE(bent.find("; as every structure of the ladder was tried, record larger amplitudes"), std::string::npos)
      << bent;
}

TEST(VerdictAdvice, AdvisesNoSmallerAmplitudesWhereTheRodMovesWithinTheDeadBand) {
  Model model = good_model();
  model.validation->tests->input.p = 1e-5;
  model.input_unit = "V";
  model.input_map = ValveMap{.null = 0.0, .dead_band = 0.15, .negative_gain_ratio = 1.0};
  model.validation->map_error = 0.04;
  const std::string reason = judge(model, {}, {.beside_ladder = true}).reasons.at(0);
  EXPECT_EQ(reason.find("smaller amplitudes, where"), std::string::npos) << reason;
  EXPECT_NE(reason.find("eha characterise"), std::string::npos) << reason;
}

TEST(VerdictAdvice, NamesTheModelThatExplainsWhatThisOneLeavesOver) {
  Model model = good_model();
  model.validation->tests->input.p = 1e-5;
  const Verdict verdict = judge(model, {}, {.beside_ladder = true, .explained_by = "io1_valve"});
  EXPECT_EQ(verdict.explained_by, "io1_valve");
  const std::string& reason = verdict.reasons.at(0);
  EXPECT_NE(
      reason.find("; io1_valve, which is accepted too, leaves nothing over that the tests show the input to move"),
      std::string::npos)
      << reason;
  EXPECT_EQ(reason.find("smaller amplitudes"), std::string::npos) << reason;
}

TEST(VerdictAdvice, SaysOfAnEffectWhatWasSeenAndWhatLooksSo) {
  for (const NonlinearKind kind :
       {NonlinearKind::level, NonlinearKind::direction, NonlinearKind::motion, NonlinearKind::position}) {
    for (const GainTrend gain : {GainTrend::unknown, GainTrend::falls, GainTrend::grows}) {
      const std::string effect = effect_of({{}, kind, gain});
      EXPECT_TRUE(effect.find(", as ") != std::string::npos || effect.find(", for instance w") != std::string::npos)
          << effect;
      EXPECT_EQ(effect.find("the plant has"), std::string::npos) << effect;
    }
  }
}

/// An integrating model, whose residual follows the direction of motion.
void integrate_with_friction(Model& model) {
  model.stability.emplace().stable = true;
  model.stability->margin_rad = 1.0;
  model.stability->integrator_order = 1.0;
  model.validation->tests->input.p = 1e-5;
  model.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 90.0, .degrees = 6, .p = 1e-9}, NonlinearKind::motion};
}

TEST(VerdictAdvice, OffersNoFrictionToAModelThatTakesInADrift) {
  Model model = good_model();
  model.transfer_function = {{{3.2, 1.0}, {-0.0008, 0.0}}, {{40.0, 2.0}, {1.0, 1.0}}, 0.0};
  model.estimation->score.samples = 490;
  model.estimation->compared_step_s = 1.0;
  integrate_with_friction(model);
  const Verdict verdict = judge(model, {});
  ASSERT_TRUE(verdict.reasons.front().starts_with("A drift is taken for the plant")) << verdict.reasons.front();
  EXPECT_EQ(grey_box_to_try(model, verdict), nullptr);
  for (const std::string& reason : verdict.reasons) EXPECT_EQ(reason.find("friction)"), std::string::npos) << reason;
}

TEST(VerdictAdvice, NamesThePlantBesideADrift) {
  Model model = good_model();
  // 1.8 / (0.5 s + 1) and 0.012 / s.
  model.transfer_function = {{{1.806, 1.0}, {0.012, 0.0}}, {{0.5, 2.0}, {1.0, 1.0}}, 0.0};
  model.estimation->score.samples = 120;
  model.estimation->compared_step_s = 1.0;
  const std::string first = judge(model, {}).reasons.at(0);
  EXPECT_NE(first.find("beside the drift the plant is about K = 1.806 "), std::string::npos) << first;
  EXPECT_NE(first.find("; T = 0.5 s; the sensor"), std::string::npos) << first;
}

TEST(VerdictAdvice, AdvisesLargerAmplitudesAgainstWhatTakesLessOfThem) {
  for (const bool beside_ladder : {false, true}) {
    for (const bool has_map : {false, true}) {
      for (const auto& [kind, gain, or_kind] :
           std::vector<std::tuple<NonlinearKind, GainTrend, std::optional<NonlinearKind>>>{
               {NonlinearKind::motion, GainTrend::unknown, std::nullopt},
               {NonlinearKind::direction, GainTrend::unknown, NonlinearKind::level},
               {NonlinearKind::level, GainTrend::unknown, NonlinearKind::motion},
               {NonlinearKind::level, GainTrend::grows, std::nullopt},
               {NonlinearKind::level, GainTrend::falls, std::nullopt}}) {
        for (const double input_p : {0.5, 1e-300}) {
          Model model = good_model();
          integrate_with_friction(model);
          model.validation->tests->input.p = input_p;
          model.validation->tests->nonlinearity =
              NonlinearityTest{{.statistic = 300.0, .degrees = 6, .p = 1e-40}, kind, gain, or_kind};
          if (has_map) model.input_map = ValveMap{.null = -0.2, .dead_band = 0.15, .negative_gain_ratio = 0.9};
          std::string all;
          for (const std::string& reason :
               judge(model, {}, {.noise_std = 0.001, .beside_ladder = beside_ladder}).reasons)
            all += reason + "\n";
          EXPECT_EQ(all.find("smaller"), std::string::npos) << all;
          EXPECT_EQ(all.find("half the amplitude"), std::string::npos) << all;
          const bool is_shown = all.find("larger amplitudes, beside which") != std::string::npos ||
                                all.find("eha characterise") != std::string::npos ||
                                all.find("--input-map valve") != std::string::npos;
          // With a map, and an input that still moves what is left, a missing part comes first.
          const bool misses_part = has_map && !beside_ladder && input_p < 0.1;
          const bool asks_for_others = all.find("lags up to 20); fit the other structures too") != std::string::npos;
          EXPECT_TRUE(is_shown || (misses_part && asks_for_others)) << all;
        }
      }
    }
  }
  // A gain that is curved, and nothing else.
  Model curved = good_model();
  curved.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 300.0, .degrees = 6, .p = 1e-40}, NonlinearKind::level};
  EXPECT_NE(judge(curved, {}, {.beside_ladder = true}).reasons.at(0).find("record smaller amplitudes"),
            std::string::npos);
}

TEST(VerdictAdvice, OffersNoFrictionThatWasNotFoundToHold) {
  Model model = good_model();
  integrate_with_friction(model);
  const Verdict verdict = judge(model, {}, {.beside_ladder = true});
  EXPECT_EQ(grey_box_to_try(model, verdict), &friction_kind());
  EXPECT_EQ(grey_box_to_advise(model, verdict), nullptr);
  for (const std::string& reason : verdict.reasons) EXPECT_EQ(reason.find("friction)"), std::string::npos) << reason;
  EXPECT_NE(verdict.reasons[0].find("or record larger amplitudes, beside which"), std::string::npos)
      << verdict.reasons[0];
}

TEST(VerdictAdvice, OffersAGreyBoxThatHoldsToAModelThatFollowsTooLittleForAnyOtherTest) {
  Model model = good_model();
  model.stability->integrator_order = 1.0;
  EXPECT_EQ(grey_box_left_to_try(model, judge(model, {})), nullptr) << "it misses nothing";
  model.validation->score.r2_percent = 55.0;
  model.validation->tests->input.p = 1e-9;
  EXPECT_EQ(grey_box_to_try(model, judge(model, {})), nullptr);
  EXPECT_EQ(grey_box_left_to_try(model, judge(model, {})), &friction_kind());
  model.provenance[kGreyBoxHolds] = "errs 0.1 times as much";
  const std::string first = judge(model, {}).reasons.at(0);
  EXPECT_NE(first.find("; fit the structure with dry friction (`eha fit --model friction`), which errs 0.1"),
            std::string::npos)
      << first;
  // A cause that lies in the record is none of the plant's.
  model.validation->end_stop = EndStop{.level = 5.9, .from_s = 12.1, .percent = 79.0, .clean_to_s = 12.08};
  EXPECT_EQ(grey_box_left_to_try(model, judge(model, {})), nullptr);
}

TEST(VerdictAdvice, NamesAPlantThatDoesNotAnswerAndAGainThatChanges) {
  Model silent = good_model();
  silent.validation->end_stop =
      EndStop{.level = 5.9, .from_s = 78.0, .percent = 22.0, .clean_to_s = 77.98, .does_not_answer = true};
  const std::string first = judge(silent, {}).reasons.at(0);
  EXPECT_TRUE(first.starts_with("The output does not answer from 78 s on: it stands at 5.900")) << first;
  EXPECT_NE(first.find("; cut with --to 77.98."), std::string::npos) << first;
  EXPECT_EQ(first.find("end stop"), std::string::npos) << first;
  silent.validation->end_stop->level = -1e-5;
  EXPECT_NE(judge(silent, {}).reasons.at(0).find("stands at 0.000 in"), std::string::npos);
  Model changed = good_model();
  changed.validation->score.r2_percent = 70.0;
  changed.provenance[kGainChanged] = "at about 60 s, by a factor of 1.4";
  changed.provenance[kBesideGainChange] = "--to 58.5 or --from 61.5";
  const std::vector<std::string> reasons = judge(changed, {}).reasons;
  const auto says = [&](const std::string& part) {
    return std::any_of(reasons.begin(), reasons.end(),
                       [&](const std::string& reason) { return reason.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(says("The gain changes at about 60 s, by a factor of 1.4"));
  EXPECT_TRUE(says("fit the parts apart: --to 58.5 or --from 61.5."));
  EXPECT_FALSE(says("amplitudes"));
}

TEST(VerdictAdvice, OffersTheStructureWithFrictionWhereTheDirectionOfMotionShows) {
  Model model = good_model();
  integrate_with_friction(model);
  model.provenance[kGreyBoxHolds] = "errs 0.4 times as much";
  const std::vector<std::string> reasons = judge(model, {}, {.beside_ladder = true}).reasons;
  ASSERT_EQ(reasons.size(), 1U) << "what past input moves is that effect's";
  EXPECT_EQ(also_shown_in(model, judge(model, {}, {.beside_ladder = true})),
            std::vector<std::string>{"the input moves the error (p = 1e-05)"});
  EXPECT_NE(
      reasons[0].find("or fit the structure with dry friction (`eha fit --model friction`), which errs 0.4 times as "
                      "much, or record larger amplitudes, beside which friction and play are small"),
      std::string::npos)
      << reasons[0];
  for (const std::string& reason : reasons) EXPECT_EQ(reason.find("smaller amplitudes"), std::string::npos) << reason;
  Model full = model;
  full.provenance[kAtCommandLimit] = "the volts reach 4.85 V of the rig's 5 V";
  const std::string no_room = judge(full, {}, {.beside_ladder = true}).reasons.front();
  EXPECT_EQ(no_room.find("record larger"), std::string::npos) << no_room;
  EXPECT_NE(no_room.find("where it is friction or play, reduce that on the rig, as larger amplitudes have no room: the "
                         "volts reach 4.85 "
                         "V of the rig's 5 V"),
            std::string::npos)
      << no_room;
  Model at_its_end = model;
  at_its_end.validation->saturated_percent = 2.0;
  std::string all;
  for (const std::string& reason : judge(at_its_end, {}, {.beside_ladder = true}).reasons) all += reason + "\n";
  EXPECT_NE(all.find("record with smaller amplitudes"), std::string::npos) << all;
  EXPECT_EQ(all.find("larger amplitudes"), std::string::npos) << "beside smaller ones: " << all;
  // Behind a map, too, which takes friction for a dead band.
  model.input_map = ValveMap{-0.2, 0.15, 0.9};
  const std::vector<std::string> given = judge(model, {}, {.beside_ladder = true}).reasons;
  EXPECT_TRUE(std::any_of(given.begin(), given.end(), [](const std::string& reason) {
    return reason.find("--model friction") != std::string::npos;
  }));
  // That structure integrates.
  model.stability->integrator_order = 0.0;
  for (const std::string& reason : judge(model, {}, {.beside_ladder = true}).reasons) {
    EXPECT_EQ(reason.find("`eha fit --model friction`"), std::string::npos) << reason;
    EXPECT_EQ(reason.find("smaller amplitudes"), std::string::npos) << reason;
  }
  // Of friction beside a spring it says once that no structure has both.
  model.input_map.reset();
  model.provenance.erase(kGreyBoxHolds);
  model.transfer_function = {{{1.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  model.estimation->compared_step_s = 0.02;
  const std::vector<std::string> spring = judge(model, {}, {.beside_ladder = true}).reasons;
  ASSERT_EQ(spring.size(), 1U);
  EXPECT_NE(spring[0].find("no structure here has both friction and a rest to which the output returns"),
            std::string::npos)
      << spring[0];
}

TEST(VerdictAdvice, NamesNoSaturationWithoutAFitWithALimitedInput) {
  Model model = good_model();
  model.validation->tests->input.p = 0.0;
  model.validation->tests->input.statistic = 900.0;
  model.validation->tests->whiteness.p = 1e-30;
  model.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 4000.0, .degrees = 12, .p = 0.0}, NonlinearKind::level, GainTrend::falls};
  const std::vector<std::string> reasons = judge(model, {}, {.beside_ladder = true}).reasons;
  ASSERT_EQ(reasons.size(), 1U) << "what past input moves, and what is no noise, is that effect's";
  EXPECT_NE(reasons[0].find("as with the edges of a dead band, friction or a saturation"), std::string::npos)
      << reasons[0];
  EXPECT_NE(reasons[0].find("or measure the valve, whose sheet tells a dead band and friction from a saturation"),
            std::string::npos)
      << reasons[0];
  // Of a linear part that is missing a residual looks nonlinear, too: less so.
  model.validation->tests->input.statistic = 90'000.0;
  const std::vector<std::string> linear = judge(model, {}, {.beside_ladder = true}).reasons;
  ASSERT_EQ(linear.size(), 2U);
  EXPECT_TRUE(
      linear[0].starts_with("A part of the plant may be missing: the input still moves what the model leaves over"))
      << linear[0];
}

TEST(VerdictAdvice, BlamesBentEdgesOfAMapForAGainThatFallsAndNoSaturation) {
  Model model = good_model();
  model.validation->tests->input.p = 1e-5;
  model.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 4000.0, .degrees = 12, .p = 0.0}, NonlinearKind::level, GainTrend::falls};
  model.input_unit = "V";
  model.input_map = ValveMap{.null = -0.2, .dead_band = 0.15, .negative_gain_ratio = 0.9};
  model.validation->map_error = 0.01;
  const std::string saturates = judge(model, {}, {.beside_ladder = true}).reasons.at(0);
  EXPECT_NE(saturates.find("friction or a saturation"), std::string::npos) << saturates;
  model.validation->map_error = 0.055;
  for (const std::string& reason : judge(model, {}, {.beside_ladder = true}).reasons) {
    EXPECT_EQ(reason.find("saturate"), std::string::npos) << reason;
    EXPECT_EQ(reason.find("half the amplitude"), std::string::npos) << reason;
    EXPECT_NE(reason.find("bend its edges (p = 0)"), std::string::npos) << reason;
    EXPECT_NE(reason.find("or measure the valve"), std::string::npos) << reason;
  }
}

TEST(VerdictAdvice, SaysFirstAndAloneWhatExplainsTheError) {
  Model model = good_model();
  model.validation->tests->input.p = 1e-9;
  model.validation->tests->whiteness.p = 1e-9;
  model.validation->score.r2_percent = 50.0;
  model.validation->ccf.values = {0.0, 0.0, 0.01, 0.02};
  note_explanation(model, {.has = "3 poles and 2 zeros", .options = "--model io --poles 3 --zeros 2", .ratio = "0.06"});
  const std::vector<std::string> reasons = judge(model, {}, {.beside_ladder = true}).reasons;
  ASSERT_EQ(reasons.size(), 2U);
  EXPECT_TRUE(
      reasons[0].starts_with("A structure with 3 poles and 2 zeros (`eha fit --model io --poles 3 --zeros 2`) "
                             "passes the checks and errs 0.06 times as much"))
      << reasons[0];
  EXPECT_TRUE(reasons[1].ends_with("; fit that structure.")) << reasons[1];
  EXPECT_EQ(judge(good_model(), {}).reasons.size(), 0U);
  Model good = good_model();
  note_explanation(good, {.has = "3 poles and 2 zeros", .options = "--model io --poles 3 --zeros 2", .ratio = "0.06"});
  EXPECT_TRUE(judge(good, {}).reasons.empty()) << "nothing is left to explain";
  forget_explanation(model);
  EXPECT_EQ(judge(model, {}).reasons.front().find("--poles 3"), std::string::npos);
}

TEST(VerdictAdvice, MakesNoGoodModelOfOneThatErrsByAPlay) {
  const auto judged = [](const char* ratio, const RecordFacts& facts = {}) {
    Model model = good_model();
    note_explanation(model,
                     {.kind = ExplanationKind::play, .has = "1 mm before the sensor", .options = {}, .ratio = ratio});
    return judge(model, {}, facts);
  };
  const Verdict told = judged("0.25");
  EXPECT_EQ(told.grade, Grade::usable);
  EXPECT_TRUE(may_miss_a_part(told));
  EXPECT_TRUE(
      told.reasons.front().starts_with("There is a play (backlash, hysteresis) of about 1 mm before the sensor"))
      << told.reasons.front();
  // What stands in a file need not be a ratio.
  for (const char* ratio : {"", "far less", "0", "-1", "nan", "1e999", "2"}) {
    EXPECT_EQ(judged(ratio).grade, Grade::good) << ratio;
  }
  // The noise that the record itself measured decides, whatever a play explains.
  const double error = std::sqrt(good_model().validation->score.mse);
  EXPECT_FALSE(fails_any(judged("0.25", {.noise_std = error}), {CriterionKind::error_over_noise}));
}

TEST(VerdictAdvice, BlamesRowsThatAreTooSlowAndNothingElse) {
  Model model = good_model();
  model.validation->tests->input.p = 1e-9;
  model.validation->tests->nonlinearity =
      NonlinearityTest{{.statistic = 300.0, .degrees = 6, .p = 1e-30}, NonlinearKind::motion};
  model.provenance[kSlowRows] = "the output answers within one row of 0.1 s; record at least ten times as many";
  const std::vector<std::string> reasons = judge(model, {}).reasons;
  EXPECT_EQ(reasons,
            std::vector<std::string>{"The output answers within one row of 0.1 s; record at least ten times as many."});
  Model sound = good_model();
  sound.provenance[kSlowRows] = model.provenance[kSlowRows];
  EXPECT_TRUE(judge(sound, {}).reasons.empty()) << "a model that follows has no cause to name";
}

TEST(VerdictAdvice, SaysThatTheOutputWandersWhereTheFasterMotionIsFollowed) {
  Model model = good_model();
  model.validation->score.r2_percent = 11.8;
  model.validation->faster_r2_percent = 97.3;
  model.validation->ljung_box_p = 1e-6;
  const Verdict verdict = judge(model, {}, {.beside_ladder = true});
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict.reasons.at(0).rfind("The output wanders, whatever the input does: the model follows its faster "
                                        "motion, R2 97.30 %, and all of it to validation R2 11.80 %, below",
                                        0),
            0U)
      << verdict.reasons.at(0);
  EXPECT_NE(verdict.reasons.at(0).find("check the sensor"), std::string::npos);
  for (const std::string& reason : verdict.reasons) EXPECT_EQ(reason.find("smaller"), std::string::npos) << reason;
  // A part of the plant that is missing may wander as well.
  model.validation->tests->input.p = 1e-5;
  EXPECT_EQ(judge(model, {}).reasons.at(0).find("wanders"), std::string::npos) << judge(model, {}).reasons.at(0);
  model.validation->tests->input.p = 0.5;
  model.validation->faster_r2_percent = 60.0;
  EXPECT_EQ(judge(model, {}).reasons.at(0).find("wanders"), std::string::npos) << judge(model, {}).reasons.at(0);
}

TEST(VerdictAdvice, CallsANoisySensorOne) {
  Model model = good_model();
  model.validation->score.r2_percent = 60.0;
  model.validation->score.mse = 144.0;
  const std::string reason = judge(model, {}, {.beside_ladder = true}).reasons.at(0);
  EXPECT_EQ(reason.rfind("What is left is plain noise of 12 in rms, in which the input has no part: ", 0), 0U)
      << reason;
  EXPECT_NE(reason.find("play a larger amplitude or filter the sensor"), std::string::npos) << reason;
  EXPECT_EQ(reason.find("smaller"), std::string::npos) << reason;
  // Noise that is correlated with itself may be anything.
  model.validation->ljung_box_p = 1e-6;
  EXPECT_EQ(judge(model, {}).reasons.at(0).find("plain noise"), std::string::npos);
  model.validation->ljung_box_p = 0.4;
  model.validation->jump = ErrorJump{32.0, 7.2};
  EXPECT_NE(judge(model, {}).reasons.at(1).find("cut as said above"), std::string::npos);
  model.validation->score.r2_percent = -226.0;
  EXPECT_EQ(judge(model, {}).reasons.at(1).find("hardly answers"), std::string::npos);
}

TEST(VerdictAdvice, SpeaksOfADriftOnlyWhereNothingElseExplainsIt) {
  Model model = good_model();
  model.validation->tests->drift = ResidualDrift{.change = 0.02, .expected = 0.01};
  const std::string alone = judge(model, {}).reasons.at(0);
  EXPECT_EQ(alone.rfind("What is left wanders: by 0.02 in over the validation part, more than the 0.01 in", 0), 0U)
      << alone;
  EXPECT_NE(alone.find("when the oil is warm"), std::string::npos) << alone;
  model.validation->tests->input.p = 1e-5;
  const std::vector<std::string> reasons = judge(model, {}).reasons;
  ASSERT_EQ(reasons.size(), 2U);
  EXPECT_EQ(reasons[1].find("warm"), std::string::npos) << reasons[1];
  // An offset of the validation part behind a jump is the jump's.
  model = good_model();
  model.validation->jump = ErrorJump{32.0, 7.2};
  model.validation->score.r2_percent = 79.0;
  model.validation->offset_reestimated = Score{.r2_percent = 97.6};
  for (const std::string& reason : judge(model, {}).reasons) {
    EXPECT_EQ(reason.find("warm"), std::string::npos) << reason;
  }
}

TEST(VerdictAdvice, SaysWhatKindOfPlantTheResidualShows) {
  Model model = good_model();
  ResidualTests& tests = model.validation->tests.value();
  tests.nonlinearity = NonlinearityTest{{80.0, 30, 1e-3}, NonlinearKind::direction};
  Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_NE(verdict.reasons.at(0).find("play, hysteresis or a limited rate"), std::string::npos) << verdict.reasons[0];
  tests.nonlinearity->test.p = 0.003;
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  tests.future_input = ResidualTest{40.0, 10, 1e-5};
  verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_NE(verdict.reasons.at(0).find("a controller closes the loop"), std::string::npos) << verdict.reasons[0];
}

}  // namespace
}  // namespace eha::ident
