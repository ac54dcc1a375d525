// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "daemon/identify/judging.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/model/band_text.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/validation/good_model.hpp"
#include "tests/unit/identify/fitted_model.hpp"

namespace eha::identify {
namespace {

using test::Came;
using test::model_that;

/// A noisy lag, 1.5 / (0.2 s + 1), driven by a slow square wave.
Source lag_source() {
  Source source;
  source.name = "lag.csv";
  source.record.step_s = 0.02;
  source.record.input = Eigen::VectorXd(600);
  for (Eigen::Index k = 0; k < 600; ++k) source.record.input[k] = (k / 75) % 2 == 0 ? 1.0 : -0.5;
  source.record.output = ident::simulate({{{1.5, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input, 0.02);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.01 * draw.normal();
  return source;
}

IdentificationTask task_with_one_pole(const Source& source) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "lag";
  structure.structure = ident::structures::io({1, 0});
  task.structures.push_back(structure);
  return task;
}

TEST(Identify, KeepsInTheProvenanceHowTheRecordWasRead) {
  Source source = lag_source();
  source.command = "eha fit lag.csv --period 0.01 --to 30";
  source.guess = "lag.csv: commas; input 1 \"u\", output 2 \"y\"";
  const Identification found = identify(source, task_with_one_pole(source), {}, {});
  const auto& provenance = found.models.at(0).result.model.provenance;
  EXPECT_EQ(provenance.at("command"), source.command);
  EXPECT_EQ(provenance.at("read_as"), source.guess);
}

TEST(ExitCodeOfModels, TellsAcceptedRejectedAndUnconverged) {
  EXPECT_EQ(exit_code({model_that(Came::rejected), model_that(Came::accepted)}), ExitCode::ok);
  EXPECT_EQ(exit_code({model_that(Came::rejected), model_that(Came::unconverged)}), ExitCode::model_rejected);
  EXPECT_EQ(exit_code({model_that(Came::unconverged)}), ExitCode::not_converged);
}

TEST(Identify, FitsAndJudgesEachStructureAndTellsItsProgress) {
  const Source source = lag_source();
  std::vector<std::pair<double, std::string>> steps;
  const Identification found =
      identify(source, task_with_one_pole(source), {},
               [&](double share, const std::string& step) { steps.emplace_back(share, step); });
  ASSERT_EQ(found.models.size(), 1U);
  const ident::Model& model = found.models[0].result.model;
  EXPECT_EQ(model.name, "lag");
  ASSERT_TRUE(model.verdict && model.estimation && model.validation);
  EXPECT_GT(model.validation->score.r2_percent, 99.0);
  EXPECT_GT(model.estimation->seconds, 0.0);
  EXPECT_EQ(model.provenance.at("record"), "lag.csv");
  EXPECT_NE(model.provenance.at("record_rows").find(" rows, "), std::string::npos);
  EXPECT_TRUE(found.paper.empty());
  EXPECT_TRUE(found.cross_validation.empty());
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0], std::pair(0.0, std::string("fitting lag to 600 rows")));
  EXPECT_EQ(steps[1].first, 1.0);
  EXPECT_EQ(steps[1].second.rfind("lag ", 0), 0U) << steps[1].second;
  EXPECT_EQ(steps[1].second.back(), '\n') << "a result stays on a terminal";
}

TEST(Identify, SaysWhyItGoesOnWhereNoModelPasses) {
  Source source = lag_source();
  // A walk that has nothing to do with the input.
  double place = 0.0;
  std::uint64_t state = 7;
  for (Eigen::Index k = 0; k < source.record.output.size(); ++k) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    source.record.output[k] = place += static_cast<double>(state >> 40U) / static_cast<double>(1U << 24U) - 0.5;
  }
  std::vector<std::string> steps;
  const Identification found =
      identify(source, task_with_one_pole(source), {}, [&](double, const std::string& step) { steps.push_back(step); });
  ASSERT_FALSE(is_accepted(found.models.front()));
  const auto place_of = [&](const std::string& begin) {
    return std::find_if(steps.begin(), steps.end(), [&](const std::string& s) { return s.starts_with(begin); }) -
           steps.begin();
  };
  const auto end = static_cast<std::ptrdiff_t>(steps.size());
  const auto anew = place_of("no model passes its checks: all are fitted again from other starts (seed 2)\n");
  const auto again = place_of("other starts: fitting lag to 600 rows");
  const auto input = place_of("testing whether the input's column comes late");
  const auto beside = place_of("what the models leave over: structures beside the ladder are tried\n");
  const auto trying = place_of("trying ");
  EXPECT_TRUE(anew < again && again < input && input < beside && beside < trying && trying < end)
      << anew << ' ' << again << ' ' << input << ' ' << beside << ' ' << trying << ' ' << end;
}

TEST(Identify, SaysOfAPieceThatManyCurvesFollowIt) {
  Source source = lag_source();
  // 3 s of a tone of 4 s.
  source.record.input.resize(150);
  for (Eigen::Index k = 0; k < 150; ++k) source.record.input[k] = std::sin(0.01 * std::numbers::pi * double(k));
  source.record.output = source.record.output.head(150).eval();
  const Identification found = identify(source, task_with_one_pole(source), {}, {});
  ASSERT_FALSE(found.warnings.empty());
  const std::string& warning = found.warnings.back();
  EXPECT_EQ(warning.rfind("the record is short: the 1.5 s that estimate a model hold", 0), 0U) << warning;
  EXPECT_EQ(found.models.at(0).result.model.provenance.at("remarks"), warning) << "a report has it from there";
  IdentificationTask task = task_with_one_pole(source);
  task.excited = ident::FrequencyInterval{0.1, 1.0 / 1.5};
  const std::string one = identify(source, std::move(task), {}, {}).warnings.back();
  EXPECT_NE(one.find("hold 1 period of the input's fastest motion"), std::string::npos) << one;
}

TEST(Identify, RecommendsNoModelOfAPieceThatNothingJudges) {
  Source source = lag_source();
  ident::PortableDraw draw(5);
  // 2 s of a tone of 4 s, with noise.
  source.record.input.resize(100);
  for (Eigen::Index k = 0; k < 100; ++k) source.record.input[k] = std::sin(0.01 * std::numbers::pi * double(k));
  const ident::TransferFunction lag{{{1.5, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0};
  source.record.output = ident::simulate(lag, source.record.input, 0.02);
  for (double& y : source.record.output) y += 0.03 * draw.normal();
  const Identification found = identify(source, task_with_one_pole(source), {}, {});
  EXPECT_EQ(found.recommendation.model, "");
  const ident::Verdict& verdict = *found.models.at(0).result.model.verdict;
  EXPECT_FALSE(verdict.accepted);
  ASSERT_FALSE(verdict.reasons.empty());
  EXPECT_EQ(verdict.reasons.front().rfind("Too short to judge: 2 s, record at least ", 0), 0U) << verdict.reasons[0];
}

TEST(Identify, AsksForMoreMotionsWhereTheInputMovesOnce) {
  // However long it is recorded, one motion is one.
  for (const Eigen::Index rows : {600, 6000}) {
    Source source = lag_source();
    source.record.input.resize(rows);
    const double whole = static_cast<double>(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      source.record.input[k] = 2.0 * (1.0 - std::exp(-10.0 * static_cast<double>(k) / whole));
    }
    source.record.output = ident::simulate({{{1.5, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input, 0.02);
    const Identification found = identify(source, task_with_one_pole(source), {}, {});
    ASSERT_FALSE(found.warnings.empty()) << rows;
    const std::string& warning = found.warnings.back();
    EXPECT_EQ(warning.rfind("the input moves once, from 0 to 2", 0), 0U) << warning;
    EXPECT_NE(warning.find("a longer record of it tells no more: play several steps"), std::string::npos) << warning;
  }
}

/// A noisy lag after a single step at a tenth of the record.
Source step_source() {
  Source source = lag_source();
  for (Eigen::Index k = 0; k < 600; ++k) source.record.input[k] = k < 60 ? 1.0 : 4.0;
  source.record.output =
      ident::simulate({{{1.5, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input.array() - 1.0, 0.02);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.05 * draw.normal();
  return source;
}

TEST(Identify, EstimatesOnAWholeStepTestWhoseSecondHalfRests) {
  const Source source = step_source();
  const Identification found = identify(source, task_of(source), {}, {});
  ASSERT_FALSE(found.recommendation.model.empty()) << found.recommendation.reason;
  for (const IdentifiedModel& one : found.models) {
    const ident::Model& model = one.result.model;
    EXPECT_FALSE(model.validation) << model.name << " is judged by a half in which nothing moves";
    EXPECT_NE(model.verdict->grade, ident::Grade::good) << model.name;
    for (const std::string& reason : model.verdict->reasons) {
      EXPECT_EQ(reason.find("hardly answers"), std::string::npos) << model.name << ": " << reason;
    }
    if (model.name != found.recommendation.model) continue;
    ASSERT_FALSE(model.verdict->reasons.empty());
    EXPECT_EQ(model.verdict->reasons.front().rfind("The input does not move in the part that would judge; nothing "
                                                   "judges the model: ",
                                                   0),
              0U)
        << model.verdict->reasons.front();
    // A step has no band, and yet determines the gain.
    EXPECT_FALSE(model.verdict->usable_band);
    const std::string none = ident::no_band_text(*model.verdict);
    EXPECT_EQ(none.find("none of the excited frequencies"), std::string::npos) << none;
    EXPECT_NE(none.find("gain at rest and time constants hold by their intervals"), std::string::npos) << none;
  }
}

TEST(Identify, AcceptsNoModelOfARecordThatStandsStillButForAMoment) {
  Source source = lag_source();
  for (Eigen::Index k = 0; k < 600; ++k) {
    source.record.input[k] = k < 60 ? 0.13 : 0.0;
    source.record.output[k] = k < 60 ? 0.0 : k < 62 ? 0.025 : k < 65 ? 0.05 : 0.075;
  }
  const Identification found = identify(source, task_of(source), {}, {});
  EXPECT_EQ(found.recommendation.model, "");
  for (const IdentifiedModel& one : found.models) {
    ASSERT_TRUE(one.result.model.verdict);
    EXPECT_FALSE(one.result.model.verdict->accepted) << one.result.model.name;
  }
  const bool is_said = std::any_of(found.warnings.begin(), found.warnings.end(), [](const std::string& warning) {
    return warning.find("any model follows that, with any gain") != std::string::npos;
  });
  EXPECT_TRUE(is_said);
}

TEST(Identify, JudgesAStepByItsSecondHalfWhereTheOutputGoesOn) {
  Source source = step_source();
  source.record.output = ident::simulate({{{1.5, 0.0}}, {{1.0, 1.0}}, 0.0}, source.record.input.array() - 1.0, 0.02);
  const Identification found = identify(source, task_with_one_pole(source), {}, {});
  EXPECT_TRUE(found.models.at(0).result.model.validation) << "a rod that runs shows its gain";
}

TEST(Identify, SaysOfTwoPartsOfOneRangeThatTheFirstHasTooFewLevels) {
  Source source;
  source.name = "stairs.csv";
  source.record.step_s = 0.01;
  const std::vector<double> levels{0, 4, 0, -4, 0, 4, 0, -4, 0, 1, 0, -1, 0, 2, 0, -2, 0, 4, 0, -4};
  source.record.input = Eigen::VectorXd(40 * static_cast<Eigen::Index>(levels.size()));
  for (Eigen::Index k = 0; k < source.record.input.size(); ++k) {
    source.record.input[k] = levels[static_cast<std::size_t>(k / 40)];
  }
  source.record.output = ident::simulate({{{12.0, 0.0}}, {{0.06, 2.0}, {1.0, 1.0}}, 0.0}, source.record.input, 0.01);
  const Identification found = identify(source, task_of(source), {}, {});
  const auto says = [&](const std::string& part) {
    return std::any_of(found.warnings.begin(), found.warnings.end(),
                       [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(says("both parts of the record have an input of -4 to 4 V, but the first too few of its levels"))
      << fmt::format("{}", fmt::join(found.warnings, "\n"));
  EXPECT_FALSE(says("-4 to 4 V and -4 to 4 V"));
}

TEST(Identify, LetsMoreOfAStaircaseEstimateWhoseFirstHalfDoesNotTellADeadBand) {
  Source source;
  source.name = "stairs.csv";
  source.record.step_s = 0.01;
  const std::vector<double> levels{0, 1, 0, -1, 0, 2, 0, -2, 0, 4, 0, -4, 0};
  source.record.input = Eigen::VectorXd(100 * static_cast<Eigen::Index>(levels.size()));
  Eigen::VectorXd flow(source.record.input.size());
  for (Eigen::Index k = 0; k < flow.size(); ++k) {
    const double u = levels[static_cast<std::size_t>(k / 100)];
    source.record.input[k] = u;
    flow[k] = u > 0.3 ? u - 0.3 : u < -0.3 ? u + 0.3 : 0.0;
  }
  source.record.output = ident::simulate({{{12.0, 0.0}}, {{0.06, 2.0}, {1.0, 1.0}}, 0.0}, flow, 0.01);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.05 * draw.normal();
  const Identification found = identify(source, task_of(source), {}, {});
  EXPECT_EQ(found.recommendation.model, "integrator_lag_valve") << found.recommendation.reason;
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_EQ(
      found.warnings.front().rfind("the two parts of the record see different inputs, -1 to 2 V and -4 to 4 V, ", 0),
      0U)
      << found.warnings.front();
  for (const IdentifiedModel& one : found.models) {
    if (one.structure.name != "integrator_lag_valve") continue;
    EXPECT_EQ(one.result.model.provenance.at("split"), "0.6");
    ASSERT_TRUE(one.result.model.input_map);
    EXPECT_NEAR(one.result.model.input_map->dead_band, 0.3, 0.02);
  }
  // What the user chose stays.
  IdentificationTask given = task_of(source);
  given.is_split_given = true;
  EXPECT_TRUE(identify(source, given, {}, {}).warnings.empty());
}

TEST(Identify, KeepsAStepToJudgeByWhereTheFirstHalfHasAnother) {
  // Levels of 0, 2 and -1 V: 0.6 of the record has all of them, and its rest is at rest.
  Source source;
  source.name = "two_steps.csv";
  source.record.step_s = 0.01;
  source.record.input = Eigen::VectorXd::Zero(6000);
  source.record.input.segment(500, 2500).setConstant(2.0);
  source.record.input.tail(3000).setConstant(-1.0);
  source.record.output = ident::simulate({{{3.0, 0.0}}, {{1.0, 1.0}, {2.0, 0.0}}, 0.2}, source.record.input, 0.01);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.01 * draw.normal();
  const Identification found = identify(source, task_of(source), {}, {});
  EXPECT_EQ(found.recommendation.model, "io1") << found.recommendation.reason;
  const IdentifiedModel* first = recommended_model(found);
  ASSERT_NE(first, nullptr);
  EXPECT_NEAR(first->result.model.transfer_function.delay_s, 0.2, 0.005);
  EXPECT_GT(first->result.model.validation->score.r2_percent, 99.0);
}

TEST(Identify, SaysThatTheSensorFrozeBeforeWhatThatDoesToTheError) {
  Source source;
  source.name = "frozen.csv";
  source.record.step_s = 0.01;
  source.record.input.resize(3000);
  for (Eigen::Index k = 0; k < 3000; ++k) {
    const double t = 0.01 * static_cast<double>(k);
    source.record.input[k] = std::sin(1.3 * t) + std::sin(4.1 * t + 1.0);
  }
  source.record.output = ident::simulate({{{12.0, 0.0}}, {{0.06, 2.0}, {1.0, 1.0}}, 0.0}, source.record.input, 0.01);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.02 * draw.normal();
  source.record.output.segment(2000, 200).setConstant(source.record.output[2000]);
  const importer::OutputFindings findings =
      importer::findings_on_output({source.record.input.begin(), source.record.input.end()},
                                   {source.record.output.begin(), source.record.output.end()}, {}, 0.0, 0.01);
  source.cut = findings.cut;
  source.frozen = findings.frozen;
  EXPECT_EQ(importer::cut_options(source.cut), "--to 19.99");
  const Identification found = identify(source, task_of(source), {}, {});
  for (const IdentifiedModel& one : found.models) {
    const std::vector<std::string>& reasons = one.result.model.verdict->reasons;
    ASSERT_FALSE(reasons.empty()) << one.structure.name;
    EXPECT_EQ(reasons.front().rfind("The sensor froze from 20 to 21.99 s: ", 0), 0U) << reasons.front();
    EXPECT_TRUE(reasons.front().ends_with("; cut with --to 19.99.")) << reasons.front();
  }
  EXPECT_EQ(next_step_of(found).cut_options, "--to 19.99");
  EXPECT_EQ(found.rounds.size(), 1U) << "other starts mend no sensor";
}

TEST(Identify, NamesNoModelToTakeThatTheRecommendedOneOutdoes) {
  const auto of = [](const std::string& name, double ar_bic) {
    IdentifiedModel one;
    one.structure.name = name;
    ident::Model& model = one.result.model = ident::good_model();
    model.name = name;
    model.estimation->information.emplace().ar_bic = ar_bic;
    model.verdict = ident::judge(model, {});
    return one;
  };
  const auto advice_beside = [&](double ar_bic) {
    Identification found;
    found.models = {of("io", -130.0), of("io1", ar_bic)};
    found.models[0].result.model.validation->tests->input.p = 1e-5;
    found.models[0].result.model.verdict = ident::judge(found.models[0].result.model, {});
    const ident::Record record;
    choose({.record = record}, found);
    EXPECT_EQ(found.recommendation.model, "io") << found.recommendation.reason;
    return found.models[0].result.model.verdict->explained_by;
  };
  EXPECT_EQ(advice_beside(-125.0), "io1");
  EXPECT_EQ(advice_beside(-115.0), "");
}

TEST(Identify, NamesTheSourceOfABadRecord) {
  Source source = lag_source();
  source.record.output.setZero();
  try {
    static_cast<void>(identify(source, task_with_one_pole(source), {}, {}));
    FAIL() << "a model of a constant output";
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("lag.csv: ", 0), 0U) << error.what();
  }
}

TEST(Identify, LeavesOutThePapersProcedureForStructuresThatThePaperDoesNotHave) {
  const Source source = lag_source();
  const Identification found = identify(source, task_with_one_pole(source), {.paper = Comparisons::Paper::include}, {});
  EXPECT_TRUE(found.paper.empty());
  EXPECT_TRUE(found.warnings.empty());
}

TEST(UsableBand, BeginsNoLowerThanTheRecordIsLong) {
  ident::Record record;
  record.step_s = 0.01;
  IdentificationTask task{.record = record, .source_name = "test"};
  task.excited = ident::FrequencyInterval{0.05, 0.65};
  record.output = Eigen::VectorXd::Zero(5000);
  EXPECT_DOUBLE_EQ(excited_by(task, {})->lowest_Hz, 0.05);
  record.output = Eigen::VectorXd::Zero(450);  // of a run that tripped
  EXPECT_DOUBLE_EQ(excited_by(task, {})->lowest_Hz, 1.0 / 4.5);
  EXPECT_DOUBLE_EQ(excited_by(task, {})->highest_Hz, 0.65);
  record.output = Eigen::VectorXd::Zero(100);
  EXPECT_FALSE(excited_by(task, {}));
}

}  // namespace
}  // namespace eha::identify
