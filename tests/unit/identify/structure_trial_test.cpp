// SPDX-License-Identifier: GPL-3.0-or-later
// A structure that a table lacks is advised only where its fit to the record holds.
#include "daemon/identify/structure_trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "daemon/identify/judging.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/identify/made_axis.hpp"

namespace eha::identify {
namespace {

enum class Map { none, valve };

/// The integrator with a lag, fitted alone. Its residual speaks for friction.
Identification fitted(const Source& source, Map map) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "integrator_lag";
  structure.structure = ident::structures::integrator_lag();
  if (map == Map::valve) structure.structure = ident::structures::behind_valve(structure.structure);
  task.structures.push_back(structure);
  return identify(source, task, {}, {});
}

bool advises_friction(const ident::Model& model) {
  const std::vector<std::string>& reasons = model.verdict->reasons;
  return std::any_of(reasons.begin(), reasons.end(),
                     [](const std::string& reason) { return reason.find("--model friction") != std::string::npos; });
}

TEST(GreyBoxTrial, AdvisesFrictionWhereItHolds) {
  for (const int seed : {1, 2}) {
    const Identification found = fitted(test::made_axis({.friction_V = 0.33, .seed = seed}), Map::valve);
    const ident::Model& model = found.models.front().result.model;
    ASSERT_EQ(ident::grey_box_to_try(model, *model.verdict), &ident::friction_kind()) << "seed " << seed;
    EXPECT_TRUE(advises_friction(model)) << "seed " << seed;
    EXPECT_EQ(model.provenance.at(ident::kGreyBoxHolds).find("errs 0."), 0U) << "seed " << seed;
    EXPECT_EQ(found.models.size(), 1U) << "the trial is no model of the answer";
  }
}

TEST(GreyBoxTrial, AdvisesNoFrictionForPlay) {
  int asked = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const Identification found = fitted(test::made_axis({.play_mm = 0.15, .seed = seed}), Map::none);
    const ident::Model& model = found.models.front().result.model;
    asked += ident::grey_box_to_try(model, *model.verdict) != nullptr ? 1 : 0;
    EXPECT_FALSE(advises_friction(model)) << "seed " << seed;
  }
  EXPECT_GE(asked, 3) << "the residual must look like friction's";
}

constexpr double kMadeStep_s = 0.005;
constexpr Eigen::Index kMadeRows = 4000;

/// Levels that are held 0.1 s.
Eigen::VectorXd levels(double amplitude, int seed) {
  ident::PortableDraw draw(static_cast<std::uint64_t>(seed));
  Eigen::VectorXd input(kMadeRows);
  for (Eigen::Index k = 0; k < kMadeRows; ++k) {
    input[k] = k % 20 == 0 ? std::clamp(0.6 * amplitude * draw.normal(), -amplitude, amplitude) : input[k - 1];
  }
  return input;
}

/// A sine whose frequency rises from 0.2 to 16 Hz.
Eigen::VectorXd chirp() {
  Eigen::VectorXd input(kMadeRows);
  const double length_s = kMadeStep_s * static_cast<double>(kMadeRows);
  for (Eigen::Index k = 0; k < kMadeRows; ++k) {
    const double t = kMadeStep_s * static_cast<double>(k);
    input[k] = 2.0 * std::sin(2.0 * std::numbers::pi * (0.2 + 7.9 * t / length_s) * t);
  }
  return input;
}

/// The record of a plant whose input saturates.
Source record_of(const ident::TransferFunction& plant, const Eigen::VectorXd& input,
                 double limit = std::numeric_limits<double>::infinity()) {
  Source source;
  source.name = "plant.csv";
  source.record.step_s = kMadeStep_s;
  source.record.input = input;
  source.record.input_channel = {"valve", "V"};
  source.record.output_channel = {"force", "N"};
  source.record.output = ident::simulate(plant, input.cwiseMax(-limit).cwiseMin(limit), kMadeStep_s);
  ident::PortableDraw draw(7);
  const double noise = 0.003 * std::sqrt(source.record.output.squaredNorm() / static_cast<double>(kMadeRows));
  for (double& y : source.record.output) y += noise * draw.normal();
  return source;
}

/// One structure fitted alone.
ident::Model model_of(const Source& source, const ident::Structure& structure) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions asked;
  asked.structure = structure;
  task.structures.push_back(asked);
  return identify(source, task, {}, {}).models.front().result.model;
}

