// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/map_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "ident/estimation/fit.hpp"
#include "ident/structure/structure.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kLeakStep_s = 0.04;
constexpr Eigen::Index kLeakRows = 1250;
constexpr double kLeakGain = 0.15;
constexpr double kLeakNull = -0.2;
constexpr double kLeakBand = 0.15;
constexpr double kAllowed = 0.03;  // that numbers of one valve may differ by anyway

/// A rod behind a valve that moves by `leak` in/s besides. Three tones, as of a bench.
Record leaking_rod(double leak, std::uint64_t seed) {
  Record record;
  record.step_s = kLeakStep_s;
  record.input.resize(kLeakRows);
  record.output.resize(kLeakRows);
  std::mt19937_64 draw(seed);
  double y = 3.0;
  for (Eigen::Index k = 0; k < kLeakRows; ++k) {
    const double t = kLeakStep_s * static_cast<double>(k);
    const auto tone = [&](double hz) { return std::sin(2.0 * std::numbers::pi * hz * t); };
    const double u = kLeakNull + 1.5 * tone(0.05) + 1.2 * tone(0.2) + 1.5 * tone(0.65);
    record.input[k] = u;
    record.output[k] = y + 0.0006 * normal(draw);
    const double beyond = std::max(0.0, std::abs(u - kLeakNull) - kLeakBand);
    y += kLeakStep_s * (kLeakGain * std::copysign(beyond, u - kLeakNull) + leak);
  }
  return record;
}

Model leak_fit(const Record& record) {
  return fit(record, asked_for(structures::behind_valve(structures::integrator_lag())), {}).model;
}

TEST(MapError, IsSmallForAValveThatIsTheMap) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Model model = leak_fit(leaking_rod(0.0, seed));
    ASSERT_TRUE(model.validation->map_error) << seed;
    EXPECT_LT(*model.validation->map_error, 0.01) << seed;
  }
}

TEST(MapError, HoldsTheShiftThatALeakMakes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const double leak : {-0.02, -0.01, 0.015}) {
      const Model model = leak_fit(leaking_rod(leak, seed));
      ASSERT_TRUE(model.validation->map_error) << seed;
      const double null_shift = std::abs(model.input_map->null - kLeakNull);
      EXPECT_GT(null_shift, 0.05) << "the leak is to bend the fit";
      EXPECT_LE(null_shift, kShiftOverMapError * *model.validation->map_error + kAllowed) << seed << " " << leak;
      EXPECT_LE(std::abs(model.input_map->dead_band - kLeakBand),
                kShiftOverMapError * *model.validation->map_error + kAllowed)
          << seed << " " << leak;
    }
  }
}

TEST(MapError, IsNoneWithoutAMap) {
  const FitResult result = fit(leaking_rod(0.01, 1), asked_for(structures::integrator_lag()), {});
  EXPECT_FALSE(result.model.validation->map_error);
}

TEST(MapNote, SaysFromWhichShiftOnNullAndDeadBandAreOff) {
  Model model;
  model.input_unit = "V";
  model.validation.emplace();
  EXPECT_EQ(map_note(model), "");
  model.input_map = ValveMap{.null = 0.0, .dead_band = 0.3, .negative_gain_ratio = 1.0};
  EXPECT_EQ(map_note(model), "") << "an error that is not known";
  model.validation->map_error = 0.014;
  EXPECT_EQ(map_note(model), "");
  // A shift far below the dead band, and above what two measurements of one valve differ by.
  model.validation->map_error = 0.043;
  EXPECT_NE(map_note(model).find("may be up to 0.086 V off the valve's"), std::string::npos) << map_note(model);
  EXPECT_NE(map_note(model).find("as where oil leaks past the piston or friction"), std::string::npos);
  EXPECT_TRUE(map_note(model, SheetSays::is_tight).starts_with("dry friction bends the edges of that dead band"));
  EXPECT_NE(map_note(model, SheetSays::is_tight).find("up to 0.086 V off the valve's"), std::string::npos);
  model.validation->jump.emplace();
  EXPECT_EQ(map_note(model).find("leaks"), std::string::npos) << "a jump explains the edges: " << map_note(model);
  EXPECT_NE(map_note(model).find("up to 0.086 V off the valve's"), std::string::npos) << map_note(model);
  model.validation->jump.reset();
  model.input_unit = "mA";
  EXPECT_EQ(map_note(model), "");
  model.validation->map_error = 0.07;
  EXPECT_NE(map_note(model).find("may be up to 0.14 mA off"), std::string::npos) << map_note(model);
}

TEST(MapNote, SaysOfADeadBandThatIsNotFoundNothingElse) {
  Model model;
  model.input_unit = "V";
  model.validation.emplace().map_error = 0.7;
  model.input_map = ValveMap{.null = -0.165, .dead_band = 0.137, .negative_gain_ratio = 0.83};
  model.parameters = {{"dead_band", 0.137, 0.07, 0.0, 0.27, false, ParameterRole::dead_band}};
  ASSERT_NE(unfound_dead_band(model), nullptr);
  EXPECT_EQ(
      map_note(model),
      "the record shows no dead band: the 95 % interval of half of it is 0 to 0.27 V; a controller takes null and "
      "dead band from the valve sheet (`eha characterise`)");
  model.parameters.front().lower95 = 0.01;
  EXPECT_EQ(unfound_dead_band(model), nullptr);
  EXPECT_NE(map_note(model).find("may be up to 0.27 V off"), std::string::npos)
      << "two dead bands from the null the record shows the rod move\n"
      << map_note(model);
}

TEST(MapNote, KnowsOneEdgeOnlyOfAMapThatIsShutInOneDirection) {
  Model model;
  model.input_unit = "V";
  model.validation.emplace();
  model.input_map = ValveMap{.null = -0.065, .dead_band = 0.02, .negative_gain_ratio = -0.03};
  EXPECT_NE(map_note(model).find("in one direction only: of the dead band it shows the edge at -0.045 V"),
            std::string::npos)
      << map_note(model);
  EXPECT_TRUE(std::isinf(reported_map_error(model)));
  model.input_map->negative_gain_ratio = 30.0;
  EXPECT_NE(map_note(model).find("the edge at -0.085 V"), std::string::npos) << map_note(model);
  model.input_map->negative_gain_ratio = 0.3;  // a cylinder with one rod
  EXPECT_EQ(map_note(model), "");
  EXPECT_EQ(reported_map_error(model), 0.0);
}

}  // namespace
}  // namespace eha::ident
