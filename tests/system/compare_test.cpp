// SPDX-License-Identifier: GPL-3.0-or-later
// `eha compare` and `eha replay` as a user meets them: two runs of the simulated rig, the second with another valve.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class TwoRuns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    std::string changed = content_of(source_file("config/rigs/sim.toml"));
    const std::string key = "valve_dead_band_V = 0.15 ";
    changed.replace(changed.find(key), key.size(), "valve_dead_band_V = 0.22 ");
    folder_->write("changed.toml", changed);
    before_ = run(source_file("config/rigs/sim.toml"), "before");
    after_ = run("changed.toml", "after");
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string run(const std::string& rig, const std::string& output) {
    const Ended ended = run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", rig,
                                 "--output", output, "--json"},
                                folder_->path());
    return json::parse(ended.out).at("run").get<std::string>();
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline std::string before_;
  static inline std::string after_;
};

TEST_F(TwoRuns, CompareNamesTheDeadBand) {
  const Ended text = run_eha({"compare", before_, after_, "-o", "bode.svg"}, folder_->path());
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("dead_band moved by 0.0"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("\nTo do: Look on the bench for what changed. dead_band: commonly the valve"),
            std::string::npos)
      << text.out;
  EXPECT_NE(text.out.find("\nNext: eha characterise"), std::string::npos) << text.out;
  EXPECT_NE(content_of(folder_->path() / "bode.svg").find("<svg"), std::string::npos);
  const Ended ended = run_eha({"compare", before_, after_, "--json"}, folder_->path());
  const json change = json::parse(ended.out).at("runs").at(1).at("change");
  EXPECT_TRUE(change.at("changed").get<bool>());
  EXPECT_EQ(change.at("parameters").at(0).at("name"), "dead_band");
  for (const json& parameter : change.at("parameters")) {
    EXPECT_EQ(parameter.at("changed").get<bool>(), parameter.at("name") == "dead_band") << parameter;
  }
  EXPECT_NEAR(change.at("parameters").at(0).at("difference").get<double>(), 0.07, 0.005);
}

/// The files of the rigs that a text's commands name; "" for a command without one.
std::vector<std::string> rigs_named_in(const std::string& text) {
  const std::string command = "eha characterise -o ";
  std::vector<std::string> rigs;
  for (std::size_t at = text.find(command); at != std::string::npos; at = text.find(command, at + 1)) {
    const std::string line = text.substr(at, text.find_first_of("`\n<", at) - at);
    const std::string option = "--rig ";
    const std::size_t rig = line.find(option);
    rigs.push_back(rig == std::string::npos ? "" : fs::path(line.substr(rig + option.size())).filename().string());
  }
  return rigs;
}

