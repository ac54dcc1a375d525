// SPDX-License-Identifier: GPL-3.0-or-later
// An input column that is not what the plant got is found where its mended form fits far better, and in no sound
// record.
#include "daemon/identify/input_trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/structure/structures.hpp"
#include "tests/unit/identify/made_axis.hpp"

namespace eha::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kRows = 3000;
constexpr double kRow_s = 0.02;

/// Tones of 0.1 to 1.3 Hz about the null.
VectorXd tones(double greatest) {
  VectorXd input = VectorXd::Zero(kRows);
  for (int i = 1; i <= 6; ++i) {
    const double f_Hz = 0.1 * i * (i + 1) / 3.2;
    for (Index k = 0; k < kRows; ++k) {
      input[k] += std::sin(2.0 * std::numbers::pi * f_Hz * kRow_s * static_cast<double>(k) + 0.7 * i * i);
    }
  }
  return (input * (greatest / input.cwiseAbs().maxCoeff())).array() - 0.2;
}

VectorXd steps() {
  VectorXd input(kRows);
  ident::PortableDraw draw(3);
  for (Index k = 0; k < kRows; ++k) {
    input[k] = k % 25 == 0 ? std::clamp(2.0 * draw.normal(), -3.0, 3.0) : input[k - 1];
  }
  return input;
}

/// A rod behind a valve of null -0.2 V and half dead band 0.15 V, with a lag of 18 ms. @param friction_V  dry
VectorXd rod(const VectorXd& input, double friction_V = 0.0) {
  constexpr int kParts = 10;
  VectorXd output(input.size());
  ident::PortableDraw draw(7);
  double x = 2.9;
  double speed = 0.0;
  for (Index k = 0; k < input.size(); ++k) {
    output[k] = x + 0.0005 * draw.normal();
    const double v = input[k] + 0.2;
    const double beyond = std::copysign(std::max(0.0, std::abs(v) - 0.15), v);
    for (int part = 0; part < kParts; ++part) {
      const double share = kRow_s / kParts / 0.018;
      const double pushed = speed + share * (0.15 * beyond - speed);
      speed = std::copysign(std::max(0.0, std::abs(pushed) - share * 0.15 * friction_V), pushed);
      x += kRow_s / kParts * speed;
    }
  }
  return output;
}

Source record_of(const VectorXd& input, const VectorXd& output) {
  Source source;
  source.name = "rod.csv";
  source.exchange = "--input 3 --output 2";
  source.record.step_s = kRow_s;
  source.record.input = input;
  source.record.output = output;
  source.record.input_channel = {"valve", "V"};
  source.record.output_channel = {"rod", "in"};
  return source;
}

VectorXd later(const VectorXd& input, Index rows) {
  VectorXd found(input.size());
  for (Index k = 0; k < input.size(); ++k) found[k] = input[std::max<Index>(0, k - rows)];
  return found;
}

Identification fitted(const Source& source) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "integrator_lag_valve";
  structure.structure = ident::structures::behind_valve(ident::structures::integrator_lag());
  task.structures.push_back(structure);
  return identify(source, task, {}, {});
}

std::string first_reason(const Identification& found) {
  const auto& verdict = found.models.front().result.model.verdict;
  return verdict && !verdict->reasons.empty() ? verdict->reasons.front() : std::string();
}

TEST(InputTrial, FindsARangeOfTheLoggerThatEndsBeforeTheCommand) {
  const VectorXd command = tones(4.0);
  const VectorXd limited = command.cwiseMax(-2.0).cwiseMin(2.0);
  const Identification found = fitted(record_of(limited, rod(command)));
  EXPECT_NE(first_reason(found).find("The input's column is clipped: "), std::string::npos) << first_reason(found);
  EXPECT_NE(first_reason(found).find("exactly at -2 or 2 V"), std::string::npos) << first_reason(found);
  EXPECT_EQ(found.recommendation.model, "") << "not graded as if sound";
  EXPECT_EQ(found.models.front().result.model.verdict->grade, ident::Grade::rejected);
}

