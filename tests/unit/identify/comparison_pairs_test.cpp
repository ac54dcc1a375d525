// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <vector>

#include "daemon/identify/comparison.hpp"
#include "tests/unit/identify/twin_source.hpp"

namespace eha::identify {
namespace {

TEST(ComparisonPairs, FindsNoChangeBetweenRunsOfOneRig) {
  std::vector<Source> sources;
  for (std::uint64_t seed = 1; seed <= 21; ++seed) sources.push_back(test::source_of(test::seeded(seed)));
  for (std::size_t i = 1; i < sources.size(); ++i) {
    const RunComparison comparison = compare_runs({sources[i - 1], sources[i]});
    const ident::PlantChange& change = *comparison.runs[1].change;
    EXPECT_FALSE(change.changed) << "pair " << i << ": " << change.parameters.front().name << " "
                                 << change.parameters.front().before << " " << change.parameters.front().after << " +- "
                                 << change.parameters.front().half_width;
  }
}

}  // namespace
}  // namespace eha::identify
