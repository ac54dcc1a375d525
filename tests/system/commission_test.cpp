// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/drawn_rigs.hpp"
#include "tests/unit/other_users.hpp"

namespace eha::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::filesystem::perms kOwnersFile = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;

/// One commissioning for all tests of the suite, by a link to the rig file.
class Commission : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    folder_->write("kept.toml", unknown_rig());
    std::filesystem::permissions(file("kept.toml"), kOwnersFile);
    std::filesystem::create_symlink("kept.toml", file("rig.toml"));
    ended_ = new Ended(run_eha({"commission", "rig.toml", "--yes", "--fast", "--precision", "2.5"}, folder_->path()));
  }
  static void TearDownTestSuite() {
    delete ended_;
    delete folder_;
  }
  static std::filesystem::path file(const std::string& name) { return folder_->path() / name; }
  static json state() { return json_of(file("commission/commission.json")); }

  static TemporaryFolder* folder_;
  static Ended* ended_;
};

TemporaryFolder* Commission::folder_ = nullptr;
Ended* Commission::ended_ = nullptr;

TEST_F(Commission, GoesFromAnUnknownValveToAnAxisThatKeepsItsPromise) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const json steps = state().at("steps");
  EXPECT_TRUE(steps.at("track").at("kept").get<bool>());
  EXPECT_NEAR(steps.at("sheet").at("dead_band_V").at("value").get<double>(), 0.15, 0.01);
  EXPECT_THAT(content_of(file("rig.toml")), HasSubstr("[following]"));
  EXPECT_EQ(content_of(file("commission/rig_before.toml")), unknown_rig());
  EXPECT_THAT(content_of(file("commission/report.html")), HasSubstr("follows its reference as promised"));
  const std::string page = content_of(file("commission/report.html"));
  EXPECT_THAT(page, HasSubstr("speed within the dead band: no leak to repair"));
  EXPECT_THAT(page, Not(HasSubstr("a sheet that shows no leak leaves friction")));
  EXPECT_THAT(page, HasSubstr("By the sweep the gain "));
  EXPECT_THAT(page, HasSubstr("<summary>Timing</summary>"));
  EXPECT_THAT(page, HasSubstr("<summary>Provenance</summary>"));
  EXPECT_THAT(ended_->out, HasSubstr("$ eha characterise"));
}

TEST_F(Commission, SaysOnThePageThatTheWantedPrecisionWasNotReached) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  EXPECT_THAT(content_of(file("commission/report.html")), Not(HasSubstr("precision was not reached")));
  std::filesystem::copy(file("commission"), file("missed"));
  json missed = json_of(file("missed/commission.json"));
  missed["steps"]["record"]["gain_percent"] = nullptr;
  folder_->write("missed/commission.json", missed.dump());
  const Ended again =
      run_eha({"commission", "rig.toml", "--yes", "--fast", "--precision", "2.5", "-o", "missed"}, folder_->path());
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(content_of(file("missed/report.html")),
              HasSubstr("The wanted precision was not reached: the gain has no interval by "));
}

TEST_F(Commission, WritesTheFileThatALinkLeadsTo) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  EXPECT_TRUE(std::filesystem::is_symlink(file("rig.toml")));
  EXPECT_THAT(content_of(file("kept.toml")), HasSubstr("[following]"));
  EXPECT_EQ(std::filesystem::status(file("kept.toml")).permissions(), kOwnersFile);
}

TEST_F(Commission, EndsTheRecordOnceTheGainIsKnown) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const json record = state().at("steps").at("record");
  EXPECT_EQ(record.at("outcome"), "precise_enough");
  EXPECT_LE(record.at("gain_percent").get<double>(), 2.5);
  const std::filesystem::path run = file(record.at("run").get<std::string>());
  const json manifest = json_of(run / "run.json");
  const double rows = manifest.at("report").at("counters").at("experiment_rows").get<double>();
  const double period = manifest.at("samples_per_repetition").get<double>();
  EXPECT_EQ(std::fmod(rows, period), 0.0) << "ended within a repetition";
  EXPECT_LT(rows, period * manifest.at("repetitions").get<double>());
}