TEST(InputTrial, FindsLevelsThatTheLoggerCutOff) {
  ident::PortableDraw draw(12);
  VectorXd command(kRows);
  for (Index k = 0; k < kRows; ++k) command[k] = k % 25 == 0 ? 6.0 * draw.uniform() - 3.0 : command[k - 1];
  const VectorXd limited = command.cwiseMax(-2.0).cwiseMin(2.0);
  const auto answer = [&](const VectorXd& input) {
    VectorXd output = ident::simulate({{{1.7, 0.0}}, {{0.3, 1.0}, {1.0, 0.0}}, 0.0}, input, kRow_s);
    for (double& y : output) y += 0.005 * draw.normal();
    return output;
  };
  const auto lag_of = [&](const VectorXd& output) {
    IdentificationTask task = task_of(record_of(limited, output));
    ident::StructureOptions structure;
    structure.name = "io1";
    structure.structure = ident::structures::io1();
    task.structures.push_back(structure);
    return identify(record_of(limited, output), task, {}, {});
  };
  const Identification found = lag_of(answer(command));
  EXPECT_NE(first_reason(found).find("The input's column is clipped: "), std::string::npos) << first_reason(found);
  EXPECT_NE(first_reason(found).find("with levels that follow from the output"), std::string::npos)
      << first_reason(found);
  EXPECT_EQ(found.recommendation.model, "") << "not graded as if sound";
  const Identification sound = lag_of(answer(limited));
  EXPECT_EQ(first_reason(sound).find("clipped"), std::string::npos) << first_reason(sound);
  EXPECT_FALSE(sound.recommendation.model.empty()) << "a command that is limited is no fault";
}

/// Values between the rows, up to 0.4 of one early or late, as a resampling of time stamps that scatter makes them.
VectorXd moved(const VectorXd& values) {
  VectorXd found = values;
  ident::PortableDraw draw(11);
  for (Index k = 1; k + 1 < values.size(); ++k) {
    const double by = std::clamp(0.2 * draw.normal(), -0.4, 0.4);
    found[k] += std::abs(by) * (values[by > 0.0 ? k + 1 : k - 1] - values[k]);
  }
  return found;
}

TEST(InputTrial, TakesRowsThatWereMovedAsSampledEvenlyWhereTheyErrLessSo) {
  const VectorXd input = tones(4.0);
  const VectorXd output = rod(input);
  Source source = record_of(moved(input), moved(output));
  source.as_even = record_of(input, output).record;
  const Identification found = fitted(source);
  EXPECT_TRUE(
      first_reason(found).starts_with("The rows were moved to even times although they had been sampled at "
                                      "such"))
      << first_reason(found);
  EXPECT_EQ(found.models.front().result.model.verdict->reasons.size(), 1U) << "nothing is said of the plant";
  EXPECT_EQ(found.mended_input, "--period 0.02");
  EXPECT_EQ(next_step_of(found).first, ident::FirstStep::take_rows_as_even);
  EXPECT_FALSE(found.recommendation.model.empty()) << "its figures hold nearly";
}

TEST(InputTrial, LeavesRowsWhoseTimesAreThoseOfTheSamples) {
  const VectorXd input = tones(4.0);
  const VectorXd output = rod(input);
  Source source = record_of(moved(input), moved(output));
  source.as_even = record_of(moved(moved(input)), moved(moved(output))).record;
  const Identification found = fitted(source);
  EXPECT_NE(next_step_of(found).first, ident::FirstStep::take_rows_as_even);
  EXPECT_EQ(found.mended_input, "");
  EXPECT_TRUE(first_reason(found).starts_with("The rows were moved to even times, the input as if"))
      << first_reason(found);
}

TEST(InputTrial, FindsAColumnThatComesLate) {
  const VectorXd command = tones(4.0);
  const VectorXd output = rod(command);
  for (const Index rows : {2, 5}) {
    const Identification found = fitted(record_of(later(command, rows), output));
    const std::string options = found.mended_input;
    EXPECT_EQ(options.find("--input-late "), 0U) << rows << ": " << first_reason(found);
    if (!options.empty()) {
      EXPECT_NEAR(std::stod(options.substr(13)), static_cast<double>(rows), 1.0);
    }
    EXPECT_EQ(found.recommendation.model, "") << rows;
  }
  const Identification of_steps = fitted(record_of(later(steps(), 2), rod(steps())));
  EXPECT_EQ(of_steps.mended_input, "--input-late 2") << first_reason(of_steps);
}

