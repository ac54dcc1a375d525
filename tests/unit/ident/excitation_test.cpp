// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/excitation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

using Vector = Eigen::VectorXd;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

Excitation tones(std::vector<Tone> list) { return {.kind = Multisine{std::move(list)}}; }
Excitation paper() { return tones({{0.05, 1.9, 0.3}, {0.2, 1.6, 1.9}, {0.65, 1.5, 4.2}}); }
Excitation sine(std::vector<Tone> list) { return {.kind = Sine{std::move(list)}}; }

template <class Kind>
Excitation band(double low_Hz, double high_Hz, std::uint64_t seed = 1, double amplitude_V = 3.0) {
  Kind kind{.amplitude_V = amplitude_V, .band = {low_Hz, high_Hz}};
  if constexpr (requires { kind.seed; }) kind.seed = seed;
  return {.kind = kind};
}

Excitation prms(int levels, double hold_s, std::uint64_t seed = 1, double amplitude_V = 3.0) {
  return {.kind = Prms{.amplitude_V = amplitude_V, .levels = levels, .hold_s = hold_s, .seed = seed}};
}

Excitation step(double hold_s, double amplitude_V = 3.0) {
  return {.kind = Step{.amplitude_V = amplitude_V, .hold_s = hold_s}};
}

/// Amplitude of one harmonic of a table that is one period, by the sum that defines it.
double line_amplitude(const Vector& table, Eigen::Index harmonic) {
  std::complex<double> sum = 0.0;
  const Eigen::Index count = table.size();
  for (Eigen::Index k = 0; k < count; ++k) {
    sum += table(k) * std::polar(1.0, -kTwoPi * static_cast<double>(harmonic * k % count) / static_cast<double>(count));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(count);
}

TEST(PortableDraw, GivesTheNumbersTheStandardFixesForTheGenerator) {
  // [rand.predef]: the 10000th draw of a default-seeded mt19937_64 (seed 5489) is 9981545732273789042.
  PortableDraw draw(5489);
  double last = 0.0;
  for (int i = 0; i < 10000; ++i) last = draw.uniform();
  EXPECT_EQ(last, static_cast<double>(9981545732273789042ULL >> 11U) * 0x1p-53);
}

TEST(PortableDraw, IsUniformAndNormalInItsFirstMoments) {
  PortableDraw draw(3);
  constexpr int kDraws = 100000;
  double sum = 0.0;
  double squares = 0.0;
  std::array<int, 3> counts{};
  for (int i = 0; i < kDraws; ++i) {
    const double value = draw.normal();
    sum += value;
    squares += value * value;
    ++counts[draw.below(3)];
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5.0 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5.0 * std::sqrt(2.0 / kDraws));
  for (const int count : counts) EXPECT_NEAR(count, kDraws / 3.0, 5.0 * std::sqrt(kDraws * 2.0 / 9.0));
}

TEST(Multisine, IsTheSumOfItsTonesPlusTheOffset) {
  Excitation options = paper();
  options.offset_V = 0.25;
  const Vector table = excitation(options, 0.001, 50000);
  ASSERT_EQ(table.size(), 50000);
  for (const Eigen::Index k : {0, 1, 777, 49999}) {
    const double t = static_cast<double>(k) / 1000.0;
    const double expected = 0.25 + 1.9 * std::cos(kTwoPi * 0.05 * t + 0.3) + 1.6 * std::cos(kTwoPi * 0.2 * t + 1.9) +
                            1.5 * std::cos(kTwoPi * 0.65 * t + 4.2);
    EXPECT_NEAR(table(k), expected, 1e-12);
  }
  EXPECT_EQ(excited_lines(options, 0.001, 50000), (std::vector<double>{0.05, 0.2, 0.65}));
}

TEST(Multisine, SuperposesItsTones) {
  const Excitation all = paper();
  Vector sum = Vector::Zero(1000);
  for (const Tone& tone : std::get<Multisine>(all.kind).tones) sum += excitation(sine({tone}), 0.01, 1000);
  EXPECT_LT((excitation(all, 0.01, 1000) - sum).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(CrestFactor, IsTheSquareRootOfTwoForASineAndOneForASquareWave) {
  Excitation shifted = sine({{1.0, 2.5, 0.0}});
  shifted.offset_V = 4.0;
  EXPECT_NEAR(crest_factor(excitation(shifted, 0.001, 1000)), std::numbers::sqrt2, 1e-12);
  EXPECT_NEAR(crest_factor(Eigen::Vector4d(1, -1, -1, 1)), 1.0, 1e-15);
}

TEST(CrestFactor, RefusesASignalWithoutVariation) {
  EXPECT_THROW((void)crest_factor(Vector(0)), DataError);
  EXPECT_THROW((void)crest_factor(Vector::Constant(9, 0.1)), DataError);
}

TEST(OddRandomMultisine, ExcitesThreeOfEachFourOddHarmonicsOfTheBandAndNothingElse) {
  const Excitation options = band<OddRandomMultisine>(0.1, 3.2);
  const Vector table = excitation(options, 0.01, 1000);  // 10 s: harmonics of 0.1 Hz, odd ones 1, 3, .. 31
  std::set<Eigen::Index> excited;
  for (const double line_Hz : excited_lines(options, 0.01, 1000)) excited.insert(std::lround(line_Hz * 10.0));
  EXPECT_EQ(excited.size(), 12U);
  double common = 0.0;
  for (Eigen::Index k = 0; k <= 500; ++k) {
    const double amplitude = line_amplitude(table, k);
    if (excited.contains(k)) {
      EXPECT_EQ(k % 2, 1);
      if (common == 0.0) common = amplitude;
      EXPECT_NEAR(amplitude, common, 1e-12);
    } else {
      EXPECT_LT(amplitude, 1e-12) << "harmonic " << k;
    }
  }
  EXPECT_GT(common, 0.1);
  for (int group = 0; group < 4; ++group) {
    int silent = 0;
    for (int i = 0; i < 4; ++i) silent += excited.contains(8 * group + 2 * i + 1) ? 0 : 1;
    EXPECT_EQ(silent, 1);
  }
}

TEST(OddRandomMultisine, HasItsPeakAndALowCrestFactor) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Vector table = excitation(band<OddRandomMultisine>(0.05, 5.0, seed), 0.01, 2000);
    EXPECT_NEAR(table.cwiseAbs().maxCoeff(), 3.0, 1e-12);
    EXPECT_LT(crest_factor(table), 2.6) << "seed " << seed;
  }
}

TEST(OddRandomMultisine, PlaysRealisationsOfTheSameLinesOneAfterTheOther) {
  Excitation options = band<OddRandomMultisine>(0.1, 3.2);
  auto& kind = std::get<OddRandomMultisine>(options.kind);
  kind.realisations = 4;
  kind.periods = 3;
  const Vector table = excitation(options, 0.01, 12000);
  EXPECT_NEAR(table.cwiseAbs().maxCoeff(), 3.0, 1e-12);
  EXPECT_EQ(excited_lines(options, 0.01, 12000), excited_lines(band<OddRandomMultisine>(0.1, 3.2), 0.01, 1000));
  ASSERT_TRUE(realisations_of(options));
  EXPECT_EQ(realisations_of(options)->count, 4U);
  double amplitude = 0.0;
  for (Eigen::Index m = 0; m < 4; ++m) {
    const Vector second = table.segment((3 * m + 1) * 1000, 1000);
    EXPECT_LT((second - table.segment((3 * m + 2) * 1000, 1000)).cwiseAbs().maxCoeff(), 1e-12) << m;
    // Past the fade the transient is the signal already.
    EXPECT_LT((second - table.segment(3 * m * 1000, 1000)).tail(750).cwiseAbs().maxCoeff(), 1e-12) << m;
    const auto line = static_cast<Eigen::Index>(std::lround(excited_lines(options, 0.01, 12000)[2] * 10.0));
    if (m == 0) amplitude = line_amplitude(second, line);
    EXPECT_NEAR(line_amplitude(second, line), amplitude, 1e-12) << m;
    EXPECT_GT((second - table.segment(((3 * m + 4) % 12) * 1000, 1000)).cwiseAbs().maxCoeff(), 0.3) << m;
  }
  // Nothing jumps, not even from the end to the beginning.
  Vector around(table.size() + 1);
  around << table, table[0];
  const double steepest = (around.tail(table.size()) - around.head(table.size())).cwiseAbs().maxCoeff();
  EXPECT_LT(steepest, 0.01 * 2.0 * std::numbers::pi * 3.2 * 3.0 + 0.01 * std::numbers::pi * 3.0 / 2.5);
}

TEST(OddRandomMultisine, DrawsThePhasesOfRealisationsIndependently) {
  // Those chosen for a low peak stay below 2.6.
  double greatest = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Excitation options = band<OddRandomMultisine>(0.05, 5.0, seed);
    auto& kind = std::get<OddRandomMultisine>(options.kind);
    kind.realisations = 4;
    kind.periods = 3;
    const Vector table = excitation(options, 0.01, 24000);
    for (Eigen::Index m = 0; m < 4; ++m) {
      greatest = std::max(greatest, crest_factor(table.segment((3 * m + 1) * 2000, 2000)));
    }
  }
  EXPECT_GT(greatest, 2.8);
}