TEST_F(TwoRuns, CompareOfSeveralRigsNamesThatOfTheRunThatChanged) {
  const Ended ended = run_eha({"compare", before_, after_, before_, "-o", "several.html"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(rigs_named_in(ended.out), std::vector<std::string>(3, "changed.toml")) << ended.out;
  const std::vector<std::string> on_page = rigs_named_in(content_of(folder_->path() / "several.html"));
  EXPECT_FALSE(on_page.empty());
  EXPECT_EQ(on_page, std::vector<std::string>(on_page.size(), "changed.toml"));
  // One command is for one rig: what all that changed have in common names none.
  folder_->write("other.toml", content_of(folder_->path() / "changed.toml"));
  const std::string other = run("other.toml", "other");
  const Ended both = run_eha({"compare", before_, after_, other}, folder_->path());
  ASSERT_EQ(both.code, 0) << both.err;
  EXPECT_EQ(rigs_named_in(both.out), (std::vector<std::string>{"changed.toml", "other.toml", "other.toml"}))
      << both.out;
  EXPECT_NE(both.out.find("a valve sheet of each rig"), std::string::npos) << both.out;
}

TEST_F(TwoRuns, CompareWritesAReportThatNamesTheChange) {
  const Ended ended = run_eha({"compare", before_, after_, "-o", "changes.html", "--units", "mm"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find(" mm, "), std::string::npos) << ended.out;
  const std::string html = content_of(folder_->path() / "changes.html");
  EXPECT_NE(html.find("<h2>The plant changed: half dead band "), std::string::npos) << html.substr(0, 9000);
  EXPECT_NE(html.find("dead_band moved by 0.0"), std::string::npos);
  EXPECT_NE(html.find("measured [mm]"), std::string::npos);
  if (std::system("command -v tidy >/dev/null") == 0) {
    EXPECT_EQ(std::system(("tidy -q -e '" + (folder_->path() / "changes.html").string() + "'").c_str()), 0);
  }
}

TEST_F(TwoRuns, CompareOfARunHasTheUsableBandOfItsOwnReport) {
  const Ended ended = run_eha({"compare", before_, after_, "-o", "band.html"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(content_of(folder_->path() / "band.html").find(", 0.05 to 0.65 Hz."), std::string::npos);
}

TEST_F(TwoRuns, CompareOfModelsCarriesTheirGradesAndBlamesNoRig) {
  const std::string good = before_ + "/models/integrator_lag_valve.json";
  const std::string bad = before_ + "/models/rejected/fo.json";
  const Ended ended = run_eha({"compare", good, bad, before_, "-o", "models.html"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find(" rejected\n"), std::string::npos) << ended.out;
  const std::string html = content_of(folder_->path() / "models.html");
  EXPECT_NE(html.find("<section class=\"verdict some\"><h2>Both models are of this record&#39;s plant; use "
                      "integrator_lag_valve: rms error "),
            std::string::npos)
      << html.substr(html.find("<section"), 2000);
  EXPECT_NE(html.find("fo: rejected by the fit that made it; R2 "), std::string::npos);
  EXPECT_NE(html.find("To do: Do not use fo"), std::string::npos);
  EXPECT_NE(html.find("Scored on the whole record with the offset estimated again"), std::string::npos);
  EXPECT_EQ(html.find("the plants differ"), std::string::npos);
  EXPECT_EQ(html.find("A lower speed is a lower gain"), std::string::npos);
}

TEST_F(TwoRuns, CompareClaimsNoChangeByAModelThatDoesNotFitItsRecord) {
  // The second signal does not come from the rig: it swings faster and faster.
  std::string other;
  const std::string rows = content_of(folder_->path() / before_ / "data_40ms.csv");
  int row = 0;
  for (std::size_t at = 0; at < rows.size();) {
    const std::size_t end = std::min(rows.find('\n', at), rows.size());
    const std::string line = rows.substr(at, end - at);
    const bool is_number = !line.empty() && std::isdigit(static_cast<unsigned char>(line.front()));
    other += is_number ? line.substr(0, line.rfind(',') + 1) + std::to_string(3.0 + std::sin(2e-3 * row * row)) : line;
    other += '\n';
    if (is_number) ++row;
    at = end + 1;
  }
  folder_->write("unrelated.csv", other);
  folder_->write("own.csv", rows);
  const Ended ended = run_eha({"compare", "own.csv", "unrelated.csv", "-o", "unfit.html"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string heading = ended.out.substr(0, ended.out.find('\n'));
  EXPECT_TRUE(heading.starts_with("No model that suits the one record suits the other; io")) << ended.out;
  EXPECT_TRUE(heading.ends_with(" does not fit unrelated")) << ended.out;
  EXPECT_EQ(ended.out.find(" moved by "), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("it does not hold."), std::string::npos) << ended.out;
  const std::string html = content_of(folder_->path() / "unfit.html");
  EXPECT_NE(html.find(heading), std::string::npos) << "one sentence on both";
  EXPECT_EQ(html.find("valve of unrelated"), std::string::npos) << "no picture of a model that does not fit";
}

TEST_F(TwoRuns, CompareFindsNothingBetweenARunAndItself) {
  const Ended ended = run_eha({"compare", before_, before_}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(
      ended.out.starts_with("The same plant, as far as these records show: no parameter changed, and the "
                            "first model holds\n"))
      << ended.out;
  EXPECT_NE(ended.out.find("the model fitted there: it holds."), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("  Tested: "), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("Not tested: what these do not describe, as friction"), std::string::npos) << ended.out;
}

TEST_F(TwoRuns, CompareClaimsNothingOfOneRigWhoseInputsDiffer) {
  std::string other = content_of(source_file("config/experiments/paper.toml"));
  for (const auto& [tone, faster] : {std::pair{"= 0.65", "= 1.2"}, std::pair{"= 0.20", "= 0.44"}}) {
    const std::size_t at = other.find(tone);
    ASSERT_NE(at, std::string::npos) << tone;
    other.replace(at, std::string_view(tone).size(), faster);
  }
  folder_->write("other.toml", other);
  const Ended played = run_eha({"run", "other.toml", "--local", "--fast", "--rig", source_file("config/rigs/sim.toml"),
                                "--output", "other", "--json"},
                               folder_->path());
  const std::string again = json::parse(played.out).at("run").get<std::string>();
  const Ended compared = run_eha({"compare", before_, again}, folder_->path());
  const std::string found = compared.out.substr(0, compared.out.find('\n'));
  EXPECT_TRUE(found.starts_with("Not shown whether the plant has changed") || found.starts_with("The same plant"))
      << found;
}

TEST_F(TwoRuns, CompareScoresModelsOnARecord) {
  const Ended fitted =
      run_eha({"fit", before_, "--model", "io", "--input-map", "valve", "-o", "m", "-q"}, folder_->path());
  ASSERT_TRUE(std::filesystem::exists(folder_->path() / "m/io_valve.json")) << fitted.err;
  const Ended here = run_eha({"compare", "m/io_valve.json", before_, "--json"}, folder_->path());
  ASSERT_EQ(here.code, 0) << here.err;
  EXPECT_EQ(json::parse(here.out).at("models").at(0).at("plant"), "this") << here.out;
  const Ended there = run_eha({"compare", "m/io_valve.json", after_, "--json"}, folder_->path());
  const json model = json::parse(there.out).at("models").at(0);
  EXPECT_EQ(model.at("plant"), "another") << there.out;
  EXPECT_GT(model.at("r2_reestimated_percent").get<double>(), 95.0);
  const Ended shown = run_eha({"compare", "m/io_valve.json", after_, "-o", "there.html"}, folder_->path());
  ASSERT_EQ(shown.code, 0) << shown.err;
  const std::string html = content_of(folder_->path() / "there.html");
  const std::string box = html.substr(0, html.find("</section>"));
  EXPECT_NE(box.find("its error is "), std::string::npos) << box;
  EXPECT_NE(box.find("dead_band moved by 0.0"), std::string::npos) << box;
  EXPECT_NE(box.find("To do: Use no model of another plant"), std::string::npos) << box;
  EXPECT_NE(html.find("Measured output, the models on it, and their errors"), std::string::npos);
}

TEST_F(TwoRuns, CompareOffersNoWorseModelInThePlaceOfOneOfAnotherPlant) {
  const Ended fitted =
      run_eha({"fit", before_, "--model", "integrator_lag", "--model", "integrator_lag_valve", "-o", "crude", "-q"},
              folder_->path());
  ASSERT_TRUE(fs::exists(folder_->path() / "crude/integrator_lag.json")) << fitted.err;
  const Ended compared = run_eha(
      {"compare", "crude/integrator_lag_valve.json", "crude/integrator_lag.json", after_, "--json"}, folder_->path());
  const json models = json::parse(compared.out).at("models");
  EXPECT_EQ(models.at(0).at("plant"), "another") << compared.out;
  EXPECT_EQ(models.at(1).at("plant"), "unknown") << compared.out;
  const Ended shown =
      run_eha({"compare", "crude/integrator_lag_valve.json", "crude/integrator_lag.json", after_}, folder_->path());
  EXPECT_NE(shown.out.find("use none of them"), std::string::npos) << shown.out;
}

TEST_F(TwoRuns, ValidateJudgesAsCompareDoes) {
  const Ended fitted =
      run_eha({"fit", before_, "--model", "integrator_lag", "--input-map", "valve", "-o", "v", "-q"}, folder_->path());
  ASSERT_TRUE(std::filesystem::exists(folder_->path() / "v/integrator_lag_valve.json")) << fitted.err;
  const Ended here = run_eha({"validate", "v/integrator_lag_valve.json", before_}, folder_->path());
  EXPECT_EQ(here.code, 0) << here.out << here.err;
  EXPECT_NE(here.out.find("Lags outside the bounds: the error is more than white noise"), std::string::npos)
      << here.out;
  EXPECT_NE(here.out.find("do not reject it"), std::string::npos) << here.out;
  const Ended finer =
      run_eha({"validate", "v/integrator_lag_valve.json", before_, "--decimate", "20"}, folder_->path());
  EXPECT_NE(finer.err.find("is scored on samples every 0.02 s"), std::string::npos) << finer.err;
  EXPECT_NE(finer.err.find("alike: `eha validate v/integrator_lag_valve.json " + before_ + " --decimate 40`"),
            std::string::npos)
      << finer.err;
  const Ended there = run_eha({"validate", "v/integrator_lag_valve.json", after_}, folder_->path());
  EXPECT_EQ(there.code, static_cast<int>(ExitCode::model_rejected)) << there.out;
  EXPECT_NE(there.out.find("It is a model of another plant, or the plant has changed"), std::string::npos) << there.out;
  EXPECT_NE(there.out.find("dead_band moved by 0.0"), std::string::npos) << there.out;
  EXPECT_NE(there.out.find("R2 99."), std::string::npos) << "a good score does not hide it\n" << there.out;
  const Ended part = run_eha({"validate", "v/integrator_lag_valve.json", after_, "--from", "12"}, folder_->path());
  EXPECT_NE(part.out.find("Next: eha compare v/integrator_lag_valve.json " + after_), std::string::npos)
      << "`eha import` takes no run\n"
      << part.out << part.err;
  EXPECT_NE(there.out.find("Next: eha compare v/integrator_lag_valve.json " + after_ + " -o comparison.html"),
            std::string::npos)
      << there.out;
  EXPECT_EQ(there.out.find("xdg-open"), std::string::npos) << "that report does not show the model";
}

TEST_F(TwoRuns, CompareTakesTheInputOfAFileAsStraight) {
  // Every 40th row of a run: the input moved between them.
  for (const auto& [run, name] : {std::pair(before_, "before.csv"), std::pair(after_, "after.csv")}) {
    folder_->write(name, content_of(folder_->path() / run / "data_40ms.csv"));
  }
  const auto left_over = [&](std::vector<std::string> options) {
    std::vector<std::string> words{"compare", "before.csv", "after.csv", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const Ended ended = run_eha(words, folder_->path());
    EXPECT_EQ(ended.code, 0) << ended.err;
    return json::parse(ended.out).at("runs").at(1).at("left_over").at("rms_before").get<double>();
  };
  const double straight = left_over({"--intersample", "foh"});
  EXPECT_LT(straight, 0.8 * left_over({"--intersample", "zoh"}));
  EXPECT_NEAR(left_over({}), straight, 1e-9) << "both files show it";
  expect_refused(*folder_, {"compare", before_, after_, "--intersample", "foh"}, ExitCode::usage,
                 {"the input of a run is held"});
}

TEST_F(TwoRuns, ValidateTakesTheInputBetweenTheRowsAsTheErrorShowsIt) {
  folder_->write("thin.csv", content_of(folder_->path() / before_ / "data_40ms.csv"));
  static_cast<void>(
      run_eha({"fit", "thin.csv", "--model", "integrator_lag_valve", "-o", "straight", "-q"}, folder_->path()));
  const std::string model = "straight/integrator_lag_valve.json";
  const std::string held = source_file("config/records/bench.csv");
  const Ended ended = run_eha({"validate", model, held}, folder_->path());
  EXPECT_NE(ended.err.find("is held between its rows, and so it is taken here"), std::string::npos) << ended.err;
  const Ended told = run_eha({"validate", model, held, "--intersample", "foh"}, folder_->path());
  EXPECT_EQ(told.err.find("and so it is taken here"), std::string::npos) << told.err;
  const Ended exported = run_eha({"export", model, "--format", "python", "-o", "plant.py"}, folder_->path());
  EXPECT_NE(exported.err.find("its input was straight between the rows"), std::string::npos) << exported.err;
  EXPECT_NE(content_of(folder_->path() / "plant.py").find("Its input was straight between the rows"),
            std::string::npos);
}

TEST(CompareOfFiles, SaysThatASensorDriftsAndCertifiesNoPlantByOneThatFroze) {
  const TemporaryFolder folder;
  // A lag behind a dead time, with steps of drawn levels.
  const auto write = [&](const char* name, unsigned seed, double drift, int frozen_rows) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.02);
    std::uniform_real_distribution<double> level(-2.0, 2.0);
    std::vector<double> volts;
    std::string text = "time_s,valve_V,rod_mm\n";
    double place = 0.0;
    double shown = 0.0;
    for (int k = 0; k < 4000; ++k) {
      volts.push_back(k % 25 == 0 ? level(random) : volts.back());
      if (k < 1600 || k >= 1600 + frozen_rows) shown = 20.0 + place + 0.01 * drift * k + noise(random);
      text += fmt::format("{:.2f},{:.5f},{:.5f}\n", 0.01 * k, volts.back(), shown);
      const double acts = k >= 6 ? volts[static_cast<std::size_t>(k - 6)] : 0.0;
      place += (1.0 - std::exp(-0.01 / 0.25)) * (3.0 * acts - place);
    }
    folder.write(name, text);
  };
  write("before.csv", 1, 0.0, 0);
  write("same.csv", 2, 0.0, 0);
  write("drifts.csv", 3, 0.03, 0);
  write("freezes.csv", 4, 0.0, 300);
  const Ended same = run_eha({"compare", "before.csv", "same.csv"}, folder.path());
  EXPECT_EQ(same.out.find("The same plant"), 0U) << same.out;
  const Ended drifts = run_eha({"compare", "before.csv", "drifts.csv"}, folder.path());
  EXPECT_NE(drifts.out.find("the first model holds beside a drift of the output"), std::string::npos) << drifts.out;
  EXPECT_NE(drifts.out.find("To do: drifts.csv: the output drifts by 1.2 mm over the record"), std::string::npos)
      << drifts.out;
  const Ended freezes = run_eha({"compare", "before.csv", "freezes.csv"}, folder.path());
  EXPECT_EQ(freezes.out.find("Not shown whether the plant has changed"), 0U) << freezes.out;
  EXPECT_EQ(freezes.out.find("To do: Nothing"), std::string::npos) << freezes.out;
}

TEST(CompareOfFiles, TakesTheOptionsOfReadingForEachOfThem) {
  const TemporaryFolder folder;
  // Neither file has a time, and volts stand in two columns.
  const auto write = [&](const char* name, double gain) {
    std::string text = "A [V],B [V],Rod [mm]\n";
    double place = 70.0;
    for (int k = 0; k < 1500; ++k) {
      const double volts = std::sin(0.05 * k) + 0.7 * std::sin(0.171 * k + 1.0) + 0.5 * std::sin(0.493 * k + 2.0);
      text += std::to_string(volts) + "," + std::to_string(5.0 + 0.01 * (k % 7)) + "," + std::to_string(place) + "\n";
      place += 0.02 * gain * volts;
    }
    folder.write(name, text);
  };
  write("before.csv", 20.0);
  write("after.csv", 26.0);
  const Ended asked = run_eha({"compare", "before.csv", "after.csv"}, folder.path());
  EXPECT_EQ(asked.code, static_cast<int>(ExitCode::bad_data));
  EXPECT_NE(asked.err.find("eha import before.csv"), std::string::npos) << asked.err;
  const Ended ended =
      run_eha({"compare", "before.csv", "after.csv", "--period", "0.02", "--input", "A [V]"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find("Next: eha fit after.csv --period 0.02 --input 'A [V]'"), std::string::npos) << ended.out;
  const Ended wrong = run_eha({"compare", "before.csv", "after.csv", "--period", "0.02"}, folder.path());
  EXPECT_NE(wrong.err.find("eha compare before.csv after.csv --period 0.02 --input 1 --output 3`"), std::string::npos)
      << wrong.err;
}

TEST_F(TwoRuns, ARunTellsALeakFromAnotherValve) {
  const auto warned = [&](const std::string& rig) {
    return run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", rig, "--output",
                    "valves"},
                   folder_->path())
        .err;
  };
  // Oil past the piston bends the fit's null by 0.2 V; the valve is that of [following].
  const std::string leaky = warned(source_file("config/rigs/sim-leaky.toml"));
  EXPECT_EQ(leaky.find("are for another valve"), std::string::npos) << leaky;
  EXPECT_NE(leaky.find("are not the valve's. [following]"), std::string::npos) << leaky;
  EXPECT_NE(leaky.find("warning: of integrator_lag_valve: the rod moves within that dead band"), std::string::npos)
      << leaky;
  // As the fit of the same run does, also where [following] agrees with the model.
  const std::string worn = warned(source_file("config/rigs/sim-worn.toml"));
  EXPECT_NE(worn.find("whatever their intervals say"), std::string::npos) << worn;
  EXPECT_NE(worn.find("warning: of "), std::string::npos) << worn;
  const std::string changed = warned("changed.toml");
  EXPECT_NE(changed.find("are for another valve"), std::string::npos) << changed;
}

TEST_F(TwoRuns, NamesALeakWhereItExplainsAMovedNull) {
  const auto recorded = [&](const std::string& rig, const std::string& name) {
    const Ended run = run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig",
                               source_file("config/rigs/" + rig), "--output", name},
                              folder_->path());
    EXPECT_EQ(run.code, 0) << run.err;
    return name + "/latest";
  };
  const std::string sound = recorded("sim.toml", "sound");
  const auto compared = [&](const std::string& other) {
    return run_eha({"compare", sound, other, "-o", "leak.html"}, folder_->path()).out;
  };
  const std::string leaky = compared(recorded("sim-leaky.toml", "leaky"));
  EXPECT_NE(leaky.find("a leak alone explains their change"), std::string::npos) << leaky;
  EXPECT_NE(content_of(folder_->path() / "leak.html").find("a leak alone explains"), std::string::npos);
  const std::string worn = compared(recorded("sim-worn.toml", "worn"));
  EXPECT_NE(worn.find("null moved by"), std::string::npos) << worn;
  EXPECT_EQ(worn.find("a leak alone explains"), std::string::npos) << worn;
}

TEST_F(TwoRuns, ReplayOnItsOwnRigLeavesTheSensorsNoise) {
  const Ended ended =
      run_eha({"replay", before_, "--rig", source_file("config/rigs/sim.toml"), "-o", "overlay.csv", "--json"},
              folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_GT(json::parse(ended.out).at("r2_percent").get<double>(), 99.9);
  EXPECT_EQ(content_of(folder_->path() / "overlay.csv").rfind("time_s,voltage_V,measured_in,replayed_in\n", 0), 0U);
}

TEST_F(TwoRuns, ReplayCalibratesATwinThatTheProgramRuns) {
  const Ended ended = run_eha({"replay", after_, "--rig", source_file("config/rigs/sim.toml"), "--twin", "twin.toml",
                               "--json", "--calibrate", "valve_dead_band_V", "valve_null_offset_V=0.05:0.6"},
                              folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json parameters = json::parse(ended.out).at("parameters");
  EXPECT_NEAR(parameters.at(0).at("value").get<double>(), 0.22, 0.05 * 0.22);
  EXPECT_NEAR(parameters.at(1).at("value").get<double>(), 0.2, 0.05 * 0.2);
  EXPECT_EQ(run_eha({"check", "twin.toml"}, folder_->path()).code, 0);
}

TEST_F(TwoRuns, ReplayThatLeavesMoreThanNoiseAddsAKey) {
  const std::string rig = source_file("config/rigs/sim.toml");
  const Ended doubtful =
      run_eha({"replay", after_, "--rig", rig, "--twin", "doubtful.toml", "--calibrate", "valve_null_offset_V"},
              folder_->path());
  ASSERT_EQ(doubtful.code, 0) << doubtful.err;
  EXPECT_NE(doubtful.err.find("refused by name): valve_dead_band_V, valve_rated_flow_L_per_min"), std::string::npos)
      << doubtful.err;
  EXPECT_NE(doubtful.out.find("doubtful.toml, whose [following] holds these doubtful numbers, too"), std::string::npos)
      << doubtful.out;
  EXPECT_NE(doubtful.out.find("--calibrate valve_null_offset_V valve_dead_band_V --twin doubtful.toml\n"),
            std::string::npos)
      << doubtful.out;
  EXPECT_EQ(doubtful.out.find("Next: eha run"), std::string::npos) << doubtful.out;
}

TEST_F(TwoRuns, RefuseWhatMakesNoSense) {
  expect_refused(*folder_, {"compare", before_}, ExitCode::usage, {"--help"});
  expect_refused(*folder_, {"compare", before_, "m.txt", "x.json"}, ExitCode::usage, {"MODEL.json"});
  const std::string rig = source_file("config/rigs/sim.toml");
  expect_refused(*folder_, {"replay", before_, "--rig", rig, "--calibrate", "mass"}, ExitCode::usage,
                 {"moving_mass_kg"});
  expect_refused(*folder_, {"replay", before_, "--rig", rig, "--calibrate", "bore_mm=1"}, ExitCode::usage,
                 {"LOW:HIGH"});
  expect_refused(*folder_,
                 {"replay", before_, "--rig", rig, "--calibrate", "valve_rated_flow_L_per_min", "valve_rated_drop_bar"},
                 ExitCode::bad_data, {"valve_rated_flow_L_per_min and valve_rated_drop_bar cannot be told apart"});
  expect_refused(*folder_, {"replay", before_, "--rig", source_file("config/rigs/pci1716.toml")}, ExitCode::usage,
                 {"simulated rig"});
}

}  // namespace
}  // namespace eha::test
