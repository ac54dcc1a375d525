// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/grey_box/grey_box_kind.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace eha::ident {
namespace {

using State = std::array<double, 2>;

State after(const GreyBoxKind& kind, const std::vector<double>& values, State state, double v, double duration_s,
            int pieces = 1) {
  for (int k = 0; k < pieces; ++k) kind.advance(values.data(), state.data(), v, duration_s / pieces);
  return state;
}

TEST(GreyBoxKinds, HaveNamesOfTheirOwnAndStartsOfTheirLength) {
  std::set<std::string_view> names;
  const GreyBoxStart start{{2.0, {0.5, 1.0, 0.3}}, 1.0, -1.0, 3.0};
  for (const GreyBoxKind* kind : grey_box_kinds()) {
    EXPECT_TRUE(names.insert(kind->name).second) << kind->name;
    ASSERT_FALSE(kind->starts(start).empty()) << kind->name;
    for (const std::vector<double>& values : kind->starts(start)) {
      ASSERT_EQ(values.size(), kind->parameters.size()) << kind->name;
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_TRUE(!kind->parameters[i].positive || values[i] > 0.0) << kind->name << ' ' << i;
      }
    }
    EXPECT_EQ(index_of(*kind, kind->parameters.back().name), kind->parameters.size() - 1);
    EXPECT_EQ(index_of(*kind, "no such"), kind->parameters.size());
  }
}

TEST(GreyBoxKinds, RestWithoutInput) {
  const std::vector<double> friction{0.5, 0.2, 0.1};
  const std::vector<double> tanks{0.5, 3.0, 2.0, 4.0, 3.0, 2.0, 0.5};
  for (const double duration_s : {0.01, 10.0}) {
    EXPECT_EQ(after(friction_kind(), friction, {0.0, 0.0}, 0.0, duration_s), (State{0.0, 0.0}));
    for (const GreyBoxKind* kind : {&outflow_kind(), &overflow_kind()}) {
      const State rest = after(*kind, tanks, {0.0, 0.0}, 0.0, duration_s);
      EXPECT_NEAR(rest[0], 0.0, 1e-12);
      EXPECT_NEAR(rest[1], 0.0, 1e-12);
    }
  }
}

TEST(GreyBoxKinds, AreTheirLinearFormForSmallMotions) {
  const std::vector<double> tanks{0.5, 3.0, 2.0, 4.0, 3.0, 2.0, 0.5};
  const double small = 1e-5;
  for (const GreyBoxKind* kind : {&outflow_kind(), &overflow_kind()}) {
    const LinearForm g = kind->linearised(tanks);
    const double gain = g.gain / g.denominator[0];
    for (const double t : {1.0, 5.0, 60.0}) {
      const double shape = 1.0 - (3.0 * std::exp(-t / 3.0) - 2.0 * std::exp(-t / 2.0));
      EXPECT_NEAR(after(*kind, tanks, {0.0, 0.0}, small, t, 60)[0], small * gain * shape, 2e-5 * small * gain)
          << kind->name << ' ' << t;
    }
  }
  // Beyond its friction a mass moves as without it under a smaller input.
  const State moved = after(friction_kind(), {0.5, 0.2, 0.1}, {0.0, 0.0}, 0.6, 1.0);
  EXPECT_NEAR(moved[0], 0.5 * 0.5 * (1.0 - 0.2 * (1.0 - std::exp(-5.0))), 1e-12);
}

TEST(Friction, HoldsUpToItsLevelAndStopsWhatMoved) {
  const std::vector<double> values{0.5, 0.2, 0.1};
  EXPECT_EQ(after(friction_kind(), values, {0.0, 0.0}, 0.1, 1.0), (State{0.0, 0.0}));
  EXPECT_EQ(after(friction_kind(), values, {0.0, 0.0}, -0.1, 1.0), (State{0.0, 0.0}));
  const State stopped = after(friction_kind(), values, {0.0, 0.3}, 0.0, 5.0);
  EXPECT_EQ(stopped[1], 0.0);
  // From w0 to 0 under the target -c: t = T ln(1 + w0/c), z = w0 T - c t.
  const double c = 0.05;
  EXPECT_NEAR(stopped[0], 0.3 * 0.2 - c * 0.2 * std::log1p(0.3 / c), 1e-14);
}

TEST(Friction, IsExactHoweverTheTimeIsCut) {
  const std::vector<double> values{-0.5, 0.2, 0.1};
  for (const double v : {0.4, -0.4, 0.05}) {
    const State once = after(friction_kind(), values, {1.0, 0.3}, v, 2.0);
    const State often = after(friction_kind(), values, {1.0, 0.3}, v, 2.0, 1000);
    EXPECT_NEAR(once[0], often[0], 1e-12) << v;
    EXPECT_NEAR(once[1], often[1], 1e-12) << v;
  }
  // A negative gain moves against its input.
  EXPECT_LT(after(friction_kind(), values, {0.0, 0.0}, 0.4, 1.0)[0], 0.0);
}

