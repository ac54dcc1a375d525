// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/poles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace {

using namespace eha::ident;
using Complex = std::complex<double>;
using std::numbers::pi;

double distance_to_nearest(const std::vector<Complex>& values, Complex wanted) {
  double least = 1e300;
  for (const Complex& value : values) least = std::min(least, std::abs(value - wanted));
  return least;
}

TEST(Poles, AreThoseOfAnIntegerModel) {
  // s (s + 2)(s^2 + 2 s + 5)
  const Poles found = poles({{{1.0, 0.0}}, {{1.0, 4.0}, {4.0, 3.0}, {9.0, 2.0}, {10.0, 1.0}}, 0.0});
  EXPECT_TRUE(found.is_commensurate);
  EXPECT_EQ(found.base_order, 1.0);
  EXPECT_EQ(found.order_at_zero, 1.0);
  ASSERT_EQ(found.values.size(), 3U);
  for (const Complex& pole : {Complex(-2.0, 0.0), Complex(-1.0, 2.0), Complex(-1.0, -2.0)}) {
    EXPECT_LT(distance_to_nearest(found.values, pole), 1e-10);
  }
}

TEST(Poles, OfUnrelatedOrdersAreThoseOfTheirNeighbourWithABaseOrder) {
  const Poles whole = poles({{{1.0, 0.0}}, {{0.8, 2.2}, {0.5, 0.9}, {1.0, 0.0}}, 0.0});
  const Poles off = poles({{{1.0, 0.0}}, {{0.8, 2.2}, {0.5, 0.9 + 1e-7}, {1.0, 0.0}}, 0.0});
  ASSERT_TRUE(whole.is_commensurate);
  ASSERT_FALSE(off.is_commensurate);
  EXPECT_TRUE(off.is_complete);
  EXPECT_NEAR(whole.base_order, 0.1, 1e-12);
  EXPECT_EQ(whole.values.size(), 22U);
  std::size_t on_principal_sheet = 0;
  for (const Complex& w : whole.values) {
    if (std::abs(std::arg(w)) >= 0.1 * pi) continue;
    ++on_principal_sheet;
    EXPECT_LT(distance_to_nearest(off.values, std::polar(std::pow(std::abs(w), 10.0), 10.0 * std::arg(w))), 1e-5);
  }
  EXPECT_EQ(off.values.size(), on_principal_sheet);
}

TEST(Poles, FarApartAreAllFound) {
  // Nearly (s + 0.001)(s + 500), with orders that have no base.
  const Poles found = poles({{{1.0, 0.0}}, {{1.0, 2.0 + 1e-5}, {500.0, 1.0 + 3e-6}, {0.5, 0.0}}, 0.0});
  EXPECT_FALSE(found.is_commensurate);
  EXPECT_TRUE(found.is_complete);
}

TEST(Poles, OfAnIntegratorRoundedByASearchCountAsAtZero) {
  const Poles found = with_rounded_at_zero(poles({{{1.0, 0.0}}, {{0.05, 2.0}, {1.0, 1.0}, {4e-13, 0.0}}, 0.0}));
  EXPECT_EQ(found.order_at_zero, 1.0);
  ASSERT_EQ(found.values.size(), 1U);
  EXPECT_NEAR(found.values.front().real(), -20.0, 1e-9);
  const Poles slow = with_rounded_at_zero(poles({{{1.0, 0.0}}, {{0.05, 2.0}, {1.0, 1.0}, {4e-6, 0.0}}, 0.0}));
  EXPECT_EQ(slow.order_at_zero, 0.0) << "of three days";
  EXPECT_EQ(slow.values.size(), 2U);
}

TEST(Poles, OfAPureGainAreNone) { EXPECT_TRUE(poles({{{2.0, 0.0}}, {{1.0, 0.0}}, 0.0}).values.empty()); }

}  // namespace