TEST(OddRandomMultisine, NeedsThreePeriodsOfEachRealisationThatFitTheTable) {
  Excitation options = band<OddRandomMultisine>(0.1, 3.2);
  auto& kind = std::get<OddRandomMultisine>(options.kind);
  kind.realisations = 2;
  EXPECT_EQ(issues_of(options).at(0).key, "periods");
  kind.periods = 3;
  EXPECT_TRUE(issues_of(options).empty());
  EXPECT_TRUE(timing_issues_of(options, 0.01, 60.0).empty());
  EXPECT_EQ(timing_issues_of(options, 0.01, 50.0).at(0).key, "periods");
  EXPECT_THROW((void)excitation(options, 0.01, 5000), ConfigError);
}

TEST(Gaussian, KeepsToItsBandAndItsPeak) {
  const Excitation options = band<Gaussian>(0.5, 2.0);
  const Vector table = excitation(options, 0.01, 1000);
  EXPECT_NEAR(table.cwiseAbs().maxCoeff(), 3.0, 1e-12);
  for (Eigen::Index k = 0; k <= 500; ++k) {
    if (k < 5 || k > 20) {
      EXPECT_LT(line_amplitude(table, k), 1e-12) << "harmonic " << k;
    }
  }
  EXPECT_EQ(excited_lines(options, 0.01, 1000).size(), 16U);
}

