// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/parameter_change.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "ident/model/engineering_form.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

Model with(double null, double dead_band, double gain) {
  Model model;
  const auto add = [&](const char* name, double value, double std, ParameterRole role) {
    model.parameters.push_back({name, value, std, value, value, false, role});
  };
  add("K", gain, 0.001, ParameterRole::numerator_coefficient);
  add("null", null, 0.002, ParameterRole::valve_null);
  add("dead_band", dead_band, 0.002, ParameterRole::dead_band);
  add("initial_output", 3.0, 0.001, ParameterRole::initial_output);
  model.parameters.push_back({"a1", 1.0, 0.0, 1.0, 1.0, true, ParameterRole::denominator_coefficient});
  return model;
}

TEST(ParameterChange, NamesTheUnitThatMakesAGainAnother) {
  const auto said = [](double before, double after) {
    return unit_instead(compare_parameters(with(-0.2, 0.15, before), with(-0.2, 0.15, after), 0.01));
  };
  EXPECT_EQ(
      said(0.3, 7.63),
      "K is 25.4 times as great: probably no change of the plant, but one record is in millimetres and the other in "
      "inches; check the units");
  EXPECT_NE(said(7.63, 0.3).find("as small: probably"), std::string::npos);
  EXPECT_NE(said(0.3, 300.0).find("in thousandths of the other's"), std::string::npos);
  EXPECT_EQ(said(0.3, 0.36), "");
  EXPECT_EQ(said(0.3, 7.0), "");
  EXPECT_EQ(said(0.3, -7.62), "");
}

TEST(ParameterChange, TakesNoDifferenceAcrossUnits) {
  const auto of_order = [](const char* name, double order) {
    Model model = with(-0.2, 0.15, 0.13);
    model.name = name;
    model.input_unit = "V";
    model.output_unit = "in";
    model.transfer_function = {{{0.13, 0.0}}, {{0.0, 0.0}, {1.0, 1.0}, {0.0067, order}}, 0.0};
    model.parameters.push_back({"a2", 0.0067, 1e-4, 0.006, 0.007, false, ParameterRole::denominator_coefficient});
    return model;
  };
  const Model whole = of_order("integrator_lag", 2.0);
  Model other = of_order("fo", 2.044);
  other.parameters.back().value = 0.0099;
  const PlantChange all = compare_parameters(whole, other, 0.01);
  ASSERT_TRUE(all.changed);
  const PlantChange change = without_other_units(all, whole, other);
  EXPECT_EQ(change.other_unit, std::vector<std::string>{"a2"});
  EXPECT_EQ(change.parameters.size(), all.parameters.size() - 1);
  EXPECT_FALSE(change.changed);
  other.name = whole.name;
  EXPECT_TRUE(without_other_units(all, whole, other).changed) << "one structure: its orders were estimated";
  EXPECT_EQ(unit_of(of_order("fo", 2.00001).parameters.back(), of_order("fo", 2.00001)), "s");
}

/// One pole that comes to rest, in the form K/(s + a0), whose two parameters move together.
Model lag_with(double gain, double time_s) {
  Model model;
  model.output_unit = "degC";
  model.input_unit = "V";
  const double a0 = 1.0 / time_s;
  model.transfer_function = {{{gain * a0, 0.0}}, {{a0, 0.0}, {1.0, 1.0}}, 0.0};
  model.parameters.push_back({"K", gain * a0, 0.01 * gain * a0, 0.0, 0.0, false, ParameterRole::numerator_coefficient});
  model.parameters.push_back({"a0", a0, 0.01 * a0, 0.0, 0.0, false, ParameterRole::denominator_coefficient});
  model.estimation.emplace();
  model.estimation->score.samples = 3600;
  model.estimation->compared_step_s = 1.0;
  model.estimation->correlation = ParameterCorrelation{{"K", "a0"}, {{1.0, 0.9}, {0.9, 1.0}}, {}};
  return model;
}