TEST(InputTrial, CountsTheRowsOfALateInputThatALagMakesUpFor) {
  constexpr double kQuickRow_s = 0.01;
  constexpr double kLag_s = 0.03;
  VectorXd command = VectorXd::Zero(4000);
  VectorXd output(command.size());
  ident::PortableDraw draw(20);
  for (const double f_Hz : {0.1, 0.3, 0.5, 0.9, 1.3, 2.1, 3.1}) {
    const double phase = 6.28 * draw.uniform();
    for (Index k = 0; k < command.size(); ++k) {
      command[k] += std::sin(2.0 * std::numbers::pi * f_Hz * kQuickRow_s * static_cast<double>(k) + phase);
    }
  }
  double place = 100.0;
  double speed = 0.0;
  for (Index k = 0; k < command.size(); ++k) {
    output[k] = place + 0.02 * draw.normal();
    const double v = command[k] - 0.1;
    const double beyond = std::copysign(std::max(0.0, std::abs(v) - 0.2), v);
    const double settled = 10.0 * beyond;
    const double share = 1.0 - std::exp(-kQuickRow_s / kLag_s);
    place += settled * kQuickRow_s + (speed - settled) * kLag_s * share;
    speed += share * (settled - speed);
  }
  const auto mended = [&](Index rows) {
    Source source = record_of(later(command, rows), output);
    source.record.step_s = kQuickRow_s;
    return identify(source, task_of(source), {}, {}).mended_input;
  };
  EXPECT_EQ(mended(0), "");
  EXPECT_EQ(mended(2), "--input-late 2");
  EXPECT_EQ(mended(4), "--input-late 4") << "the lag of the first fit has vanished";
}

TEST(InputTrial, TakesNoDriftOfTheSensorForALateInput) {
  ident::PortableDraw draw(10);
  const VectorXd input = steps();
  VectorXd output = VectorXd::Zero(kRows);
  constexpr Index kDeadRows = 6;
  for (Index k = 1; k < kRows; ++k) {
    const double delayed = k > kDeadRows ? input[k - 1 - kDeadRows] : 0.0;
    output[k] = 0.96 * output[k - 1] + 0.04 * 3.0 * delayed;
  }
  for (Index k = 0; k < kRows; ++k) output[k] += 0.02 * draw.normal() + 0.0003 * static_cast<double>(k);
  const Identification found = fitted(record_of(input, output));
  EXPECT_EQ(found.mended_input.find("--input-late"), std::string::npos) << first_reason(found);
}

TEST(InputTrial, FindsAnInputThatFroze) {
  const VectorXd command = tones(4.0);
  VectorXd frozen = command;
  frozen.tail(1000).setConstant(command[2000]);
  const Identification found = fitted(record_of(frozen, rod(command)));
  EXPECT_NE(first_reason(found).find("The input's column froze from 40 to 59.98 s"), std::string::npos)
      << first_reason(found);
  EXPECT_EQ(found.mended_input, "--to 39.98");
}

TEST(InputTrial, FindsExchangedColumnsOfARodWithADeadBand) {
  const VectorXd command = tones(0.8);
  const Identification found = fitted(record_of(rod(command), command));
  EXPECT_NE(first_reason(found).find("Input and output may be exchanged: "), std::string::npos) << first_reason(found);
  EXPECT_EQ(found.mended_input, "--input 3 --output 2");
}

TEST(InputTrial, FindsExchangedColumnsBesideNoiseOfTheSensorThatLooksLikeThatOfAnInput) {
  const VectorXd command = tones(3.0);
  for (const double noise : {0.02, 0.05, 0.1}) {
    VectorXd output(kRows);
    ident::PortableDraw draw(12);
    double place = 75.0;
    double speed = 0.0;
    for (Index k = 0; k < kRows; ++k) {
      output[k] = place + noise * draw.normal();
      speed += (1.0 - std::exp(-kRow_s / 0.03)) * (12.0 * command[k] - speed);
      place += kRow_s * speed;
    }
    const Source exchanged = record_of(output, command);
    EXPECT_EQ(identify(exchanged, task_of(exchanged), {}, {}).mended_input, "--input 3 --output 2") << noise;
  }
}

