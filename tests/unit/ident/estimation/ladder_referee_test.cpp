// SPDX-License-Identifier: GPL-3.0-or-later
//
// The ladder as a referee between integer and fractional orders, with and without a valve's map: 600 records of known
// truth, 1000 rows each. Arguments, both optional: the seed of the records, and how many of each kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <mutex>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "hal/sim/cylinder.hpp"
#include "ident/estimation/ladder.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/fractional/stability.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using synthetic::normal;
using synthetic::uniform;

std::uint64_t first_seed = 1;
int records_of_a_kind = 200;

constexpr Eigen::Index kRows = 1000;
constexpr double kStep_s = 0.04;

enum class Truth { integer, fractional, valve };

struct Case {
  Record record;
  Truth truth;
  bool is_coloured = false;
  double rarer_side = 0.0;  ///< share of the estimating samples beyond the rarer side of the dead band
};

double between(double low, double high, std::mt19937_64& draw) { return low + (high - low) * uniform(draw); }
double log_between(double low, double high, std::mt19937_64& draw) {
  return std::exp(between(std::log(low), std::log(high), draw));
}

/// Levels of random height, each held for 0.4 s to 2.4 s.
Eigen::VectorXd levels(double peak, std::mt19937_64& draw) {
  Eigen::VectorXd u(kRows);
  for (Eigen::Index k = 0; k < kRows;) {
    const double level = between(-peak, peak, draw);
    const auto end = std::min(kRows, k + static_cast<Eigen::Index>(between(10.0, 60.0, draw)));
    for (; k < end; ++k) u[k] = level;
  }
  return u;
}

/// Four tones of 0.05 to 1 Hz with random phases.
Eigen::VectorXd tones(double peak, std::mt19937_64& draw) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(kRows);
  for (const double lowest_Hz : {0.05, 0.15, 0.3, 0.6}) {
    const double frequency_Hz = lowest_Hz * between(1.0, 1.8, draw);
    const double phase = between(0.0, 2.0 * std::numbers::pi, draw);
    for (Eigen::Index k = 0; k < kRows; ++k) {
      u[k] += std::cos(2.0 * std::numbers::pi * frequency_Hz * kStep_s * static_cast<double>(k) + phase);
    }
  }
  return u * (peak / u.cwiseAbs().maxCoeff());
}

/// White noise, or first-order autoregressive noise with a pole at 0.9, of a share of the output's spread.
void add_noise(Case& c, std::mt19937_64& draw) {
  Eigen::VectorXd& y = c.record.output;
  const double spread = std::sqrt((y.array() - y.mean()).square().mean());
  const double size = log_between(0.001, 0.02, draw) * spread;
  const double pole = c.is_coloured ? 0.9 : 0.0;
  double e = normal(draw);
  for (double& value : y) {
    value += size * e;
    e = pole * e + std::sqrt(1.0 - pole * pole) * normal(draw);
  }
}

Case linear_case(const TransferFunction& g, Truth truth, std::mt19937_64& draw) {
  Case c{.record = {}, .truth = truth};
  c.record.step_s = kStep_s;
  c.record.input = levels(3.0, draw);
  const Eigen::VectorXd driving = c.record.input.array() + between(-0.3, 0.3, draw);
  c.record.output = simulate(g, driving, kStep_s).array() + between(-2.0, 2.0, draw);
  return c;
}

/// K/(a2 s^2 + s + a0) with a dominant mode within the record's band.
Case integer_case(std::mt19937_64& draw) {
  const double w = log_between(0.8, 8.0, draw);
  const double damping = log_between(0.3, 2.0, draw);
  const double a2 = 1.0 / (2.0 * damping * w);
  return linear_case({{{1.0, 0.0}}, {{a2, 2.0}, {1.0, 1.0}, {w / (2.0 * damping), 0.0}}, 0.0}, Truth::integer, draw);
}

/// The same with orders 0.1 to 0.4 off whole numbers, stable.
Case fractional_case(std::mt19937_64& draw) {
  for (;;) {
    const double w = log_between(0.8, 8.0, draw);
    const double damping = log_between(0.3, 2.0, draw);
    const double n2 = 2.0 - between(0.1, 0.4, draw);
    const double n1 = 1.0 + (uniform(draw) < 0.5 ? -1.0 : 1.0) * between(0.1, 0.4, draw);
    const TransferFunction g{
        {{1.0, 0.0}},
        {{std::pow(w, n1 - n2) / (2.0 * damping), n2}, {1.0, n1}, {std::pow(w, n1) / (2.0 * damping), 0.0}},
        0.0};
    if (n2 - n1 < 0.3 || !stability(g).stable) continue;
    return linear_case(g, Truth::fractional, draw);
  }
}