TEST(ParameterChange, NamesGainAndTimeConstantOfAPlantThatComesToRest) {
  const Model before = lag_with(3.2, 40.0);
  const PlantChange slower = compare_parameters(before, lag_with(3.2, 48.0), 0.01);
  ASSERT_EQ(slower.parameters.size(), 2U);
  EXPECT_EQ(slower.parameters[0].name, "T");
  EXPECT_TRUE(slower.parameters[0].changed);
  EXPECT_NEAR(slower.parameters[0].after, 48.0, 1e-9);
  EXPECT_EQ(unit_of(slower.parameters[0], before), "s");
  EXPECT_EQ(slower.parameters[1].name, "K/a0");
  EXPECT_FALSE(slower.parameters[1].changed) << "K itself, the gain over the time constant, moved by a sixth";
  EXPECT_EQ(unit_of(slower.parameters[1], before), "degC/V");
  // 0.01 sqrt(1 + 1 - 2 0.9) of the gain for each model.
  EXPECT_NEAR(slower.parameters[1].std, 3.2 * 0.01 * std::sqrt(0.4), 1e-9);
  const PlantChange stronger = compare_parameters(before, lag_with(3.6, 40.0), 0.01);
  EXPECT_EQ(stronger.parameters[0].name, "K/a0");
  EXPECT_FALSE(stronger.parameters[1].changed);
}

TEST(ParameterChange, KeepsTheGainOfAPlantThatDoesNotComeToRest) {
  const PlantChange change = compare_parameters(lag_with(3.2, 2000.0), lag_with(3.2, 2000.0), 0.01);
  EXPECT_TRUE(
      std::any_of(change.parameters.begin(), change.parameters.end(), [](const auto& p) { return p.name == "K"; }));
}

TEST(ParameterChange, NamesWhatMovedFirst) {
  Model after = with(-0.12, 0.151, 0.1305);
  after.parameters[3].value = 2.0;
  const PlantChange change = compare_parameters(with(-0.2, 0.15, 0.13), after, 0.01);
  EXPECT_TRUE(change.changed);
  ASSERT_EQ(change.parameters.size(), 3U) << "neither the record's start nor what is held counts";
  EXPECT_EQ(change.parameters[0].name, "null");
  EXPECT_TRUE(change.parameters[0].changed);
  EXPECT_NEAR(change.parameters[0].after - change.parameters[0].before, 0.08, 1e-12);
  // Bonferroni: 2.94 standard deviations for three parameters at 1 %.
  EXPECT_NEAR(change.parameters[0].half_width, 2.935 * std::hypot(0.002, 0.002), 1e-5);
  EXPECT_FALSE(change.parameters[1].changed);
  EXPECT_FALSE(change.parameters[2].changed);
}

TEST(ParameterChange, DoesNotNameWhatAChangedMapShifts) {
  // Gain and dead band compensate each other: 1 V more of the one is worth 0.05 in/(V s) of the other.
  const auto related = [](Model model) {
    model.estimation.emplace().correlation =
        ParameterCorrelation{{"K", "null", "dead_band"}, {{1.0, 0.0, 0.1}, {0.0, 1.0, 0.0}, {0.1, 0.0, 1.0}}, {}};
    model.parameters[0].std = 0.0002;
    model.parameters[2].std = 0.0004;
    return model;
  };
  const Model before = related(with(-0.2, 0.15, 0.148));
  PlantChange change = compare_parameters(before, related(with(-0.2, 0.21, 0.1505)), 0.01);
  ASSERT_EQ(change.parameters[0].name, "dead_band");
  EXPECT_TRUE(change.parameters[0].changed);
  for (const ParameterChange& p : change.parameters) {
    EXPECT_EQ(p.changed, p.name == "dead_band") << p.name;
    EXPECT_EQ(p.follows, p.name == "K" ? std::vector<std::string>{"dead_band"} : std::vector<std::string>{}) << p.name;
    if (p.name != "K") continue;
    // 0.1 * 0.0002 / 0.0004 in/(V s) a V, of 0.06 V.
    EXPECT_NEAR(p.half_width - p.of_noise, 0.05 * 0.06, 1e-9);
    EXPECT_EQ(
        hidden_sentence(p, before),
        "a change of K below 0.0038 does not show here: dead_band changed, and the fit lets K follow it (by noise "
        "alone 0.00083); each fit by itself says 0.14800 before and 0.15050 after");
  }
  // A gain that changed by more is named; so is the same change beside an unchanged map.
  for (const Model& after : {related(with(-0.2, 0.21, 0.158)), related(with(-0.2, 0.15, 0.1505))}) {
    change = compare_parameters(before, after, 0.01);
    for (const ParameterChange& p : change.parameters) {
      if (p.name != "K") continue;
      EXPECT_TRUE(p.changed) << p.half_width;
    }
  }
}