TEST_F(Commission, JudgesTheRowsSoFarAsTheOfflineFitOfTheSameRows) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::filesystem::path run = file(state().at("steps").at("record").at("run").get<std::string>());
  const json seen = json_of(run / "precision" / "integrator_lag_valve.json");
  const json manifest = json_of(run / "run.json");
  // The row before the last one that was played: the judged repetition is the last but one.
  const double period_s = manifest.at("samples_per_repetition").get<double>() * 0.001;
  const double rows = manifest.at("report").at("counters").at("experiment_rows").get<double>();
  const double judged = rows / manifest.at("samples_per_repetition").get<double>() - 1.0;
  const Ended again = run_eha({"fit", run.string(), "--model", "integrator_lag", "--input-map", "valve", "--split", "1",
                               "--to", fmt::format("{:.6f}", judged * period_s - 0.0005), "-o", "offline"},
                              folder_->path());
  const json offline = json_of(file("offline") / "integrator_lag_valve.json");
  const json& expected = offline.at("parameters");
  ASSERT_EQ(seen.at("parameters").size(), expected.size()) << again.err;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (const char* member : {"value", "lower95", "upper95"}) {
      const double value = expected[i].at(member).get<double>();
      EXPECT_NEAR(seen.at("parameters")[i].at(member).get<double>(), value, 1e-9 * std::max(1e-3, std::abs(value)))
          << expected[i].at("name") << " " << member;
    }
  }
}

TEST_F(Commission, MeasuresTheMarginsThatWerePromised) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const json track = state().at("steps").at("track");
  bool is_measured = false;
  for (const json& figure : track.at("figures")) {
    if (figure.at("figure") != "phase margin") continue;
    is_measured = true;
    EXPECT_EQ(figure.at("promised_is"), "least");
    EXPECT_GT(figure.at("measured").get<double>(), figure.at("promised_to").get<double>());
    EXPECT_LT(figure.at("measured").get<double>(), 90.0);
  }
  EXPECT_TRUE(is_measured);
  EXPECT_NEAR(track.at("sweep").at("gain_share").at("value").get<double>(), 1.0, 0.05);
}

TEST_F(Commission, FitsNoModelToARecordInClosedLoop) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::string run = state().at("steps").at("track").at("run").get<std::string>();
  const Ended fit = run_eha({"fit", run, "--model", "integrator_lag", "-o", "closed"}, folder_->path());
  EXPECT_EQ(fit.code, 10);
  EXPECT_THAT(fit.err, HasSubstr("closed loop"));
}

TEST_F(Commission, GoesOnWithTheStepThatIsMissing) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::size_t runs = manifests_of(file("runs")).size();
  json without_trial = state();
  without_trial.at("steps").erase("track");
  folder_->write("commission/commission.json", without_trial.dump());
  const Ended again = run_eha({"commission", "rig.toml", "--yes", "--fast"}, folder_->path());
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(manifests_of(file("runs")).size(), runs + 1);
  EXPECT_TRUE(state().at("steps").contains("track"));
}

TEST(CommissionStopped, FitsARecordThatIsWholeInsteadOfPlayingItAgain) {
  const TemporaryFolder folder;
  folder.write("rig.toml", unknown_rig());
  const auto is_recorded = [&] {
    std::error_code not_yet;
    for (const auto& run : std::filesystem::directory_iterator(folder.path() / "runs", not_yet)) {
      const std::filesystem::path manifest = run.path() / "run.json";
      if (exists(manifest) && json_of(manifest).at("outcome") == "precise_enough") return true;
    }
    return false;
  };
  const Ended first = interrupt_eha({"commission", "rig.toml", "--yes", "--fast", "--precision", "4"}, folder.path(),
                                    is_recorded, SIGINT);
  // Before the fit the command ends by itself; in the fit the signal ends it.
  EXPECT_EQ(first.code, 130) << first.err;
  static_assert(static_cast<int>(ExitCode::interrupted) == 128 + SIGINT);
  EXPECT_THAT(first.err, HasSubstr("to go on with this step: eha commission rig.toml --precision 4 --fast --yes"));
  const Ended second = run_eha({"commission", "rig.toml", "--yes", "--fast", "--precision", "4"}, folder.path());
  EXPECT_EQ(second.code, 0) << second.err;
  int records = 0;
  for (const json& run : manifests_of(folder.path() / "runs")) records += run.at("name") == "band" ? 1 : 0;
  EXPECT_EQ(records, 1);
}

