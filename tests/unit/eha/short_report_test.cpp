// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/short_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "daemon/eha/wrapped_text.hpp"
#include "tests/unit/identify/fitted_model.hpp"

namespace eha::cli {
namespace {

using identify::test::Came;
using identify::test::model_that;

Answer answer_with(const std::string& recommended) {
  Answer answer;
  answer.models.push_back(model_that(Came::accepted).result.model);
  answer.models.back().verdict->reasons.emplace_back(
      "The residual correlates with past input (p = 0.0001 for lags 0 to 20 together): the model may miss a part.");
  answer.recommendation.model = recommended.empty() ? answer.models.back().name : "";
  answer.recommendation.reason = "its AR-BIC of -7361.1 is the least of 2 models, 12.4 below that of fo";
  return answer;
}

TEST(ShortReport, KeepsWithinEightyColumns) {
  for (const char* name : {"", "none"}) {
    std::istringstream lines(short_report(answer_with(name), {}));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
  }
}

TEST(ShortReport, LeadsWithTheRecommendedModel) {
  const Answer answer = answer_with("");
  const std::string text = short_report(answer, {});
  EXPECT_EQ(text.rfind("recommended     " + answer.models[0].name + " (", 0), 0U) << text;
  for (const char* label : {"\nequation ", "\non unseen data ", "\nlargest error ", "\nusable band ", "\nbecause "}) {
    EXPECT_NE(text.find(label), std::string::npos) << label << " in\n" << text;
  }
  EXPECT_EQ(short_report(answer_with("none"), {}).rfind("recommended     none\n", 0), 0U);
}

TEST(ShortReport, PrintsNoLevelThatTheRecordDoesNotShow) {
  Answer answer = answer_with("");
  ident::Model& model = answer.models[0];
  model.initial_output = -209'000.0;
  model.estimation->score.mse = 1e-4;
  ident::ParameterEstimate level{.name = "initial_output", .value = model.initial_output};
  level.role = ident::ParameterRole::initial_output;
  level.lower95 = -209'000.1;
  level.upper95 = -208'999.9;
  model.parameters.push_back(level);
  EXPECT_NE(short_report(answer, {}).find("y = -2.09e+05"), std::string::npos);
  model.parameters.back().lower95 = -5e5;
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("y = y0 + "), std::string::npos) << text;
  EXPECT_EQ(text.find("2.09e+05"), std::string::npos) << text;
}

TEST(ShortReport, WithAllReasonsPromisesNoMore) {
  Answer answer = answer_with("");
  std::vector<std::string>& reasons = answer.models[0].verdict->reasons;
  for (const char* name : {"second", "third", "fourth", "fifth"}) {
    reasons.push_back(std::string("The ") + name + " thing is wrong; do the " + name + " thing.");
  }
  const std::string some = short_report(answer, {});
  EXPECT_NE(some.find("and 3 more; -v gives all"), std::string::npos) << some;
  const std::string all = short_report(answer, {}, Reasons::all);
  EXPECT_NE(all.find("do the fifth thing."), std::string::npos) << all;
  EXPECT_EQ(all.find("-v"), std::string::npos) << all;
}

TEST(ShortReport, ShowsLengthsInTheAskedUnit) {
  Answer answer = answer_with("");
  answer.models[0].output_unit = "in";
  answer.models[0].initial_output = 2.0;
  answer.models[0].validation->score.error_min = -0.1;
  answer.models[0].validation->score.error_max = 0.05;
  const std::string text = short_report(answer, DisplayUnit("mm"));
  EXPECT_NE(text.find("y = 50.8 mm + G"), std::string::npos) << text;
  EXPECT_NE(text.find("largest error   2.54 mm"), std::string::npos) << text;
  EXPECT_NE(text.find("largest mm"), std::string::npos) << text;
  answer.models[0].output_unit = "bar";
  EXPECT_NE(short_report(answer, DisplayUnit("mm")).find("largest error   0.1 bar"), std::string::npos);
}

TEST(ShortReport, CautionsOfTheIntervalsOfNullAndDeadBand) {
  Answer answer = answer_with("");
  ident::Model& model = answer.models[0];
  constexpr const char* kCaution = "eha characterise";
  EXPECT_EQ(short_report(answer, {}).find(kCaution), std::string::npos) << "without a map";
  model.input_unit = "V";
  model.input_map = ident::ValveMap{.null = -0.2, .dead_band = 0.15, .negative_gain_ratio = 0.9};
  model.parameters.push_back({.name = "null"});
  ident::ParameterEstimate& null = model.parameters.back();
  null.role = ident::ParameterRole::valve_null;
  null.value = -0.2;
  null.lower95 = -0.202;
  null.upper95 = -0.198;
  EXPECT_NE(short_report(answer, {}).find(kCaution), std::string::npos) << short_report(answer, {});
  model.validation->map_error = 0.04;
  EXPECT_NE(short_report(answer, {}).find("each may be up to 0.08 V off the valve's"), std::string::npos)
      << short_report(answer, {});
  null.fixed = true;
  EXPECT_EQ(short_report(answer, {}).find(kCaution), std::string::npos) << "it is held, not measured";
}

/// The lines of "chosen as", with a blank in place of each break.
std::string chosen_in(const std::string& text) {
  const std::size_t at = text.find("\nchosen as");
  std::string words;
  for (const char c : text.substr(at + 1, text.find("\nbecause") - at - 1)) {
    if (c == '\n') words += ' ';
    if (c != '\n' && !(c == ' ' && words.ends_with(' '))) words += c;
  }
  return words;
}

TEST(ShortReport, SaysInWordsOfTheBenchWhyAModelWasChosen) {
  Answer answer = answer_with("");
  answer.models[0].validation->score.mse = 0.01;
  answer.models[0].verdict->reasons = {"The first one; do this.", "The second one; do that."};
  answer.models.push_back(answer.models[0]);
  answer.models.back().name = "next";
  answer.models.back().validation->score.mse = 0.0169;
  answer.models.back().parameters.push_back({.name = "b1"});
  answer.models.push_back(answer.models[0]);
  answer.models.back().name = "far";
  answer.models.back().validation->score.mse = 1.0;
  answer.recommendation.reason = "its AR-BIC of -5552.1 is the least of 3 models, 3.7 below that of next";
  answer.recommendation.runner_up = "next";
  answer.recommendation.is_unclear = true;
  answer.recommendation.is_lag_or_delay = true;
  const std::string text = short_report(answer, {});
  EXPECT_EQ(text.find("AR-BIC"), std::string::npos) << text;
  const std::string chosen = chosen_in(text);
  EXPECT_NE(chosen.find(
                "the simplest of the 2 models, of 3, that err at most 1.5 times as much; the runner-up, next, errs 1.3 "
                "times as much (rms, on unseen data); this record hardly tells fo from next, that is, a lag from a "
                "dead time"),
            std::string::npos)
      << chosen;
  answer.models[1].validation->score.mse = 0.0676;
  answer.models[2].validation->score.mse = 0.0144;
  EXPECT_EQ(chosen_in(short_report(answer, {})).find("hardly tells"), std::string::npos) << "it errs 2.6 times as much";
  answer.models[1].validation->score.mse = 0.0169;
  answer.models[2].validation->score.mse = 1.0;
  EXPECT_NE(text.find("The first one; do this."), std::string::npos) << text;
  EXPECT_NE(text.find("The second one.\n"), std::string::npos) << text;
  EXPECT_NE(recommendation_text(answer, {}).find("AR-BIC of -5552.1"), std::string::npos) << "-v and the report";
  for (std::size_t i : {1U, 2U}) answer.models[i].verdict->accepted = false;
  EXPECT_NE(chosen_in(short_report(answer, {})).find("; the checks let no other one pass"), std::string::npos);
}

TEST(ShortReport, SaysThatTheRunnerUpErrsLessWhereItDoes) {
  Answer answer = answer_with("");
  answer.models[0].validation->score.mse = 0.01;
  answer.models.push_back(answer.models[0]);
  answer.models.back().name = "next";
  answer.recommendation.runner_up = "next";
  for (ident::Model& model : answer.models) model.verdict->accepted = true;
  const auto says = [&](double factor) {
    answer.models.back().validation->score.mse = 0.01 * factor * factor;
    return chosen_in(short_report(answer, {}));
  };
  EXPECT_NE(says(0.55).find("next, errs 0.55 times as much (rms, on unseen data)"), std::string::npos) << says(0.55);
  EXPECT_NE(says(0.55).find("unseen data): take that to simulate"), std::string::npos) << says(0.55);
  EXPECT_EQ(says(0.8).find("take that to simulate"), std::string::npos) << says(0.8);
  EXPECT_NE(says(1.2).find("next, errs 1.2 times as much (rms, on unseen data)"), std::string::npos) << says(1.2);
  answer.recommendation.runner_up = "";
  EXPECT_NE(says(0.55).find("; next errs 0.55 times as much (rms, on unseen data): take that to simulate"),
            std::string::npos);
  answer.recommendation.runner_up = "next";
  for (const double alike : {0.91, 1.09}) EXPECT_NE(says(alike).find("next, errs as little"), std::string::npos);
}

TEST(ShortReport, CallsAnAcceptedModelOutdoneThatTheRecommendedOneBeatsClearly) {
  Answer answer = answer_with("");
  answer.models.push_back(answer.models[0]);
  answer.models[1].name = "worse";
  ident::Verdict& verdict = *answer.models[1].verdict;
  verdict.accepted = true;
  verdict.grade = ident::Grade::usable;
  EXPECT_EQ(short_report(answer, {}).find("outdone"), std::string::npos);
  verdict.criteria.push_back(
      {.kind = ident::CriterionKind::above_recommended, .value = 602.0, .limit = 10.0, .passed = false});
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("  outdone\n"), std::string::npos) << text;
  EXPECT_NE(text.find("outdone: no check rejects it, but"), std::string::npos) << text;
  // One that errs less has the reason beside the word.
  answer.models[0].validation->score.mse = 0.01;
  answer.models[1].validation->score.mse = 0.01 * 0.56 * 0.56;
  answer.models[1].parameters.push_back({.name = "b1", .value = 1.0, .fixed = false});
  answer.recommendation.runner_up = "worse";
  const std::string closer = short_report(answer, {});
  EXPECT_NE(closer.find("  outdone for its 1 parameter more\n"), std::string::npos) << closer;
  EXPECT_NE(
      chosen_in(closer).find("worse (outdone for its 1 parameter more, which the part of the record that estimated "
                             "it does not justify), errs 0.56 times as much"),
      std::string::npos)
      << chosen_in(closer);
  answer.models[1].parameters.pop_back();
  EXPECT_NE(chosen_in(short_report(answer, {})).find("(outdone as it describes the part of the record that estimated"),
            std::string::npos);
  answer.recommendation.runner_up = "";
  verdict.grade = ident::Grade::rejected;
  EXPECT_EQ(short_report(answer, {}).find("outdone"), std::string::npos) << "rejected says more";
}