TEST(Gaussian, HasTheKurtosisOfANormalDistribution) {
  const Vector table = excitation(band<Gaussian>(0.0, 20.0), 0.01, 20000);
  const Eigen::ArrayXd centred = table.array() - table.mean();
  EXPECT_NEAR(centred.pow(4).mean() / std::pow(centred.square().mean(), 2), 3.0, 0.4);
}

TEST(Prms, HoldsEquidistantLevelsForItsHoldTime) {
  const Vector table = excitation(prms(5, 0.05), 0.001, 10000);
  std::set<double> levels;
  for (Eigen::Index k = 0; k < table.size(); ++k) {
    levels.insert(table(k));
    if (k % 50 != 0) {
      ASSERT_EQ(table(k), table(k - 1));
    }
  }
  EXPECT_EQ(levels, (std::set<double>{-3.0, -1.5, 0.0, 1.5, 3.0}));
}

TEST(Chirp, SweepsFromTheLowestToTheHighestFrequency) {
  const Vector table = excitation(band<Chirp>(1.0, 5.0), 0.001, 10000);
  EXPECT_EQ(table(0), 0.0);
  EXPECT_LE(table.cwiseAbs().maxCoeff(), 3.0);
  // 5 s at 2 Hz on average are 10 periods, each with two sign changes; then 5 s at 4 Hz.
  const auto sign_changes = [&](Eigen::Index from, Eigen::Index to) {
    int changes = 0;
    for (Eigen::Index k = from + 1; k < to; ++k) changes += table(k) * table(k - 1) < 0.0 ? 1 : 0;
    return changes;
  };
  EXPECT_NEAR(sign_changes(0, 5000), 20, 1);
  EXPECT_NEAR(sign_changes(5000, 10000), 40, 1);
}