TEST_F(Commission, KeepsWhatATrialShowedThatAFaultEnded) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::string rig = content_of(file("rig.toml"));
  folder_->write("changed.toml", with_value(rig, "valve_dead_band_V", 0.3));
  const Ended track =
      run_eha({"track", "commission/axis.toml", "--local", "--fast", "--rig", "changed.toml", "-o", "changed"},
              folder_->path());
  EXPECT_EQ(track.code, 11) << track.err;
  const std::filesystem::path run = std::filesystem::directory_iterator(file("changed"))->path();
  const json kept = json_of(run / "track.json");
  EXPECT_FALSE(kept.at("kept").get<bool>());
  EXPECT_THAT(kept.at("changes").dump(), HasSubstr("dead band"));
  const Ended again = run_eha({"track", run.string()}, folder_->path());
  EXPECT_EQ(again.code, 3) << again.err;
  EXPECT_THAT(again.err, HasSubstr("dead band"));
  EXPECT_EQ(run_eha({"report", run.string(), "-o", "changed.html"}, folder_->path()).code, 0);
  EXPECT_THAT(content_of(file("changed.html")), HasSubstr("the promise is not kept"));
}

TEST_F(Commission, RefusesARigFileThatHasChangedSinceItBegan) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::string rig = content_of(file("rig.toml"));
  folder_->write("rig.toml", with_value(rig, "travel_max_in", 5.5));
  const Ended again = run_eha({"commission", "rig.toml", "--yes", "--fast"}, folder_->path());
  folder_->write("rig.toml", rig);
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("has changed since"));
  EXPECT_THAT(again.err, HasSubstr("eha commission rig.toml -o commission-2 --fast --yes"));
}

TEST_F(Commission, WritesNothingOverAnotherRigsFile) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  json after_sheet = state();
  for (const char* step : {"rig file", "record", "tune", "track"}) after_sheet.at("steps").erase(step);
  const TemporaryFolder elsewhere;
  const std::string other = with_value(unknown_rig(), "travel_max_in", 5.5);
  elsewhere.write("other.toml", other);
  std::filesystem::create_directories(elsewhere.path() / "commission");
  elsewhere.write("commission/commission.json", after_sheet.dump());
  elsewhere.write("commission/rig.toml", content_of(file("commission/rig.toml")));
  const Ended refused = run_eha({"commission", "other.toml", "--yes", "--fast"}, elsewhere.path());
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("is of another rig file"));
  EXPECT_EQ(content_of(elsewhere.path() / "other.toml"), other);
}

/// The folder may be somebody else's, or its file be edited.
TEST_F(Commission, TakesNothingButTheValvesNumbersFromTheMeasuredFile) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::string rig = content_of(file("rig.toml"));
  const TemporaryFolder elsewhere;
  elsewhere.write("rig.toml", rig);
  json after_sheet = state();
  for (const char* step : {"rig file", "record", "tune", "track"}) after_sheet.at("steps").erase(step);
  after_sheet.at("rig") = (elsewhere.path() / "rig.toml").string();
  std::filesystem::create_directories(elsewhere.path() / "commission");
  elsewhere.write("commission/commission.json", after_sheet.dump());
  for (const auto& [key, value] : {std::pair("travel_max_in", 5.9), std::pair("velocity_limit_in_per_s", 50.0)}) {
    elsewhere.write("commission/rig.toml", with_value(rig, key, value));
    const Ended refused = run_eha({"commission", "rig.toml", "--yes", "--fast"}, elsewhere.path());
    EXPECT_EQ(refused.code, 10) << key;
    EXPECT_THAT(refused.err, HasSubstr("differs from rig.toml in more than the valve's numbers"));
    EXPECT_EQ(content_of(elsewhere.path() / "rig.toml"), rig) << key;
  }
}

/// Makes a file or folder another one than its owner alone may change. @returns false: not possible here
using Spoil = std::function<bool(const std::filesystem::path& what)>;

const std::vector<std::pair<const char*, Spoil>>& ways_to_spoil() {
  static const std::vector<std::pair<const char*, Spoil>> ways{
      {"another user's",
       [](const std::filesystem::path& what) {
         return geteuid() == 0 && chown(what.c_str(), kOtherUser, static_cast<gid_t>(-1)) == 0;
       }},
      {"the group's",
       [](const std::filesystem::path& what) {
         permissions(what, std::filesystem::perms::group_write, std::filesystem::perm_options::add);
         return true;
       }},
      {"everybody's",
       [](const std::filesystem::path& what) {
         permissions(what, std::filesystem::perms::others_write, std::filesystem::perm_options::add);
         return true;
       }},
      {"a link", [](const std::filesystem::path& what) {
         const std::filesystem::path to = what.string() + ".elsewhere";
         rename(what, to);
         create_symlink(to, what);
         return true;
       }}};
  return ways;
}