TEST(ShortReport, WarnsBesideTheFiguresOfAPoleAndAZeroThatNearlyCancel) {
  Answer answer = answer_with("");
  answer.models[0].transfer_function = {{{0.17, 1.0}, {1.0, 0.0}},
                                        {{0.0156, 2.0}, {0.256, 1.0}, {1.0, 0.0}},
                                        0.0};  // (0.17 s + 1) / ((0.156 s + 1)(0.1 s + 1))
  const std::string text = answer_text(answer, {});
  EXPECT_NE(text.find("A pole and a zero nearly cancel"), std::string::npos)
      << "as `eha commission` shows it: " << text;
  const std::string whole = short_report(answer, {});
  EXPECT_EQ(whole.find("nearly cancel"), whole.rfind("nearly cancel")) << "once: " << whole;
}

TEST(ShortReport, SaysOfAUsableModelWhyItIsNotRecommended) {
  Answer answer = answer_with("");
  answer.recommendation = {.reason = "the rod met its end stop", .accepted_instead = "io is usable: it is held back"};
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("recommended     none\n"), std::string::npos) << text;
  EXPECT_NE(text.find("not rejected    io is usable: it is held back\n"), std::string::npos) << text;
}

TEST(ShortReport, CountsModelsThatAreNotAcceptedByTheWordOfTheTable) {
  Answer answer = answer_with("");
  EXPECT_EQ(words_of_rejected(answer.models), "");
  answer.models[0].verdict->accepted = false;
  answer.models[0].verdict->grade = ident::Grade::rejected;
  answer.models.push_back(answer.models[0]);
  const std::string word(ident::verdict_word(*answer.models[0].verdict));
  EXPECT_EQ(words_of_rejected(answer.models), "2 " + word);
}