TEST(Outflow, EmptiesAsTorricelliSays) {
  // The inflow stopped: x1' = -k1 sqrt x1, so sqrt x1 falls in a straight line, to 0 at T = upper_s.
  const std::vector<double> values{1.0, 3.0, 2.0, 4.0};
  const double flow = 2.0 * 4.0 / 2.0;
  const double upper = 0.5 * flow * 3.0;
  const State half = after(outflow_kind(), values, {0.0, 0.0}, -flow, 1.5, 20);
  const double root = std::sqrt(upper) * (1.0 - 1.5 / 3.0);
  EXPECT_NEAR(half[1] + upper, root * root, 1e-6);
  EXPECT_NEAR(after(outflow_kind(), values, {0.0, 0.0}, -flow, 100.0, 200)[1] + upper, 0.0, 1e-4);
}

TEST(Outflow, IsOneTankWhereTheOtherIsFarTooQuickForTheTimeOfACall) {
  // x' = flow + v - k sqrt x by small steps, of which the input stops the inflow in between.
  const double level = 4.0;
  const double slow_s = 60.0;
  const double flow = 2.0 * level / slow_s;
  double x = level;
  State quick_upper{0.0, 0.0};
  for (int row = 0; row < 60; ++row) {
    const double v = row % 20 < 8 ? -flow : 1.5 * flow;
    for (int step = 0; step < 5000; ++step) {
      x = std::max(0.0, x + 1e-3 * (flow + v - flow / std::sqrt(level) * std::sqrt(x)));
    }
    quick_upper = after(outflow_kind(), {1.0, 1e-3, slow_s, level}, quick_upper, v, 5.0);
    EXPECT_NEAR(quick_upper[0] + level, x, 2e-3) << row;
  }
}

TEST(Outflow, KeepsWhatAQuickTankHolds) {
  // A lag of a tenth of a call or less: the area between it and none is its time constant.
  for (const double quick_s : {0.45, 0.2, 0.05}) {
    State once{0.0, 0.0};
    State often{0.0, 0.0};
    for (int row = 0; row < 12; ++row) {
      const double v = row % 4 < 2 ? 0.1 : -0.08;
      once = after(outflow_kind(), {1.0, quick_s, 60.0, 4.0}, once, v, 5.0);
      often = after(outflow_kind(), {1.0, quick_s, 60.0, 4.0}, often, v, 5.0, 1000);
      EXPECT_NEAR(once[0], often[0], 2e-3) << quick_s << " " << row;
      EXPECT_NEAR(once[1], often[1], 2e-3) << quick_s << " " << row;
      const State lower = after(outflow_kind(), {1.0, 60.0, quick_s, 4.0}, once, v, 5.0);
      EXPECT_NEAR(lower[0], after(outflow_kind(), {1.0, 60.0, quick_s, 4.0}, once, v, 5.0, 1000)[0], 2e-2) << row;
    }
  }
}

TEST(Outflow, OverflowsAtItsTop) {
  const std::vector<double> values{1.0, 3.0, 2.0, 4.0, 3.0, 2.0, 0.5};
  const State full = after(overflow_kind(), values, {0.0, 0.0}, 100.0, 50.0, 500);
  EXPECT_NEAR(full[0], 3.0, 1e-9);
  EXPECT_NEAR(full[1], 2.0, 1e-9);
  // What the upper tank spills into the lower one raises it: without a share it stays below.
  std::vector<double> dry = values;
  dry[6] = 1e-9;
  dry[4] = 1e3;
  std::vector<double> wet = dry;
  wet[6] = 0.5;
  EXPECT_GT(after(overflow_kind(), wet, {0.0, 0.0}, 10.0, 20.0, 200)[0],
            after(overflow_kind(), dry, {0.0, 0.0}, 10.0, 20.0, 200)[0] + 0.1);
}

TEST(Outflow, FindsTheInstantAtWhichATankIsFull) {
  const std::vector<double> values{1.0, 30.0, 20.0, 4.0, 1.0, 2.0, 0.6};
  for (const double v : {0.3, 1.0}) {
    State once{0.0, 0.0};
    State often{0.0, 0.0};
    for (int row = 0; row < 10; ++row) {
      once = after(overflow_kind(), values, once, v, 4.0);
      often = after(overflow_kind(), values, often, v, 4.0, 200);
      EXPECT_NEAR(once[0], often[0], 1e-4) << v << ' ' << row;
      EXPECT_NEAR(once[1], often[1], 1e-4) << v << ' ' << row;
    }
  }
}

TEST(Outflow, IsFineEnoughInOneStep) {
  const std::vector<double> values{1.0, 30.0, 20.0, 4.0};
  const State once = after(outflow_kind(), values, {1.0, -2.0}, 0.1, 4.0);
  const State often = after(outflow_kind(), values, {1.0, -2.0}, 0.1, 4.0, 100);
  EXPECT_NEAR(once[0], often[0], 2e-6);
  EXPECT_NEAR(once[1], often[1], 2e-6);
}

}  // namespace
}  // namespace eha::ident
