// SPDX-License-Identifier: GPL-3.0-or-later
// How often the intervals of models behind a valve map hold the truth, over many records. A minute.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr int kRecords = 200;
constexpr double kStep_s = 0.05;
constexpr double kNoise = 0.01;  // of the output's standard deviation

struct Plant {
  std::string name;
  Structure structure;
  Model model;
  std::map<std::string, double> truth;
};

std::vector<Plant> plants() {
  const ValveMap map{-0.2, 0.3, 0.85};
  std::map<std::string, double> truth = {{"a2", 0.3},
                                         {"a0", 0.2},
                                         {"K", 0.46},
                                         {"null", map.null},
                                         {"dead_band", map.dead_band},
                                         {"negative_gain_ratio", map.negative_gain_ratio},
                                         {"initial_output", 1.5}};
  Model io;
  io.transfer_function = {{{0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.2, 0.0}}, 0.0};
  io.initial_output = 1.5;
  io.input_map = map;
  Model fo = io;
  fo.transfer_function = {{{0.46, 0.0}}, {{0.3, 1.75}, {1.0, 0.9}, {0.2, 0.0}}, 0.0};
  std::map<std::string, double> fractional_truth = truth;
  fractional_truth["n2"] = 1.75;
  fractional_truth["n1"] = 0.9;
  return {{"io", structures::io(), io, truth}, {"fo", structures::fo(), fo, fractional_truth}};
}

TEST(ValveCoverage, IntervalsHoldTheTruthUnderWhiteNoise) {
  for (const Plant& plant : plants()) {
    StructureOptions asked = asked_for(structures::behind_valve(plant.structure));
    asked.initial_state = InitialState::none;
    FitOptions options;
    options.search = Search::local;
    options.split = 1.0;
    std::map<std::string, int> inside;
    for (int seed = 1; seed <= kRecords; ++seed) {
      const Record record = record_of(plant.model, kStep_s, kNoise, static_cast<std::uint64_t>(seed));
      for (const ParameterEstimate& p : fit(record, asked, options).model.parameters) {
        const auto truth = plant.truth.find(p.name);
        if (truth == plant.truth.end() || p.fixed) continue;
        inside[p.name] += p.lower95 <= truth->second && truth->second <= p.upper95 ? 1 : 0;
      }
    }
    ASSERT_EQ(inside.size(), plant.truth.size()) << plant.name;
    double total = 0.0;
    for (const auto& [name, count] : inside) {
      std::printf("%s %s %.1f %%\n", plant.name.c_str(), name.c_str(), 100.0 * count / kRecords);
      // 95 % of 200, less three standard deviations of the count.
      EXPECT_GE(count, 180) << plant.name << ", " << name;
      total += count;
    }
    const double share = total / static_cast<double>(kRecords * inside.size());
    std::printf("%s pooled %.1f %%\n", plant.name.c_str(), 100.0 * share);
    EXPECT_GE(share, 0.92) << plant.name;
    EXPECT_LE(share, 0.98) << plant.name;
  }
}

}  // namespace
}  // namespace eha::ident
