// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/edge_thinning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/valve_map.hpp"

namespace eha::ident {
namespace {

const ValveMap kMap{0.1, 0.4, 0.8};

/// Two tones with noise, which crosses the edges slowly here and several times within a window there.
Eigen::VectorXd drive(Eigen::Index rows) {
  PortableDraw draw(7);
  return Eigen::VectorXd::NullaryExpr(rows, [&](Eigen::Index n) {
    const auto t = static_cast<double>(n);
    return 1.5 * std::cos(0.011 * t) + 0.8 * std::sin(0.003 * t) + 0.02 * draw.normal();
  });
}

TEST(EdgeThinning, EqualsTheFilteredFunction) {
  const Eigen::VectorXd u = drive(100);
  const Thinning thinning{{0.1, 0.5, 0.3, -0.2}, 3, 1, {1.0, 2.0, 1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
                                                        1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
                                                        1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 3.0}};
  const EdgeThinning edges(u, thinning);
  const auto expect = [&](const Eigen::VectorXd& out, double (*function)(double, double), double edge) {
    for (std::size_t k = 0; k < thinning.weights.size(); ++k) {
      double sum = 0.0;
      for (std::size_t t = 0; t < thinning.taps.size(); ++t) {
        const auto n = static_cast<std::ptrdiff_t>(3 * k + 1) - static_cast<std::ptrdiff_t>(t);
        if (n >= 0) sum += thinning.taps[t] * function(u[std::min<std::ptrdiff_t>(n, 99)], edge);
      }
      EXPECT_NEAR(out[static_cast<Eigen::Index>(k)], thinning.weights[k] * sum, 1e-14) << k << ", " << edge;
    }
  };
  for (const double edge : {-3.0, -0.3, 0.0, 0.7, u[40], 3.0}) {
    expect(
        edges.excess_above(edge), [](double x, double e) { return std::max(x - e, 0.0); }, edge);
    expect(
        edges.excess_below(edge), [](double x, double e) { return std::min(x - e, 0.0); }, edge);
    expect(
        edges.is_above(edge), [](double x, double e) { return x > e ? 1.0 : 0.0; }, edge);
    expect(
        edges.is_below(edge), [](double x, double e) { return x < e ? 1.0 : 0.0; }, edge);
  }
}

/// Largest difference of the spectra, relative to the largest value.
double difference(const InputSpectrum& a, const InputSpectrum& b) {
  double largest = 0.0;
  double size = 0.0;
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t j = 0; j < a.size(); ++j) {
    largest = std::max(largest, std::abs(a[j] - b[j]));
    size = std::max(size, std::abs(b[j]));
  }
  return largest / size;
}

TEST(EdgeThinning, GivesTheSpectrumOfTheWholeInput) {
  // Every row compared, every 40th behind a filter, and the same after a past at rest.
  for (const auto& [every, before] : {std::pair<std::size_t, std::size_t>{1, 0}, {40, 0}, {40, 1234}}) {
    const Eigen::VectorXd u = drive(6000);
    const Comparison comparison = compare_every(6000, every, 0);
    OutputSelection selection;
    selection.samples = before + 6000;
    selection.step_s = 0.001;
    selection.first = before + comparison.first;
    selection.every = comparison.every;
    selection.count = comparison.count;
    selection.filter_taps = comparison.taps;
    const HeldResponse response(selection);
    const EdgeThinning edges = response.edge_thinning(u, before);
    const auto whole = [&](const Eigen::VectorXd& part) {
      Eigen::VectorXd padded = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(before) + part.size());
      padded.tail(part.size()) = part;
      return response.input_spectrum(padded);
    };
    const double up = upper_edge(kMap);
    const double down = lower_edge(kMap);
    EXPECT_LT(
        difference(response.thinned_input_spectrum(edges.excess_above(up)), whole((u.array() - up).cwiseMax(0.0))),
        1e-10);
    EXPECT_LT(
        difference(response.thinned_input_spectrum(edges.excess_below(down)), whole((u.array() - down).cwiseMin(0.0))),
        1e-10);
    EXPECT_LT(difference(response.thinned_input_spectrum(edges.is_above(up)), whole(is_above(kMap, u))), 1e-10);
  }
}

}  // namespace
}  // namespace eha::ident