/// A lag, an antiresonance at 9 Hz and a resonance at 7 Hz.
ident::TransferFunction two_masses() {
  const double antiresonance = 2.0 * std::numbers::pi * 9.0;
  const double resonance = 2.0 * std::numbers::pi * 7.0;
  const double b2 = 1.0 / (antiresonance * antiresonance);
  const double b1 = 0.06 / antiresonance;
  const double a2 = 1.0 / (resonance * resonance);
  const double a1 = 0.06 / resonance;
  const double lag_s = 0.05;
  return {{{2.0 * b2, 2.0}, {2.0 * b1, 1.0}, {2.0, 0.0}},
          {{lag_s * a2, 3.0}, {a2 + lag_s * a1, 2.0}, {a1 + lag_s, 1.0}, {1.0, 0.0}},
          0.0};
}

TEST(StructureTrial, AdvisesMorePolesWhereTheyDescribeTwoMasses) {
  for (const Eigen::VectorXd& input : {levels(3.0, 1), chirp()}) {
    const ident::Model model = model_of(record_of(two_masses(), input), ident::structures::io3(1));
    const auto explained = ident::explanation(model);
    ASSERT_TRUE(explained);
    EXPECT_EQ(explained->options, "--model io --poles 3 --zeros 2");
    EXPECT_LT(std::stod(explained->ratio), 0.5);
    ASSERT_FALSE(model.verdict->reasons.empty());
    EXPECT_NE(model.verdict->reasons.front().find("`eha fit --model io --poles 3 --zeros 2`"), std::string::npos)
        << model.verdict->reasons.front();
    EXPECT_FALSE(model.validation->end_stop) << "it stands nowhere";
    for (const std::string& reason : model.verdict->reasons) {
      EXPECT_EQ(reason.find("friction"), std::string::npos) << reason;
      EXPECT_EQ(reason.find("amplitude"), std::string::npos) << reason;
    }
  }
}

TEST(StructureTrial, NamesALimitOfTheInputByItsSize) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  const ident::Model model = model_of(record_of(lag, levels(5.0, 2), 2.0), ident::structures::io1());
  const auto explained = ident::explanation(model);
  ASSERT_TRUE(explained);
  EXPECT_TRUE(explained->options.empty()) << "no structure has it";
  EXPECT_EQ(explained->has.rfind("+-", 0), 0U) << explained->has;
  EXPECT_NEAR(std::stod(explained->has.substr(2)), 2.0, 0.25);
  EXPECT_TRUE(model.verdict->reasons.front().starts_with("The plant saturates beyond about +-"))
      << model.verdict->reasons.front();
}

TEST(StructureTrial, NamesThePowerOfACurvedGain) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  for (const double power : {0.5, 2.0}) {
    const Eigen::VectorXd input = levels(5.0, 2);
    const Eigen::VectorXd curved =
        input.unaryExpr([&](double u) { return std::copysign(std::pow(std::abs(u), power), u); });
    Source source = record_of(lag, curved);
    source.record.input = input;
    for (const ident::Structure& structure :
         {ident::structures::io1(), ident::structures::behind_valve(ident::structures::io1())}) {
      const ident::Model model = model_of(source, structure);
      const auto explained = ident::explanation(model);
      ASSERT_TRUE(explained) << power;
      EXPECT_EQ(explained->kind, ident::ExplanationKind::power);
      EXPECT_NEAR(std::stod(explained->has), power, 0.06 * power);
      EXPECT_LT(std::stod(explained->ratio), 0.2);
      EXPECT_TRUE(
          model.verdict->reasons.front().starts_with("The plant's gain is curved: behind the power sign(u) |u|^"))
          << model.verdict->reasons.front();
    }
  }
}

TEST(StructureTrial, FindsALimitBetweenTheLevelsOfTheInput) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  const Eigen::VectorXd few = 1.4 * (levels(5.0, 2).array() / 1.4).round();
  const ident::Model model = model_of(record_of(lag, few, 2.0), ident::structures::io1());
  const auto explained = ident::explanation(model);
  ASSERT_TRUE(explained);
  EXPECT_EQ(explained->has.rfind("+-", 0), 0U) << explained->has;
  EXPECT_NEAR(std::stod(explained->has.substr(2)), 2.0, 0.11);
  EXPECT_NE(explained->has.find("(between its levels of 1.4 and 2.8"), std::string::npos) << explained->has;
}

/// What is behind a play of a width.
Eigen::VectorXd behind_play(const Eigen::VectorXd& drive, double width) {
  Eigen::VectorXd moved = drive;
  for (Eigen::Index k = 1; k < drive.size(); ++k) {
    moved[k] = std::clamp(moved[k - 1], drive[k] - 0.5 * width, drive[k] + 0.5 * width);
  }
  return moved;
}