TEST(Step, StepsAtTheTickOfItsHoldTime) {
  Excitation options = step(0.3);
  options.offset_V = -1.0;
  const Vector table = excitation(options, 0.1, 6);
  EXPECT_EQ(table, (Vector(6) << -1, -1, -1, 2, 2, 2).finished());
}

TEST(Excitation, RepeatsItselfForOneSeedAndDiffersForAnother) {
  const auto repeats = [](const Excitation& first, const Excitation& second) {
    const Vector table = excitation(first, 0.01, 1000);
    EXPECT_EQ(table, excitation(first, 0.01, 1000)) << name_of(first.kind);
    EXPECT_NE(table, excitation(second, 0.01, 1000)) << name_of(first.kind);
    EXPECT_EQ(seed_of(first), 1U);
  };
  repeats(band<OddRandomMultisine>(0.2, 5.0, 1), band<OddRandomMultisine>(0.2, 5.0, 2));
  repeats(band<Gaussian>(0.2, 5.0, 1), band<Gaussian>(0.2, 5.0, 2));
  repeats(prms(7, 0.1, 1), prms(7, 0.1, 2));
  EXPECT_EQ(seed_of(paper()), std::nullopt);
}

TEST(Excitation, ScalesWithItsAmplitude) {
  const auto scales = [](const Excitation& single, const Excitation& twice) {
    const Vector difference = excitation(twice, 0.01, 1000) - 2.0 * excitation(single, 0.01, 1000);
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-12) << name_of(single.kind);
  };
  scales(band<OddRandomMultisine>(0.2, 5.0, 1, 3.0), band<OddRandomMultisine>(0.2, 5.0, 1, 6.0));
  scales(band<Gaussian>(0.2, 5.0, 1, 3.0), band<Gaussian>(0.2, 5.0, 1, 6.0));
  scales(band<Chirp>(0.2, 5.0, 1, 3.0), band<Chirp>(0.2, 5.0, 1, 6.0));
  scales(prms(7, 0.1, 1, 3.0), prms(7, 0.1, 1, 6.0));
  scales(step(0.1, 3.0), step(0.1, 6.0));
}

/// The sum that defines a table of harmonics, each angle reduced to one turn before its cosine is taken.
Vector direct_sum(const std::vector<Harmonic>& lines, std::size_t samples) {
  Vector sum = Vector::Zero(static_cast<Eigen::Index>(samples));
  for (const Harmonic& line : lines) {
    for (std::size_t k = 0; k < samples; ++k) {
      const double turns = static_cast<double>(line.harmonic * k % samples) / static_cast<double>(samples);
      sum(static_cast<Eigen::Index>(k)) += line.amplitude * std::cos(kTwoPi * turns + line.phase_rad);
    }
  }
  return sum;
}