TEST(InputTrial, SaysThatAnInputStandsAtItsEndsWhereNoTrialTellsWhetherALoggerCutItOff) {
  const VectorXd command = tones(4.0);
  const VectorXd limited = command.cwiseMax(-0.9).cwiseMin(0.7);  // no cubic goes on over so many rows
  const Identification cut = fitted(record_of(limited, rod(command)));
  const auto says = [](const Identification& found) {
    return std::any_of(found.warnings.begin(), found.warnings.end(), [](const std::string& warning) {
      return warning.starts_with("the input stands exactly at -0.9 or 0.7 V for ");
    });
  };
  EXPECT_TRUE(says(cut)) << first_reason(cut);
  EXPECT_FALSE(says(fitted(record_of(command, rod(command)))));
}

TEST(InputTrial, TellsExchangedColumnsFromAnInputThatComesLate) {
  const VectorXd command = tones(3.0);
  VectorXd output(kRows);
  ident::PortableDraw draw(9);
  double lag = 0.0;
  for (Index k = 0; k < kRows; ++k) {  // 0.3 s behind a dead time of 0.1 s
    output[k] = 50.0 + lag + 0.02 * draw.normal();
    lag += (1.0 - std::exp(-kRow_s / 0.3)) * (12.0 * command[std::max<Index>(0, k - 5)] - lag);
  }
  const auto ladder = [](const Source& source) { return identify(source, task_of(source), {}, {}); };
  EXPECT_EQ(ladder(record_of(output, command)).mended_input, "--input 3 --output 2");
  const Identification late = ladder(record_of(later(command, 9), output));
  EXPECT_EQ(late.mended_input.rfind("--input-late ", 0), 0U) << late.mended_input;
}

TEST(InputTrial, SaysOfTheRecordAloneThatItsInputIsLost) {
  const auto sentence = [](const VectorXd& input, const VectorXd& output) {
    const auto lost = lost_input(record_of(input, output));
    return lost ? lost->sentence + "; " + lost->options : std::string();
  };
  ident::PortableDraw draw(5);
  VectorXd noise(kRows);
  for (double& x : noise) x = 0.0003 * draw.normal();
  for (const VectorXd& input : {tones(2.0), steps()}) {
    const VectorXd output = rod(input);
    EXPECT_EQ(sentence(input, output), "");
    VectorXd frozen = input;
    frozen.tail(kRows / 2).setZero();
    const std::string found = sentence(frozen, output);
    EXPECT_EQ(found.rfind("The input's column froze from 30 to 59.98 s: it keeps 0 V", 0), 0U) << found;
    EXPECT_NE(found.find("; --to 29.98"), std::string::npos) << found;
    EXPECT_EQ(sentence(noise, output).rfind("The input is plain noise of 0.000303 V", 0), 0U)
        << sentence(noise, output);
  }
  // Noise that moves the rod is its input; at rest a rod moves as little as the input that is held.
  const VectorXd driving = 1000.0 * noise;
  EXPECT_EQ(sentence(driving, rod(driving)), "");
  VectorXd rests = steps();
  rests.tail(kRows / 2).setConstant(-0.2);
  EXPECT_EQ(sentence(rests, rod(rests)), "");
  Source loop = record_of(noise, rod(tones(2.0)));
  loop.is_closed_loop = true;
  EXPECT_FALSE(lost_input(loop));
}

TEST(InputTrial, SuspectsNoSoundInput) {
  const VectorXd command = tones(4.0);
  const VectorXd limited = command.cwiseMax(-2.0).cwiseMin(2.0);
  VectorXd held = command;
  held.segment(1500, 300).setConstant(command[1500]);
  for (const double friction_V : {0.0, 0.3}) {
    for (const VectorXd& input : {command, limited, held, steps()}) {
      const Identification found = fitted(record_of(input, rod(input, friction_V)));
      EXPECT_EQ(found.mended_input, "") << friction_V << ": " << first_reason(found);
      EXPECT_EQ(first_reason(found).find("input's column"), std::string::npos) << first_reason(found);
    }
  }
  for (const double play_mm : {0.0, 0.15}) {
    const Identification found = fitted(test::made_axis({.play_mm = play_mm}));
    EXPECT_EQ(found.mended_input, "") << first_reason(found);
  }
}

}  // namespace
}  // namespace eha::identify