TEST(StructureTrial, FindsAPlayAtTheInputAndBeforeTheSensor) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  const Eigen::VectorXd input = levels(5.0, 3);
  Source spool = record_of(lag, behind_play(input, 0.5));
  spool.record.input = input;
  Source coupling = record_of(lag, input);
  const Eigen::VectorXd clean = ident::simulate(lag, input, kMadeStep_s);
  coupling.record.output += behind_play(clean, 1.5) - clean;
  for (const auto& [source, width, place] : {std::tuple(spool, 0.5, " between the input and the plant"),
                                             {coupling, 1.5, " between the plant and its sensor"}}) {
    const ident::Model model = model_of(source, ident::structures::io1());
    const auto explained = ident::explanation(model);
    ASSERT_TRUE(explained) << place;
    EXPECT_EQ(explained->kind, ident::ExplanationKind::play);
    EXPECT_NEAR(std::stod(explained->has), width, 0.12 * width) << explained->has;
    EXPECT_NE(explained->has.find(place), std::string::npos) << explained->has;
    EXPECT_TRUE(model.verdict->reasons.front().starts_with("There is a play")) << model.verdict->reasons.front();
    EXPECT_TRUE(ident::may_miss_a_part(*model.verdict)) << "its intervals are lower bounds";
  }
}

TEST(StructureTrial, NamesThePartOfARecordWithinALimitOfTheInput) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  Eigen::VectorXd input = levels(5.0, 2);
  const Eigen::Index from = 3 * input.size() / 5;
  input.tail(input.size() - from) *= 0.3;
  const Source source = record_of(lag, input, 2.0);
  const ident::Record& record = source.record;
  const ident::Model model = model_of(source, ident::structures::io1());
  const auto explained = ident::explanation(model);
  ASSERT_TRUE(explained);
  EXPECT_EQ(explained->kind, ident::ExplanationKind::limit);
  ASSERT_TRUE(explained->options.starts_with("--from ")) << explained->options;
  EXPECT_NEAR(std::stod(explained->options.substr(7)), record.start_s + static_cast<double>(from) * record.step_s, 1.0);
  const std::string& first = model.verdict->reasons.front();
  EXPECT_NE(first.find("cut to a part with such (" + explained->options + ")"), std::string::npos) << first;
}

TEST(StructureTrial, HoldsTheMapOfAPumpWhereTheNoiseDecidesItsOtherSide) {
  int recommended = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    constexpr Eigen::Index kPumpRows = 4000;
    constexpr double kPumpRow_s = 0.05;
    ident::PortableDraw draw(seed);
    const Eigen::Vector3d phases(6.28 * draw.uniform(), 6.28 * draw.uniform(), 6.28 * draw.uniform());
    Eigen::VectorXd current(kPumpRows);
    Eigen::VectorXd driving(kPumpRows);
    for (Eigen::Index k = 0; k < kPumpRows; ++k) {
      const double t = kPumpRow_s * static_cast<double>(k);
      const double tones = 4.0 * std::sin(0.188 * t + phases[0]) + 3.0 * std::sin(0.691 * t + phases[1]) +
                           2.5 * std::sin(2.325 * t + phases[2]);
      current[k] = 0.01 * std::round(100.0 * std::max(4.0, 8.0 + tones));
      driving[k] = std::max(0.0, current[k] - 5.2);
    }
    Source source;
    source.name = "pump.csv";
    source.record.step_s = kPumpRow_s;
    source.record.input = current;
    source.record.input_channel = {"current", "mA"};
    source.record.output_channel = {"flow", "l/min"};
    source.record.output = ident::simulate({{{1.5, 0.0}}, {{0.35, 1.0}, {1.0, 0.0}}, 0.0}, driving, kPumpRow_s);
    for (double& y : source.record.output) y = 0.01 * std::round(100.0 * (y + 0.03 * draw.normal()));
    const Identification found = identify(source, task_of(source), {}, {});
    SCOPED_TRACE(found.recommendation.model + ": " + found.recommendation.reason);
    for (const IdentifiedModel& one : found.models) {
      const ident::Model& model = one.result.model;
      if (model.name != found.recommendation.model) continue;
      ASSERT_TRUE(model.input_map);
      ++recommended;
      const ident::TransferFunction& g = model.transfer_function;
      EXPECT_NEAR(g.numerator.back().coefficient / g.denominator.back().coefficient, 1.5, 0.02) << seed;
      EXPECT_GT(model.input_map->negative_gain_ratio, -0.06) << seed;
    }
  }
  EXPECT_EQ(recommended, 8);
}

TEST(StructureTrial, AdvisesNothingWhereTheStructureIsThePlants) {
  const ident::TransferFunction lag{{{4.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};
  for (const int seed : {3, 4, 5}) {
    const ident::Model model = model_of(record_of(lag, levels(3.0, seed)), ident::structures::io1());
    EXPECT_FALSE(ident::explanation(model)) << seed;
    EXPECT_TRUE(model.verdict->accepted) << seed;
  }
}

}  // namespace
}  // namespace eha::identify
