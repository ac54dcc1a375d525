// SPDX-License-Identifier: GPL-3.0-or-later
// Intervals and residual tests of right models in white, coloured and quantised noise, over many records. Minutes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kStep_s = 0.025;
constexpr double kNoise = 0.01;  // of the output's standard deviation
constexpr double kLevel = 0.01;  // of a residual test
constexpr double kTolerance = 0.02;

struct Plant {
  std::string name;
  Structure structure;
  Model model;
  std::map<std::string, double> truth;
  int records = 0;  ///< 1600 in all
};

std::vector<Plant> plants() {
  Model io;
  io.transfer_function = {{{0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.4, 0.0}}, 0.0};
  Model lag;
  lag.transfer_function = {{{0.46, 0.0}}, {{1.0, 0.85}, {0.4, 0.0}}, 0.0};
  Model valve = io;
  valve.input_map = ValveMap{-0.2, 0.3, 0.85};
  const std::map<std::string, double> integer = {{"a2", 0.3}, {"a0", 0.4}, {"K", 0.46}};
  std::map<std::string, double> behind_valve = integer;
  behind_valve.insert({{"null", -0.2}, {"dead_band", 0.3}, {"negative_gain_ratio", 0.85}});
  return {{"io", structures::io(), io, integer, 400},
          {"fo",
           structures::fo(),
           fractional(0.3, 1.75, 0.9, 0.4, 0.46),
           {{"a2", 0.3}, {"n2", 1.75}, {"n1", 0.9}, {"a0", 0.4}, {"K", 0.46}},
           400},
          {"lag", structures::lag(), lag, {{"n1", 0.85}, {"a0", 0.4}, {"K", 0.46}}, 400},
          {"io_valve", structures::behind_valve(structures::io()), valve, behind_valve, 400}};
}

enum class Noise { white, coloured, quantised };
struct Kind {
  Noise noise;
  const char* name;
  double least_coverage;
};
constexpr std::array kKinds{Kind{Noise::white, "white", 0.92}, Kind{Noise::coloured, "AR(1) 0.9", 0.90},
                            Kind{Noise::quantised, "quantised", 0.92}};

Record noisy(const Record& exact, Noise noise, std::uint64_t seed) {
  Record record = exact;
  const double level = kNoise * std::sqrt((exact.output.array() - exact.output.mean()).square().mean());
  std::mt19937_64 draw(seed);
  double e = normal(draw);
  for (double& y : record.output) {
    if (noise == Noise::quantised) {
      const double code = 3.0 * level;
      y = code * std::round((y + level * normal(draw)) / code);
      continue;
    }
    y += level * e;
    e = noise == Noise::white ? normal(draw) : 0.9 * e + std::sqrt(1.0 - 0.81) * normal(draw);
  }
  return record;
}

class NoiseKinds : public testing::TestWithParam<Kind> {};

TEST_P(NoiseKinds, LeaveIntervalsAndResidualTestsAtTheirLevels) {
  const Kind& kind = GetParam();
  int records = 0;
  int input = 0;
  int whiteness = 0;
  for (const Plant& plant : plants()) {
    StructureOptions asked = asked_for(plant.structure);
    asked.initial_state = InitialState::none;
    FitOptions options;
    options.search = Search::local;
    const Record exact = record_of(plant.model, kStep_s, 0.0, 1);
    std::map<std::string, int> inside;
    for (int seed = 1; seed <= plant.records; ++seed) {
      const FitResult result = fit(noisy(exact, kind.noise, static_cast<std::uint64_t>(seed)), asked, options);
      for (const ParameterEstimate& p : result.model.parameters) {
        const auto truth = plant.truth.find(p.name);
        if (truth == plant.truth.end() || p.fixed) continue;
        inside[p.name] += p.lower95 <= truth->second && truth->second <= p.upper95 ? 1 : 0;
      }
      ASSERT_TRUE(result.model.validation && result.model.validation->tests);
      input += result.model.validation->tests->input.p < kLevel ? 1 : 0;
      whiteness += result.model.validation->tests->whiteness.p < kLevel ? 1 : 0;
    }
    records += plant.records;
    double total = 0.0;
    std::printf("%-10s %-9s", kind.name, plant.name.c_str());
    for (const auto& [name, count] : inside) {
      std::printf(" %s %.1f %%", name.c_str(), 100.0 * count / plant.records);
      total += count;
    }
    const double share = total / static_cast<double>(plant.records * static_cast<int>(inside.size()));
    std::printf("  pooled %.1f %%\n", 100.0 * share);
    EXPECT_EQ(inside.size(), plant.truth.size()) << plant.name;
    EXPECT_GE(share, kind.least_coverage) << plant.name;
    EXPECT_LE(share, 0.98) << plant.name;
  }
  std::printf("%-10s alarms at 1 %%: input %.2f %%, whiteness %.2f %% of %d records\n", kind.name,
              100.0 * input / records, 100.0 * whiteness / records, records);
  EXPECT_NEAR(static_cast<double>(input) / records, kLevel, kTolerance);
  EXPECT_NEAR(static_cast<double>(whiteness) / records, kLevel, kTolerance);
}

INSTANTIATE_TEST_SUITE_P(Of, NoiseKinds, testing::ValuesIn(kKinds));

}  // namespace
}  // namespace eha::ident
