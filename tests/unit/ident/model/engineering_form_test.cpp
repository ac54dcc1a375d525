// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/engineering_form.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace eha::ident {
namespace {

Model model_of(TransferFunction g) {
  Model model;
  model.transfer_function = std::move(g);
  return model;
}

TEST(EngineeringForm, GivesGainFrequencyAndDampingOfACylinder) {
  // 0.148 / (s (s^2/w^2 + 2 D s/w + 1)), 12 Hz, 0.3
  const double w = 2.0 * std::numbers::pi * 12.0;
  Model model = model_of({{{0.148, 0.0}}, {{1.0 / (w * w), 3.0}, {0.6 / w, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0063});
  EXPECT_EQ(engineering_form(model), "K = 0.148 in/(V s), integrating; f0 = 12 Hz, D = 0.3; dead time 6.3 ms");
  // Up to 0.65 Hz a lag of as much turns the phase as much.
  model.verdict.emplace().usable_band = FrequencyInterval{0.05, 0.65};
  EXPECT_NE(engineering_form(model).find("dead time 6.3 ms (or a lag of as much: the band, to 0.65 Hz, does not tell"),
            std::string::npos)
      << engineering_form(model);
  // Steps tell 200 ms to 0.5 ms, and a lag of as much is off by as much as 18 ms of it.
  Model steps = model_of({{{3.0, 0.0}}, {{1.0, 1.0}, {2.0, 0.0}}, 0.2});
  steps.parameters = {{.name = "delay_s", .value = 0.2, .std = 0.0005, .role = ParameterRole::delay}};
  steps.verdict.emplace().usable_band = FrequencyInterval{0.03, 0.145};
  EXPECT_FALSE(may_be_lag(steps));
  steps.parameters[0].std = 0.02;
  EXPECT_TRUE(may_be_lag(steps));
  model.verdict->usable_band = FrequencyInterval{0.05, 12.0};
  EXPECT_TRUE(engineering_form(model).ends_with("dead time 6.3 ms"));
  model.output_unit = "mm";
  EXPECT_EQ(engineering_form(model).rfind("K = 0.148 mm/(V s)", 0), 0U);
}

TEST(EngineeringForm, GivesTimeConstantsOfRealPolesAndZeros) {
  // 2 (0.5 s + 1) / ((0.1 s + 1)(3 s + 1))
  const std::string text =
      engineering_form(model_of({{{1.0, 1.0}, {2.0, 0.0}}, {{0.3, 2.0}, {3.1, 1.0}, {1.0, 0.0}}, 0.0}));
  EXPECT_EQ(text.rfind("K = 2 in/V; ", 0), 0U) << text;
  for (const char* part : {"; T = 0.1 s", "; T = 3 s", "; TD = 0.5 s"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  }
}

TEST(EngineeringForm, HasOneKWithItsInterval) {
  Model model = model_of({{{0.148, 0.0}}, {{0.0065, 2.0}, {1.0, 1.0}}, 0.0});
  model.parameters = {{.name = "K",
                       .value = 0.148,
                       .std = 0.001,
                       .lower95 = 0.146,
                       .upper95 = 0.15,
                       .role = ParameterRole::numerator_coefficient}};
  EXPECT_EQ(engineering_form(model, "±"), "K = 0.1480 ± 0.0020 in/(V s), integrating; T = 0.0065 s");
  EXPECT_EQ(engineering_form(model), "K = 0.1480 in/(V s), integrating; T = 0.0065 s") << "one rounding of a gain";
  model.parameters.push_back({.name = "a2",
                              .value = 0.0065,
                              .std = 0.0002,
                              .lower95 = 0.0061,
                              .upper95 = 0.0069,
                              .role = ParameterRole::denominator_coefficient});
  EXPECT_TRUE(engineering_form(model, "+-").ends_with("; T = 0.00650 +- 0.00040 s")) << engineering_form(model, "+-");
  // The gain of a lag whose denominator ends in a0 is not the parameter K.
  model.transfer_function.denominator = {{1.0, 1.0}, {0.1, 0.0}};
  EXPECT_EQ(engineering_form(model, "±").rfind("K/a0 = 1.48 in/V", 0), 0U) << engineering_form(model, "±");
}

TEST(EngineeringForm, GivesTheIntervalsOfGainAndTimeConstantOfALag) {
  // 37.5 / (s + 2.5): K/a0 = 15, T = 0.4 s.
  Model model = model_of({{{37.5, 0.0}}, {{1.0, 1.0}, {2.5, 0.0}}, 0.0});
  const auto add = [&](const char* name, double value, double std, ParameterRole role) {
    model.parameters.push_back({.name = name,
                                .value = value,
                                .std = std,
                                .lower95 = value - 1.96 * std,
                                .upper95 = value + 1.96 * std,
                                .role = role});
  };
  add("K", 37.5, 0.75, ParameterRole::numerator_coefficient);
  add("a0", 2.5, 0.05, ParameterRole::denominator_coefficient);
  // Each is known to 2 %: together not at all correlated 2.8 % of 15, times 1.96; fully correlated the gain is exact.
  EXPECT_EQ(engineering_form(model, "+-"), "K/a0 = 15.00 +- 0.83 in/V; T = 0.400 +- 0.016 s");
  model.estimation.emplace().correlation = ParameterCorrelation{{"K", "a0"}, {{1.0, 0.995}, {0.995, 1.0}}, {}};
  EXPECT_EQ(engineering_form(model, "+-"), "K/a0 = 15.000 +- 0.059 in/V; T = 0.400 +- 0.016 s");
  EXPECT_EQ(engineering_form(model), "K/a0 = 15.000 in/V; T = 0.400 s") << "rounded alike";
}

TEST(EngineeringForm, GivesTheIntervalsOfFrequencyAndDamping) {
  // 200 / (0.01 s^2 + s + 100): 100 rad/s, damping 0.5.
  Model model = model_of({{{200.0, 0.0}}, {{0.01, 2.0}, {1.0, 1.0}, {100.0, 0.0}}, 15.0});
  const auto add = [&](const char* name, double value, double std, ParameterRole role) {
    model.parameters.push_back({.name = name,
                                .value = value,
                                .std = std,
                                .lower95 = value - 1.96 * std,
                                .upper95 = value + 1.96 * std,
                                .role = role});
  };
  add("K", 200.0, 2.0, ParameterRole::numerator_coefficient);
  add("a2", 0.01, 0.0002, ParameterRole::denominator_coefficient);
  add("a0", 100.0, 2.0, ParameterRole::denominator_coefficient);
  add("delay_s", 15.0, 0.06, ParameterRole::delay);
  // f0 goes with (a0/a2)^0.5 and D with (a0 a2)^-0.5: half of 2.8 % each, times 1.96.
  EXPECT_EQ(engineering_form(model, "+-"),
            "K/a0 = 2.000 +- 0.088 in/V; f0 = 15.92 +- 0.44 Hz, D = 0.500 +- 0.014; dead time 15.00 +- 0.12 s");
  // What moves both alike leaves the frequency as it is.
  model.estimation.emplace().correlation =
      ParameterCorrelation{{"K", "a2", "a0"}, {{1.0, 0.0, 0.0}, {0.0, 1.0, 1.0}, {0.0, 1.0, 1.0}}, {}};
  EXPECT_NE(engineering_form(model, "+-").find("; f0 = 15.92 Hz, D = 0.500 +- 0.020"), std::string::npos)
      << engineering_form(model, "+-");
  EXPECT_NE(engineering_form(model).find("; f0 = 15.92 Hz, D = 0.500; dead time 15.00 s"), std::string::npos);
  // What lies far above the band is not observed, and has no interval.
  model.verdict.emplace().usable_band = FrequencyInterval{0.05, 0.65};
  EXPECT_NE(engineering_form(model, "+-").find("; f0 = 15.92 Hz, D = 0.5 (not observed: above the band, to 0.65 Hz)"),
            std::string::npos)
      << engineering_form(model, "+-");
}

TEST(EngineeringForm, IsNoneForAFractionalOrder) {
  EXPECT_EQ(engineering_form(model_of({{{1.0, 0.0}}, {{0.5, 1.75}, {1.0, 0.9}, {0.1, 0.0}}, 0.0})), "");
}

TEST(UnitOfParameter, FollowsFromTheOrders) {
  const Model model = model_of({{{0.13, 0.0}}, {{0.6, 1.75}, {1.0, 0.9}, {0.04, 0.0}}, 0.0});
  const auto unit = [&](const char* name, ParameterRole role) {
    return unit_of(ParameterEstimate{.name = name, .role = role}, model);
  };
  EXPECT_EQ(unit("K", ParameterRole::numerator_coefficient), "in/(V s^0.9)");
  EXPECT_EQ(unit("a2", ParameterRole::denominator_coefficient), "s^0.85");
  EXPECT_EQ(unit("a0", ParameterRole::denominator_coefficient), "s^-0.9");
  EXPECT_EQ(unit("n2", ParameterRole::denominator_order), "");
  EXPECT_EQ(unit("dead_band", ParameterRole::dead_band), "V");
  EXPECT_EQ(unit("initial_output", ParameterRole::initial_output), "in");
}

TEST(EngineeringForm, CallsAPoleRoundedByASearchAnIntegrator) {
  Model model = model_of({{{0.2, 0.0}}, {{0.05, 2.0}, {1.0, 1.0}, {4e-13, 0.0}}, 0.0});
  model.verdict.emplace().usable_band = FrequencyInterval{0.04, 2.0};
  EXPECT_EQ(engineering_form(model), "K = 0.2 in/(V s), integrating; T = 0.05 s");
}

TEST(EngineeringForm, TakesNoPoleBesideAZeroBelowTheBandForAnIntegrator) {
  // 1.8 (16.2 s + 1) / ((16.3 s + 1)(0.3 s + 1))
  Model model = model_of({{{1.8 * 16.2, 1.0}, {1.8, 0.0}}, {{16.3 * 0.3, 2.0}, {16.6, 1.0}, {1.0, 0.0}}, 0.0});
  model.verdict.emplace().usable_band = FrequencyInterval{0.04, 2.0};
  const std::string text = engineering_form(model);
  EXPECT_EQ(text.rfind("K = 1.789 in/V in its band (T = 16.3 s and TD = 16.2 s are below it); T = 0.3 s", 0), 0U)
      << text;
  EXPECT_EQ(text.find("integrating"), std::string::npos) << text;
}

}  // namespace
}  // namespace eha::ident