TEST(ShortReport, GivesAReasonThatModelsShareOnce) {
  Answer answer = answer_with("none");
  ident::Model& model = answer.models[0];
  model.verdict->accepted = false;
  model.verdict->grade = ident::Grade::rejected;
  model.verdict->reasons = {"The rod stands on an end stop from 0.39 s."};
  for (const char* name : {"integrator_lag_valve", "cylinder"}) {
    answer.models.push_back(answer.models[0]);
    answer.models.back().name = name;
  }
  const std::string text = short_report(answer, {});
  const std::size_t at = text.find("0.39");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_EQ(text.find("0.39", at + 1), std::string::npos) << text;
  EXPECT_NE(text.find("\n3 models        "), std::string::npos) << text;
  EXPECT_NE(text.find("integrator_lag_valve,"), std::string::npos) << text;
}

TEST(ShortReport, GivesAReasonInTheAskedUnitAlone) {
  Answer answer = answer_with("none");
  ident::Model& model = answer.models[0];
  model.output_unit = "in";
  model.validation->score.error_max = 0.5;
  ident::Verdict& verdict = model.verdict.emplace();
  verdict.criteria = {{ident::CriterionKind::max_abs_error, "validation", 0.5, 0.25, false}};
  verdict.reasons = {"The greatest validation error of 0.5 in is above the limit of 0.25 in."};
  answer.recommendation.reason = model.name + " is rejected: " + verdict.reasons[0];
  const std::string text = short_report(answer, DisplayUnit("mm"));
  EXPECT_EQ(text.find(" in is"), std::string::npos) << text;
  EXPECT_EQ(text.find("0.5 in"), std::string::npos) << text;
  EXPECT_NE(text.find("12.7"), std::string::npos) << text;
  EXPECT_NE(text.find("6.35"), std::string::npos) << text;
}