/// The simulated rig: dead band, null, two gains and friction drawn anew, sampled every 40 ms.
Case valve_case(std::mt19937_64& draw) {
  hal::SimOptions rig;
  rig.valve_dead_band_V = between(0.05, 0.5, draw);
  rig.valve_null_offset_V = between(-0.4, 0.4, draw);
  rig.rod_mm = between(12.0, 26.0, draw);
  rig.coulomb_friction_N = between(60.0, 240.0, draw);
  rig.static_friction_N = rig.coulomb_friction_N * between(1.0, 1.6, draw);
  rig.supply_pressure_bar = between(55.0, 90.0, draw);
  rig.moving_mass_kg = between(10.0, 40.0, draw);
  Case c{.record = {}, .truth = Truth::valve};
  c.record.step_s = kStep_s;
  // Tones about the null: levels would run the rod into an end stop.
  c.record.input = tones(between(1.0, 3.5, draw), draw).array() - rig.valve_null_offset_V;
  c.record.output.resize(kRows);
  hal::Cylinder cylinder(rig);
  constexpr double kMetresAnInch = 0.0254;
  for (Eigen::Index k = 0; k < kRows; ++k) {
    c.record.output[k] = cylinder.state().displacement_m / kMetresAnInch;
    cylinder.advance(c.record.input[k], hal::Ports::open, kStep_s);
  }
  const auto estimating = c.record.input.head(kRows / 2).array() + rig.valve_null_offset_V;
  const auto share = [](Eigen::Index count) { return static_cast<double>(count) / static_cast<double>(kRows / 2); };
  c.rarer_side = std::min(share((estimating > rig.valve_dead_band_V).count()),
                          share((estimating < -rig.valve_dead_band_V).count()));
  return c;
}

Case case_number(int number) {
  std::mt19937_64 draw(1000 * first_seed + static_cast<std::uint64_t>(number));
  const int kind = number % 3;
  Case c = kind == 0 ? integer_case(draw) : kind == 1 ? fractional_case(draw) : valve_case(draw);
  c.is_coloured = number / 3 % 2 == 1;
  add_noise(c, draw);
  return c;
}

struct Found {
  bool fractional = false;
  bool map = false;
  Recommendation recommendation;
};

Found found_in(const Case& c) {
  const PreparedRecord prepared(c.record, {});
  const Climb climbed =
      climb(prepared, {}, {}, {},
            [&](const StructureOptions& asked, const FitOptions& options, const std::vector<Model>& known) {
              return fit(prepared, asked, options, run_in_order, known);
            });
  Found found{.recommendation = climbed.recommendation};
  for (const ClimbedModel& m : climbed.models) {
    if (m.result.model.name != climbed.recommendation.model) continue;
    found.fractional = has_estimated_order(m.result.model);
    found.map = m.result.model.input_map.has_value();
  }
  return found;
}

/// A share with its counts, for messages.
struct Share {
  int count = 0;
  int of = 0;
  void add(bool is_one) {
    ++of;
    count += is_one ? 1 : 0;
  }
  [[nodiscard]] double percent() const { return of == 0 ? 0.0 : 100.0 * count / of; }
};

std::ostream& operator<<(std::ostream& out, const Share& share) {
  return out << share.count << " of " << share.of << " (" << share.percent() << " %)";
}

TEST(LadderReferee, TellsIntegerFromFractionalOrdersAndFindsTheValve) {
  const int records = 3 * records_of_a_kind;
  std::vector<Found> found(static_cast<std::size_t>(records));
  std::vector<Case> cases(static_cast<std::size_t>(records));
  std::atomic<int> next{0};
  {
    std::vector<std::jthread> threads;
    for (unsigned t = 0; t < std::max(1U, std::thread::hardware_concurrency()); ++t) {
      threads.emplace_back([&] {
        for (int k = next++; k < records; k = next++) {
          cases[static_cast<std::size_t>(k)] = case_number(k);
          found[static_cast<std::size_t>(k)] = found_in(cases[static_cast<std::size_t>(k)]);
        }
      });
    }
  }
  Share false_fractional;
  Share true_fractional;
  Share map;
  Share false_map;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const bool is_fractional = cases[k].truth == Truth::fractional;
    (is_fractional ? true_fractional : false_fractional).add(found[k].fractional);
    if (cases[k].truth == Truth::valve && cases[k].rarer_side >= 0.15) map.add(found[k].map);
    if (cases[k].truth != Truth::valve) false_map.add(found[k].map);
    const bool is_wrong = found[k].fractional != is_fractional || (cases[k].truth == Truth::valve) != found[k].map;
    if (is_wrong) {
      std::cout << "record " << k << (cases[k].is_coloured ? ", AR noise" : ", white noise") << ", truth "
                << (is_fractional                    ? "fractional"
                    : cases[k].truth == Truth::valve ? "valve"
                                                     : "integer")
                << ": " << sentence(found[k].recommendation) << "\n";
    }
  }
  std::cout << static_cast<double>(std::clock()) / CLOCKS_PER_SEC << " processor seconds\n";
  std::cout << "seed " << first_seed << ": fractional where false " << false_fractional << ", where true "
            << true_fractional << "; map where its rarer side has 15 % " << map << ", where there is none " << false_map
            << "\n";
  EXPECT_LE(false_fractional.percent(), 5.0);
  EXPECT_GE(true_fractional.percent(), 90.0);
  EXPECT_GE(map.of, records_of_a_kind / 2);
  EXPECT_GE(map.percent(), 90.0);
}

}  // namespace

void set_first_seed(std::uint64_t seed) { first_seed = seed; }
void set_records_of_a_kind(int records) { records_of_a_kind = records; }

}  // namespace eha::ident

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) eha::ident::set_first_seed(std::strtoull(argv[1], nullptr, 10));
  if (argc > 2) eha::ident::set_records_of_a_kind(std::atoi(argv[2]));
  return RUN_ALL_TESTS();
}
