// SPDX-License-Identifier: GPL-3.0-or-later
// How long a fit with its intervals takes, over many records of plants that suit the structure or do not. Minutes.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr int kSeeds = 50;
constexpr double kLongest_s = 3.0;  // of processor time

struct Plant {
  std::string name;
  TransferFunction g;
};

const std::vector<Plant>& plants() {
  static const std::vector<Plant> all = {{"lag", {{{1.0, 0.0}}, {{1.0, 1.0}, {1.5, 0.0}}, 0.0}},
                                         {"slow_lag", {{{0.3, 0.0}}, {{1.0, 1.0}, {0.02, 0.0}}, 0.0}},
                                         {"integrator", {{{0.3, 0.0}}, {{1.0, 1.0}}, 0.0}},
                                         {"two_poles", {{{1.0, 0.0}}, {{0.5, 2.0}, {1.0, 1.0}, {0.4, 0.0}}, 0.0}},
                                         {"resonance", {{{1.0, 0.0}}, {{0.05, 2.0}, {0.05, 1.0}, {1.0, 0.0}}, 0.0}},
                                         {"two_orders", {{{0.46, 0.0}}, {{0.6, 1.75}, {1.0, 0.9}, {0.3, 0.0}}, 0.0}},
                                         {"fractional_lag", {{{1.0, 0.0}}, {{1.0, 0.6}, {1.0, 0.0}}, 0.0}},
                                         {"delayed_lag", {{{1.0, 0.0}}, {{1.0, 1.0}, {1.5, 0.0}}, 0.3}}};
  return all;
}

class Effort : public testing::TestWithParam<Plant> {};

TEST_P(Effort, OfAFitOfTwoOrdersIsSeconds) {
  Model plant;
  plant.transfer_function = GetParam().g;
  double longest_s = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Record record = record_of(plant, 0.05, 0.01, static_cast<std::uint64_t>(seed));
    const std::clock_t begin = std::clock();
    static_cast<void>(fit(record, asked_for(structures::fo()), {}));
    const double taken_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    EXPECT_LE(taken_s, kLongest_s) << "seed " << seed;
    longest_s = std::max(longest_s, taken_s);
  }
  RecordProperty("longest_s", std::to_string(longest_s));
}

INSTANTIATE_TEST_SUITE_P(Plants, Effort, testing::ValuesIn(plants()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace eha::ident