/// A model of this name whose only failed criterion is of a kind.
ident::Model rejected_for(const std::string& name, ident::CriterionKind kind) {
  ident::Model model = model_that(Came::accepted).result.model;
  model.name = name;
  ident::Verdict& verdict = model.verdict.emplace();
  verdict.criteria = {{kind, "a0", 0.0, 0.0, false}};
  return model;
}

TEST(ShortReport, BeginsWithTheRecommendedModelAndCallsNoModelWrongThatIsNot) {
  Answer answer = answer_with("");
  answer.models.insert(answer.models.begin(), rejected_for("bigger", ident::CriterionKind::coefficient_interval));
  answer.models.front().verdict->error_over_recommended = 1.1;
  answer.models.insert(answer.models.begin(), rejected_for("wrong", ident::CriterionKind::r2));
  const std::string text = short_report(answer, {});
  const std::size_t table = text.find("\nmodel ");
  const std::size_t recommended = text.find("\n" + answer.models.back().name + " ", table);
  const std::size_t bigger = text.find("\nbigger ", table);
  const std::size_t wrong = text.find("\nwrong ", table);
  ASSERT_NE(wrong, std::string::npos) << text;
  EXPECT_LT(recommended, bigger) << text;
  EXPECT_LT(bigger, wrong) << text;
  EXPECT_NE(text.substr(bigger, wrong - bigger).find("not needed"), std::string::npos) << text;
  EXPECT_NE(text.substr(wrong, 80).find("rejected"), std::string::npos) << text;
}

TEST(ShortReport, GivesAReasonOnceThatDiffersInItsFiguresAlone) {
  Answer answer = answer_with("");
  answer.models.insert(answer.models.begin(), 2, rejected_for("wrong", ident::CriterionKind::r2));
  answer.recommendation.model.clear();
  answer.models[0].verdict->reasons = {"R2 of -0.3 % is below 90 %."};
  answer.models[1].verdict->reasons = {"R2 of 12.5 % is below 90 %."};
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("2 models"), std::string::npos) << text;
  EXPECT_EQ(text.find("12.5"), std::string::npos) << text;
}

TEST(ShortReport, GivesAReasonThatLiesInTheRecordOnce) {
  Answer answer = answer_with("");
  answer.models.insert(answer.models.begin(), 2, rejected_for("wrong", ident::CriterionKind::r2));
  answer.recommendation.model.clear();
  answer.recommendation.reason = "The rod stands on an end stop from 12.1 s on; cut with --to 12.08";
  answer.models[0].verdict->reasons = {"The rod stands on an end stop from 12.1 s on; cut with --to 12.08."};
  answer.models[1].verdict->reasons = {"The rod stands on an end stop from 12.3 s on; cut with --to 12.28."};
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("because         The rod stands"), std::string::npos) << text;
  EXPECT_EQ(text.find("2 models"), std::string::npos) << text;
}