TEST_F(Commission, TakesNothingFromAFolderThatOthersMayChange) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::string measured = content_of(file("commission/rig.toml"));
  for (const char* what : {"commission", "commission/commission.json", "commission/rig.toml"}) {
    for (const auto& [way, spoil] : ways_to_spoil()) {
      const TemporaryFolder elsewhere;
      elsewhere.write("rig.toml", unknown_rig());
      json after_sheet = state();
      for (const char* step : {"rig file", "record", "tune", "track"}) after_sheet.at("steps").erase(step);
      after_sheet.at("rig") = (elsewhere.path() / "rig.toml").string();
      after_sheet.at("rig_sha256") =
          output_of_shell("sha256sum < " + (elsewhere.path() / "rig.toml").string()).substr(0, 64);
      std::filesystem::create_directories(elsewhere.path() / "commission");
      elsewhere.write("commission/commission.json", after_sheet.dump());
      elsewhere.write("commission/rig.toml", measured);
      if (!spoil(elsewhere.path() / what)) {
        std::cout << "left out: needs root, to give a file to another user\n";
        continue;
      }
      const Ended refused = run_eha({"commission", "rig.toml", "--yes", "--fast"}, elsewhere.path());
      EXPECT_EQ(refused.code, 77) << what << ", " << way << ": " << refused.err;
      EXPECT_THAT(refused.err, HasSubstr(what)) << way;
      EXPECT_THAT(refused.err, HasSubstr("eha commission rig.toml -o commission-2 --fast --yes"))
          << what << ", " << way;
      EXPECT_TRUE(content_of(elsewhere.path() / "rig.toml") == unknown_rig()) << what << ", " << way;
    }
  }
}

TEST_F(Commission, TriesNoControllerThatOthersMayChange) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const std::size_t runs = manifests_of(file("runs")).size();
  const json whole = state();
  json without_trial = whole;
  without_trial.at("steps").erase("track");
  folder_->write("commission/commission.json", without_trial.dump());
  permissions(file("commission/axis.toml"), std::filesystem::perms::others_write, std::filesystem::perm_options::add);
  const Ended refused = run_eha({"commission", "rig.toml", "--yes", "--fast"}, folder_->path());
  permissions(file("commission/axis.toml"), std::filesystem::perms::others_write,
              std::filesystem::perm_options::remove);
  folder_->write("commission/commission.json", whole.dump());
  EXPECT_EQ(refused.code, 77) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("chmod go-w commission/axis.toml"));
  EXPECT_EQ(manifests_of(file("runs")).size(), runs);
}

TEST(CommissionQuestions, AreNotAskedWhereTheNumbersCouldNotBeWritten) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to act as another user";
  const TemporaryFolder owners;
  owners.write("rig.toml", unknown_rig());
  const TemporaryFolder users;
  std::filesystem::permissions(owners.path(), std::filesystem::perms(0755));
  std::filesystem::permissions(users.path(), std::filesystem::perms(0777));
  const std::string said = output_of_shell(fmt::format(
      "cd {} && setpriv --reuid={} --regid={} --clear-groups {} commission {} --yes --fast 2>&1; echo \"ended: $?\"",
      users.path().string(), kOtherUser, kOtherUser, EHA_PROGRAM, (owners.path() / "rig.toml").string()));
  EXPECT_THAT(said, HasSubstr("ended: 77"));
  EXPECT_THAT(said,
              HasSubstr("may not write into " + owners.path().string() + "; nothing was moved: commission a copy"));
  EXPECT_FALSE(std::filesystem::exists(users.path() / "runs"));
}

TEST(CommissionQuestions, AskOnATerminalOnly) {
  const TemporaryFolder folder;
  folder.write("rig.toml", unknown_rig());
  const Ended ended = run_eha({"commission", "rig.toml", "--fast"}, folder.path());
  EXPECT_EQ(ended.code, 2) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("--yes"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "runs"));
}

TEST(CommissionQuestions, AMachineIsCommissionedAttended) {
  const TemporaryFolder folder;
  folder.write("rig.toml", content_of(source_file("config/rigs/pci1716.toml")));
  const Ended ended = run_eha({"commission", "rig.toml", "--yes"}, folder.path());
  EXPECT_NE(ended.code, 0);
  EXPECT_THAT(ended.err, HasSubstr("attended"));
}

}  // namespace
}  // namespace eha::test
