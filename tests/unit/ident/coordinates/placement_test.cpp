// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "ident/coordinates/parametrisation.hpp"

namespace eha::ident {
namespace {

constexpr Parametrisation::Scale kScale{50.0, 0.04, -5.0, 5.0};

std::complex<double> denominator(const TransferFunction& g, double frequency_Hz) {
  const std::complex<double> s(0.0, 2.0 * std::numbers::pi * frequency_Hz);
  std::complex<double> d = 0.0;
  for (const Term& term : g.denominator) d += term.coefficient * std::pow(s, term.order);
  return d;
}

/// Expects that the parametrisation has a place where its G is g but for the gain, at frequencies that a record holds.
void expect_place(const Structure& structure, const TransferFunction& g) {
  const StructureOptions asked{.structure = structure};
  const Parametrisation parametrisation = Parametrisation::search(asked, kScale);
  const auto theta = parametrisation.at_model(g, 0.0, {});
  ASSERT_TRUE(theta) << structure.family;
  const TransferFunction placed = parametrisation.transfer_function(*theta, {});
  const std::complex<double> gain = denominator(placed, 0.1) / denominator(g, 0.1);
  for (const double frequency_Hz : {0.02, 0.5, 5.0}) {
    const std::complex<double> ratio = denominator(placed, frequency_Hz) / denominator(g, frequency_Hz) / gain;
    EXPECT_NEAR(std::abs(ratio - 1.0), 0.0, 2e-3) << structure.family << " at " << frequency_Hz << " Hz";
  }
}

TEST(Placement, HasAPlaceForEveryModelInsideAStructure) {
  const TransferFunction integrator{{{1.0, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  const TransferFunction one_pole{{{1.0, 0.0}}, {{1.0, 1.0}, {0.7, 0.0}}, 0.0};
  const TransferFunction oscillating{{{1.0, 0.0}}, {{0.5, 2.0}, {1.0, 1.0}, {3.0, 0.0}}, 0.0};
  const TransferFunction slow_and_fast{{{1.0, 0.0}}, {{0.01, 2.0}, {1.0, 1.0}, {0.2, 0.0}}, 0.0};
  const TransferFunction lag{{{1.0, 0.0}}, {{1.0, 0.8}, {0.7, 0.0}}, 0.0};
  using namespace structures;
  for (const TransferFunction& g : {integrator, one_pole, oscillating, slow_and_fast}) {
    expect_place(io(), g);
    expect_place(io3(), g);
    expect_place(fo(), g);
    expect_place(commensurate({3, 0}), g);
  }
  expect_place(integrator_lag(), integrator);
  expect_place(cylinder(), integrator);
  expect_place(cylinder(), {{{1.0, 0.0}}, {{0.03, 3.0}, {0.05, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0});
  expect_place(fo(), lag);
  expect_place(commensurate({2, 0}), lag);
}

TEST(Placement, HasNoneForAModelOutsideTheStructure) {
  const TransferFunction fo{{{1.0, 0.0}}, {{0.5, 1.7}, {1.0, 0.9}, {0.3, 0.0}}, 0.0};
  const TransferFunction delayed{{{1.0, 0.0}}, {{1.0, 1.0}, {0.7, 0.0}}, 0.5};
  const auto place = [](Structure structure, const TransferFunction& g, const std::optional<ValveMap>& map = {}) {
    return Parametrisation::search({.structure = std::move(structure)}, kScale).at_model(g, 0.0, map).has_value();
  };
  EXPECT_FALSE(place(structures::io(), fo));
  EXPECT_FALSE(place(structures::lag(), fo));
  EXPECT_FALSE(place(structures::cylinder(), {{{1.0, 0.0}}, {{0.5, 2.0}, {1.0, 1.0}, {3.0, 0.0}}, 0.0}));
  EXPECT_FALSE(place(structures::io1(), delayed));
  EXPECT_FALSE(place(structures::fo(), fo, ValveMap{0.0, 0.1, 1.0}));
  EXPECT_TRUE(place(structures::behind_valve(structures::fo()), fo, ValveMap{0.0, 0.1, 1.0}));
  Structure free_delay = structures::io();
  free_delay.delay.freedom = Freedom::free;
  EXPECT_TRUE(place(free_delay, delayed));
}

TEST(Placement, PutsTheNullOfAMapAtTheBiasOfAModelWithoutOne) {
  const StructureOptions asked{.structure = structures::behind_valve(structures::io1())};
  const Parametrisation parametrisation = Parametrisation::search(asked, kScale);
  const auto theta = parametrisation.at_model({{{1.0, 0.0}}, {{1.0, 1.0}, {0.7, 0.0}}, 0.0}, 0.3, {});
  ASSERT_TRUE(theta);
  const auto map = parametrisation.valve(*theta);
  ASSERT_TRUE(map);
  EXPECT_DOUBLE_EQ(map->null, -0.3);
  EXPECT_EQ(map->dead_band, 0.0);
}

}  // namespace
}  // namespace eha::ident