TEST(Harmonics, AreSummedToTheSameVoltsAsCosineByCosine) {
  for (const std::size_t samples : {1000UL, 1009UL, 4096UL}) {  // 1009 is prime
    PortableDraw draw(samples);
    std::vector<Harmonic> lines{{1, 2.0, 0.3}, {1, 0.5, 1.0}};  // one harmonic twice
    for (std::size_t k = 3; k < samples / 2; k += 5) lines.push_back({k, draw.uniform(), kTwoPi * draw.uniform()});
    const Vector expected = direct_sum(lines, samples);
    EXPECT_LT((sum_of(lines, samples) - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
  }
}

TEST(Multisine, HasTheSameVoltsOnTheGridOfItsLengthAsBesideIt) {
  // 0.1 Hz and its multiples have whole periods in 20 s; the others do not and are summed tick by tick.
  std::vector<Tone> list;
  for (int i = 1; i <= 40; ++i) list.push_back({0.1 * i, 1.0 + 0.01 * i, 0.7 * i});
  for (const double frequency_Hz : {0.123, 1.07}) list.push_back({frequency_Hz, 0.5, 0.2});
  Vector expected = Vector::Zero(20000);
  for (const Tone& tone : list) add_tone(tone, 0.001, expected);
  const Vector table = excitation(tones(list), 0.001, 20000);
  EXPECT_LT((table - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(excited_lines(tones(list), 0.001, 20000).size(), 42U);
}

TEST(Multisine, OfAFewTonesIsTheSumOfTheirCosinesToTheLastBit) {
  const Excitation few = paper();
  Vector expected = Vector::Zero(50000);
  for (const Tone& tone : std::get<Multisine>(few.kind).tones) add_tone(tone, 0.001, expected);
  EXPECT_EQ(excitation(few, 0.001, 50000), expected);
}

Excitation table_of(std::vector<double> volts_V, std::optional<double> step_s) {
  return {.kind = Table{.file = {.name = "volts.csv", .volts_V = std::move(volts_V), .step_s = step_s}},
          .offset_V = 0.5};
}

TEST(Table, PlaysItsVoltsAndTheOffset) {
  EXPECT_EQ(excitation(table_of({1.0, -2.0, 0.0}, std::nullopt), 0.1, 3), Eigen::Vector3d(1.5, -1.5, 0.5));
  EXPECT_EQ(excitation(table_of({1.0, -2.0, 0.0}, 0.1), 0.1, 3), Eigen::Vector3d(1.5, -1.5, 0.5));
  EXPECT_TRUE(excited_lines(table_of({1.0, -2.0, 0.0}, 0.1), 0.1, 3).empty());
}

TEST(Table, IsNeverResampled) {
  EXPECT_THROW((void)excitation(table_of({1.0, -2.0, 0.0}, std::nullopt), 0.1, 4), ConfigError);
  EXPECT_THROW((void)excitation(table_of({1.0, -2.0, 0.0}, 0.2), 0.1, 3), ConfigError);
}

TEST(Excitation, JumpsWhereItHoldsALevel) {
  EXPECT_EQ(shortest_level_s(prms(5, 0.4), 10.0), 0.4);
  EXPECT_EQ(shortest_level_s(step(0.4), 10.0), 9.6);
  EXPECT_EQ(shortest_level_s(paper(), 10.0), std::nullopt);
}

TEST(Excitation, RefusesOptionsThatMakeNoSense) {
  const auto refused = [](const Excitation& options, double step_s = 0.01, std::size_t samples = 1000) {
    EXPECT_THROW((void)excitation(options, step_s, samples), ConfigError) << name_of(options.kind);
  };
  refused(paper(), 0.0);
  refused(paper(), -0.1);
  refused(paper(), 0.01, 0);
  refused(tones({}));
  refused(sine({}));
  refused(sine(std::get<Multisine>(paper().kind).tones));
  refused(tones({{0.2, 1.0, 0.0}, {0.0, 1.0, 0.0}}));
  refused(tones({{0.2, std::numeric_limits<double>::quiet_NaN(), 0.0}}));
  refused(band<OddRandomMultisine>(5.0, 5.0));
  refused(band<Gaussian>(5.0, 5.0));
  refused(band<Chirp>(5.0, 5.0));
  refused(band<OddRandomMultisine>(-1.0, 5.0));
  refused(band<Gaussian>(-1.0, 5.0));
  refused(band<Chirp>(-1.0, 5.0));
  refused(band<OddRandomMultisine>(1.01, 1.09));  // between two multiples of 0.1 Hz
  refused(band<Gaussian>(1.01, 1.09));
  refused(band<OddRandomMultisine>(1.0, 50.0));  // Nyquist
  refused(band<Gaussian>(1.0, 50.0));
  refused(band<OddRandomMultisine>(0.15, 0.25));  // 0.2 Hz only, an even multiple
  refused(step(0.0));
  refused(prms(2, 0.1));
  refused(prms(5, 0.1, 1, 0.0));
}

}  // namespace
}  // namespace eha::ident