TEST(ShortReport, ShowsTheEstimationsFiguresWhereNothingWasLeftUnseen) {
  Answer answer = answer_with("");
  answer.models[0].validation.reset();
  ident::Score score;
  score.fit_percent = 97.25;
  score.r2_percent = 99.92;
  answer.models[0].estimation.emplace().score = score;
  const std::string text = short_report(answer, {});
  EXPECT_NE(text.find("\non its own data fit 97.2 %, R2 99.92 %; nothing was left unseen (--split 1)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("fit, R2, largest error: on the samples that estimated the model."), std::string::npos) << text;
}

TEST(Wrapped, BreaksBetweenWordsAndIndents) {
  const std::string word(30, 'a');
  EXPECT_EQ(wrapped(word + " " + word + " " + word, 4), word + " " + word + "\n    " + word);
  EXPECT_EQ(wrapped("", 4), "");
}

TEST(Wrapped, BeginsNoLineWithAStepThatStandsWithinTheText) {
  for (const char* step : {"Next: eha arm", "Next:eha", "Next: Next: Next:"}) {
    for (std::size_t blanks = 1; blanks < 100; ++blanks) {
      for (const std::size_t letters : {0U, 1U, 40U, 63U, 64U, 75U, 90U}) {
        const std::string text =
            wrapped("reason " + std::string(letters, 'x') + std::string(blanks, ' ') + step + " more", 16);
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
          const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
          EXPECT_FALSE(line.substr(first).starts_with("Next:")) << blanks << ' ' << letters << '\n' << text;
        }
      }
    }
  }
  EXPECT_EQ(wrapped("Next: a record, because", 0), "Next: a record, because") << "eha's own";
}

TEST(Wrapped, KeepsACommandInOnePiece) {
  const std::string command = "`eha fit record.csv --model io --poles 3 --zeros 2`";
  const std::string text = wrapped(std::string(40, 'a') + " (" + command + ") and more of the sentence behind it", 16);
  EXPECT_NE(text.find("\n                (" + command + ") and"), std::string::npos) << text;
}

TEST(ShortReport, BreaksALineThatACompletedCommandMadeTooLong) {
  const std::string triangle = "a record of a slow triangle of volts about 0, wider than the dead band,";
  const std::string before =
      "valve map       null -0.2 V\n                further: `eha characterise` measures it\nend";
  const std::string after = "valve map       null -0.2 V\n                further: " + triangle + " measures it\nend";
  EXPECT_EQ(wrapped_where_longer(before, after),
            "valve map       null -0.2 V\n"
            "                further: a record of a slow triangle of volts about 0, wider\n"
            "                than the dead band, measures it\nend");
  EXPECT_EQ(wrapped_where_longer("because         x `c`", "because         x " + triangle),
            "because         x a record of a slow triangle of volts about 0, wider than the\n"
            "                dead band,");
  EXPECT_EQ(wrapped_where_longer(" `c`", " " + triangle + " " + triangle),
            " a record of a slow triangle of volts about 0, wider than the dead band, a\n"
            " record of a slow triangle of volts about 0, wider than the dead band,")
      << "by one column";
  EXPECT_EQ(wrapped_where_longer("because         measure it (`c`) once: a sheet that shows no leak at all leaves dry\n"
                                 "                friction.\n                The next one.",
                                 "because         measure it (" + triangle +
                                     ") once: a sheet that shows no leak at all leaves dry\n"
                                     "                friction.\n                The next one."),
            "because         measure it (a record of a slow triangle of volts about 0, wider\n"
            "                than the dead band,) once: a sheet that shows no leak at all\n"
            "                leaves dry friction.\n                The next one.")
      << "the sentence moves up, the next one stays below";
  const std::string table = std::string(60, '-') + "  " + std::string(60, '-') + "\n";
  EXPECT_EQ(wrapped_where_longer(table, table), table) << "a line that nothing was put into stays as it is";
}

}  // namespace
}  // namespace eha::cli