TEST(ParameterChange, SaysThatEitherChangedWhereTheGainMayMoveTheMapAsWell) {
  const auto related = [](Model model) {
    model.estimation.emplace().correlation =
        ParameterCorrelation{{"K", "null", "dead_band"}, {{1.0, 0.0, 0.97}, {0.0, 1.0, 0.0}, {0.97, 0.0, 1.0}}, {}};
    return model;
  };
  // 0.02 V of dead band and 0.01 in/(V s) of gain are worth the same.
  const Model before = related(with(-0.2, 0.15, 0.130));
  const PlantChange change = compare_parameters(before, related(with(-0.2, 0.17, 0.140)), 0.01);
  for (const ParameterChange& p : change.parameters) {
    EXPECT_EQ(p.changed, p.name == "dead_band") << p.name;
    if (p.name != "K") continue;
    EXPECT_TRUE(p.may_lead);
    EXPECT_NE(
        hidden_sentence(p, before).find(
            "does not show here: dead_band or K changed, or both, as the fit lets one follow the other (by noise"),
        std::string::npos)
        << hidden_sentence(p, before);
  }
}

TEST(ParameterChange, NamesAGainThatChangedBesideADeadBandWherePlainNoiseIsLeftOver) {
  const auto clean = [](double dead_band, double gain, bool is_plain) {
    Model model = with(0.0, dead_band, gain);
    EstimationReport& estimation = model.estimation.emplace();
    estimation.correlation =
        ParameterCorrelation{{"K", "null", "dead_band"}, {{1.0, 0.0, 0.9}, {0.0, 1.0, 0.0}, {0.9, 0.0, 1.0}}, {}};
    estimation.noise = ResidualNoise{.power = 0.0025, .variance = 0.0025};
    if (!is_plain) estimation.noise->coefficients = {0.4};
    model.parameters[0].std = 0.005;
    model.parameters[2].std = 0.0002;
    return model;
  };
  const auto says_gain = [&](bool is_plain) {
    const PlantChange change = compare_parameters(clean(0.3, 12.0, is_plain), clean(0.6, 10.0, is_plain), 0.01);
    const auto k = std::find_if(change.parameters.begin(), change.parameters.end(),
                                [](const ParameterChange& p) { return p.name == "K"; });
    return k->changed;
  };
  EXPECT_TRUE(says_gain(true));
  EXPECT_FALSE(says_gain(false)) << "a curved valve may make it";
}

TEST(ParameterChange, CountsTheSamplesOfAWhitenedResidual) {
  const auto known_by = [](bool with_parameters) {
    Model model = with(-0.2, 0.15, 0.13);
    EstimationReport& estimation = model.estimation.emplace();
    estimation.information.emplace().parameters = 5;
    estimation.information->effective_samples = 8.0;  // of a residual that drifts slowly
    estimation.information->samples = 500;
    estimation.noise.emplace().with_parameters = with_parameters;
    return model;
  };
  const auto width = [](const Model& model) { return compare_parameters(model, model, 0.01).parameters[0].half_width; };
  // Student's t at 0.17 %: 8.6 of three degrees of freedom, 2.95 of 495.
  EXPECT_NEAR(width(known_by(false)) / width(known_by(true)), 8.575 / 2.947, 0.01);
}

TEST(ParameterChange, SaysWhatARecordDoesNotDetermine) {
  Model after = with(-0.2, 0.15, 0.13);
  after.parameters[0].std = std::numeric_limits<double>::infinity();
  const PlantChange change = compare_parameters(with(-0.2, 0.15, 0.13), after, 0.01);
  EXPECT_FALSE(change.changed);
  EXPECT_EQ(change.undetermined, std::vector<std::string>{"K"});
}

TEST(ParameterChange, RaisesFalseAlarmsAtItsLevel) {
  std::mt19937_64 generator(1);
  int alarms = 0;
  constexpr int kPairs = 4000;
  for (int i = 0; i < kPairs; ++i) {
    const auto drawn = [&] {
      Model model = with(-0.2, 0.15, 0.13);
      for (ParameterEstimate& p : model.parameters) p.value += p.std * synthetic::normal(generator);
      return model;
    };
    alarms += compare_parameters(drawn(), drawn(), 0.05).changed ? 1 : 0;
  }
  EXPECT_LT(alarms, 0.05 * kPairs + 4.0 * std::sqrt(0.05 * kPairs));
  EXPECT_GT(alarms, 0.05 * kPairs - 4.0 * std::sqrt(0.05 * kPairs));
}

TEST(MapInstead, NamesWhatAModelWithoutAMapShowsAsItsGain) {
  EXPECT_TRUE(
      map_instead({"K", "a2"}, false).starts_with("without a valve map a dead band or null that changed shows as K"))
      << map_instead({"K", "a2"}, false);
  EXPECT_EQ(map_instead({"K"}, true), "");
  EXPECT_EQ(map_instead({"a2"}, false), "");
}

}  // namespace
}  // namespace eha::ident
