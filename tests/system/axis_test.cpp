// SPDX-License-Identifier: GPL-3.0-or-later
// From a rig to an axis that keeps its promise, command by command as each names the next.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kExperiment = R"(schema = 1
name = "ways"
duration_s = 24.0
repetitions = 2
[excitation]
kind = "multisine"
offset_V = -0.2
tones = [
  { frequency_Hz = 0.13, amplitude_V = 1.2, phase_rad = 4.7 },
  { frequency_Hz = 0.71, amplitude_V = 0.8, phase_rad = 1.9 },
  { frequency_Hz = 3.3, amplitude_V = 0.6, phase_rad = 0.4 },
]
[record]
decimation = 10
[[model]]
name = "lagging"
structure = "integrator_lag"
input_map = "valve"
)";

/// What a command that the program names is: the words of the line that begins with "Next: eha VERB".
std::string next_of(const Ended& ended, const std::string& verb) {
  const std::string beginning = "Next: eha " + verb;
  const std::size_t at = ended.out.find(beginning);
  if (at == std::string::npos) return {};
  return ended.out.substr(at + 10, ended.out.find('\n', at) - at - 10);
}

std::vector<std::string> words(const std::string& line) {
  std::istringstream text(line);
  return {std::istream_iterator<std::string>(text), {}};
}

/// One way for all cases: characterise, run, tune, track.
class Axis : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    folder_->write("rig.toml", content_of(source_file("config/rigs/sim.toml")));
    folder_->write("ways.toml", kExperiment);
    const std::vector<std::string> local{"--local", "--fast", "--rig", "rig.toml", "-o", "runs"};
    const auto with_rig = [&](std::vector<std::string> command) {
      command.insert(command.end(), local.begin(), local.end());
      return run_eha(command, folder_->path());
    };
    const Ended sheet = with_rig({"characterise"});
    ASSERT_EQ(sheet.code, 0) << sheet.err;
    const Ended run = with_rig({"run", "ways.toml"});
    ASSERT_EQ(run.code, 0) << run.out << run.err;
    tune_line_ = next_of(run, "tune");
    ASSERT_FALSE(tune_line_.empty()) << run.out;
    std::vector<std::string> tune = words(tune_line_);
    tune.insert(tune.end(), {"-o", "axis.toml"});
    tuned_ = new Ended(run_eha(tune, folder_->path()));
    tracked_ = new Ended(with_rig({"track", "axis.toml"}));
  }
  static void TearDownTestSuite() {
    delete tracked_;
    delete tuned_;
    delete folder_;
  }
  static fs::path track_run() {
    for (const auto& entry : fs::directory_iterator(folder_->path() / "runs")) {
      if (fs::exists(entry.path() / "track.json")) return entry.path();
    }
    return {};
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* tuned_ = nullptr;
  static inline Ended* tracked_ = nullptr;
  static inline std::string tune_line_;
};

TEST_F(Axis, IsTunedFromTheRunWithTheValveSheetBesideIt) {
  EXPECT_NE(tune_line_.find("--sheet"), std::string::npos) << tune_line_;
  EXPECT_NE(tune_line_.find("-characterise"), std::string::npos) << tune_line_;
  ASSERT_EQ(tuned_->code, 0) << tuned_->err;
  EXPECT_EQ(next_of(*tuned_, "track"), "track axis.toml --local --fast --rig rig.toml");
  EXPECT_TRUE(fs::exists(folder_->path() / "axis.html"));
  EXPECT_NE(tuned_->out.find("the sheet applies, for [following] too"), std::string::npos) << tuned_->out;
  for (const char* step : {"eha plot axis.toml", "eha export axis.toml --format csv", "--format st"}) {
    EXPECT_NE(tuned_->out.find(step), std::string::npos) << step;
  }
}

TEST_F(Axis, TakesLengthsWithTheirUnitOnly) {
  const auto track = [](std::vector<std::string> options) {
    options.insert(options.begin(), {"track", "axis.toml", "--local", "--fast", "--rig", "rig.toml"});
    return run_eha(options, folder_->path());
  };
  const Ended bare = track({"--step", "10"});
  EXPECT_EQ(bare.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(bare.err.find("a length needs its unit; write 10mm or 10in"), std::string::npos) << bare.err;
  const Ended far = track({"--step", "100mm"});
  EXPECT_EQ(far.code, static_cast<int>(ExitCode::usage)) << far.err;
  EXPECT_NE(far.err.find("--step 100mm"), std::string::npos) << far.err;
  EXPECT_NE(far.err.find("travel, 71"), std::string::npos) << "in the unit that was typed: " << far.err;
  const Ended near = track({"--step", "10mm", "--sine", "0.05in", "--hold", "2", "--no-sweep", "-o", "near"});
  EXPECT_TRUE(near.code == 0 || near.code == static_cast<int>(ExitCode::model_rejected)) << near.err;
}

TEST_F(Axis, OffersNoFileThatIsThere) {
  for (const auto& entry : fs::directory_iterator(folder_->path() / "runs")) {
    if (entry.path().filename().string().find("-ways") == std::string::npos) continue;
    folder_->write("controller.toml", "");
    const Ended again = run_eha({"fit", entry.path()}, folder_->path());
    EXPECT_NE(again.out.find("Next: eha tune"), std::string::npos) << again.out;
    EXPECT_NE(again.out.find(" -o controller-2.toml"), std::string::npos) << again.out;
    fs::remove(folder_->path() / "controller.toml");
  }
}

TEST_F(Axis, KeepsItsPromiseOnTheSimulatedRig) {
  ASSERT_EQ(tracked_->code, 0) << tracked_->out << tracked_->err;
  const Json result = Json::parse(content_of(track_run() / "track.json"));
  EXPECT_TRUE(result.at("kept").get<bool>());
  EXPECT_TRUE(result.at("changes").empty()) << result.at("changes");
  const Ended latest = run_eha({"plot", "runs/latest", "-o", "latest.svg"}, folder_->path());
  EXPECT_NE(latest.err.find("the last run with an accepted model; the newest run is "), std::string::npos)
      << latest.err;
  const Ended plot = run_eha({"plot", track_run()}, folder_->path());
  EXPECT_NE(plot.out.find("sweep for the margins"), std::string::npos) << plot.out << plot.err;
}

TEST_F(Axis, IsOneTableOfModelValvePromiseAndMeasured) {
  const std::string table = content_of(track_run() / "axis_table.csv");
  EXPECT_EQ(lines_beginning_with(table, "part,figure,value,from,to,measured,noise adds to,unit,kept"), 1U);
  for (const char* row :
       {"axis,rig,simulated rig,", "model,name,lagging,", "model,verdict,", "\"valve, measured\",half dead band,0.15",
        "\"valve, as used\",half dead band,0.15", "controller,kp,", "promise,Ms,"}) {
    EXPECT_EQ(lines_beginning_with(table, row), 1U) << row << table;
  }
  const Json result = Json::parse(content_of(track_run() / "track.json"));
  const Json& following = result.at("figures").at(0);
  const std::size_t at = table.find("promise,\"" + following.at("figure").get<std::string>() + "\",");
  ASSERT_NE(at, std::string::npos);
  const std::string row = table.substr(at, table.find('\n', at) - at);
  EXPECT_TRUE(row.ends_with(",in,yes")) << row;
}

TEST_F(Axis, IsATableInMillimetresOnRequest) {
  const Ended written = run_eha({"export", "axis.toml", "--format", "csv", "-o", "written.csv"}, folder_->path());
  const std::string track = next_of(written, "track");
  EXPECT_TRUE(track.starts_with("track axis.toml --local --fast --rig ") && track.ends_with("rig.toml")) << track;
  const Ended inches = run_eha({"export", "axis.toml", "--format", "csv"}, folder_->path());
  const Ended millimetres = run_eha({"export", "axis.toml", "--format", "csv", "--units", "mm"}, folder_->path());
  ASSERT_EQ(millimetres.code, 0) << millimetres.err;
  EXPECT_NE(inches.out.find(",in,"), std::string::npos);
  EXPECT_EQ(millimetres.out.find(",in,"), std::string::npos) << millimetres.out;
  EXPECT_EQ(millimetres.out.find(" in/"), std::string::npos) << millimetres.out;
  EXPECT_NE(millimetres.out.find(",mm,"), std::string::npos);
}

TEST_F(Axis, IsForAnotherTickOnTheSimulatedRig) {
  std::vector<std::string> tune = words(tune_line_);
  tune.insert(tune.end(), {"--tick", "0.004", "-o", "slow.toml"});
  ASSERT_EQ(run_eha(tune, folder_->path()).code, 0);
  const Ended tracked =
      run_eha({"track", "slow.toml", "--local", "--fast", "--rig", "rig.toml", "-o", "slow_runs", "--hold", "5"},
              folder_->path());
  EXPECT_EQ(tracked.code, 0) << tracked.out << tracked.err;
  EXPECT_NE(tracked.out.find("nothing breaks the promise"), std::string::npos) << tracked.out;
}

TEST_F(Axis, NamesAFollowingSectionThatIsNotOfTheMeasuredValve) {
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  rig.replace(rig.find("null_V = -0.2 "), 14, "null_V = -0.12 ");
  rig.replace(rig.find("dead_band_V = 0.2 "), 18, "dead_band_V = 0.27 ");
  folder_->write("old.toml", rig);
  folder_->write("short.csv", "time_s,position_mm\n0,75\n2,76\n");
  std::vector<std::string> tune = words(tune_line_);
  tune.insert(tune.end(), {"--kind", "p", "-o", "old_axis.toml"});
  *std::find(tune.begin(), tune.end(), "rig.toml") = "old.toml";
  const std::vector<std::vector<std::string>> commands{
      tune,
      {"track", "axis.toml", "short.csv", "--local", "--fast", "--rig", "old.toml", "-o", "runs"},
      {"goto", "60mm", "--local", "--fast", "--rig", "old.toml", "-o", "runs"}};
  for (const std::vector<std::string>& command : commands) {
    const Ended ended = run_eha(command, folder_->path());
    EXPECT_NE(ended.err.find("null_V = -0.120 and dead_band_V = 0.270"), std::string::npos)
        << command.front() << ended.err;
    EXPECT_NE(ended.err.find("they are -0.20"), std::string::npos) << command.front() << ended.err;
    EXPECT_NE(ended.err.find("`eha characterise "), std::string::npos) << command.front() << ended.err;
    EXPECT_EQ(ended.err.find("[following]", ended.err.find("[following]") + 1), std::string::npos) << ended.err;
  }
  EXPECT_EQ(tuned_->err.find("[following]"), std::string::npos) << tuned_->err;
  EXPECT_EQ(tracked_->err.find("[following]"), std::string::npos) << tracked_->err;
}

TEST_F(Axis, FollowsSetPointsOfACsvFileInMillimetres) {
  folder_->write("cycle.csv", "time_s,position_mm\n0,60\n2,60\n6,70\n9,70\n");
  const Ended tracked = run_eha(
      {"track", "axis.toml", "cycle.csv", "--local", "--fast", "--rig", "rig.toml", "-o", "cycles"}, folder_->path());
  ASSERT_EQ(tracked.code, 0) << tracked.out << tracked.err;
  const fs::path run = fs::directory_iterator(folder_->path() / "cycles")->path();
  const Json result = Json::parse(content_of(run / "track.json"));
  EXPECT_EQ(result.at("figures").size(), 2U);
  EXPECT_LT(result.at("reference_behind_in").get<double>(), 0.1);
  std::istringstream rows(content_of(run / "track.csv"));
  std::string last;
  for (std::string row; std::getline(rows, row);) last = row;
  const std::size_t comma = last.find(',', last.find(',') + 1);
  EXPECT_NEAR(std::stod(last.substr(comma + 1)), 70.0 / 25.4, 0.01) << last;
}

TEST_F(Axis, RefusesSetPointsBeyondTheTravelOrWithoutAUnit) {
  folder_->write("far.csv", "time_s,position_mm\n0,60\n2,160\n");
  folder_->write("bare.csv", "time_s,position\n0,60\n2,70\n");
  const std::vector<std::string> local{"--local", "--fast", "--rig", "rig.toml", "-o", "refused"};
  for (const auto& [file, what] :
       {std::pair{"far.csv", "far.csv: row 2: 160 mm at 2 s lies outside"}, {"bare.csv", "position_mm"}}) {
    std::vector<std::string> command{"track", "axis.toml", file};
    command.insert(command.end(), local.begin(), local.end());
    const Ended refused = run_eha(command, folder_->path());
    EXPECT_NE(refused.code, 0);
    EXPECT_NE(refused.err.find(what), std::string::npos) << refused.err;
  }
}

TEST_F(Axis, EndsWithoutATuneLineWhereNoModelIsRecommended) {
  std::string strict = kExperiment;
  strict.replace(strict.find("structure = \"integrator_lag\"\ninput_map = \"valve\""), std::string::npos,
                 "structure = \"io\"\npoles = 4\n[acceptance]\nmin_validation_r2_percent = 99.9999999\n");
  folder_->write("strict.toml", strict);
  const Ended run =
      run_eha({"run", "strict.toml", "--local", "--fast", "--rig", "rig.toml", "-o", "strict_runs"}, folder_->path());
  EXPECT_EQ(run.code, 3) << run.out << run.err;
  EXPECT_EQ(run.err.find("internal error"), std::string::npos) << run.err;
  EXPECT_EQ(next_of(run, "tune"), "") << run.out;
}

TEST_F(Axis, OverwritesNoController) {
  std::vector<std::string> tune = words(tune_line_);
  tune.insert(tune.end(), {"-o", "axis.toml"});
  const Ended refused = run_eha(tune, folder_->path());
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("no controller is overwritten"), std::string::npos) << refused.err;
}

TEST_F(Axis, ExportsTheRecommendedModelOfARun) {
  for (const auto& entry : fs::directory_iterator(folder_->path() / "runs")) {
    if (!fs::exists(entry.path() / "models" / "lagging.json")) continue;
    const Ended exported = run_eha({"export", entry.path().string(), "--format", "tf"}, folder_->path());
    EXPECT_EQ(exported.code, 0) << exported.err;
    EXPECT_NE(exported.out.find("tf("), std::string::npos);
  }
}

TEST_F(Axis, IsRefusedFromARunThatRecommendsNothing) {
  const Ended refused = run_eha({"tune", track_run().string()}, folder_->path());
  EXPECT_NE(refused.code, 0);
  EXPECT_NE(refused.err.find("recommends no model"), std::string::npos) << refused.err;
}

/// A record of a rig that no rig file here is of: the way to its axis leads over a twin.
TEST(AxisOfARecord, IsTriedOnATwinWithTheValveOfTheRecord) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  for (const auto& [old, changed] :
       {std::pair("\nvalve_null_offset_V = 0.2 ", "\nvalve_null_offset_V = -0.1 "),
        std::pair("\nvalve_dead_band_V = 0.15 ", "\nvalve_dead_band_V = 0.3 "),
        std::pair("\nnull_V = -0.2 ", "\nnull_V = 0.1 "), std::pair("\ndead_band_V = 0.2 ", "\ndead_band_V = 0.35 ")}) {
    rig.replace(rig.find(old), std::string(old).size(), changed);
  }
  folder.write("other.toml", rig);
  std::string experiment = kExperiment;
  const std::string offset = "offset_V = -0.2";
  folder.write("ways.toml", experiment.replace(experiment.find(offset), offset.size(), "offset_V = 0.1"));
  const Ended run =
      run_eha({"run", "ways.toml", "--local", "--fast", "--rig", "other.toml", "-o", "far"}, folder.path());
  ASSERT_EQ(run.code, 0) << run.err;
  folder.write("cyl.csv", content_of(folder.path() / "far" / "latest" / "data_10ms.csv"));
  fs::remove_all(folder.path() / "far");
  const auto eha = [&](const std::string& line) { return run_eha(words(line), folder.path()); };
  const Ended fit = eha("fit cyl.csv --model integrator_lag --input-map valve -o models");
  const std::string model = "models/integrator_lag_valve.json";
  ASSERT_TRUE(fs::exists(folder.path() / model)) << fit.out << fit.err;
  const Ended alone = eha("tune " + model + " -o cyl.toml");
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_EQ(next_of(alone, "track"), "") << "which the shipped rig would refuse";
  const std::string replay = next_of(alone, "replay");
  EXPECT_NE(replay.find("--twin twin.toml"), std::string::npos) << alone.out;
  ASSERT_EQ(eha(replay).code, 0);
  const std::string twin = content_of(folder.path() / "twin.toml");
  EXPECT_NE(twin.find("\nnull_V = 0.1"), std::string::npos) << twin;
  const Ended tuned = eha(next_of(alone, "tune"));
  ASSERT_EQ(tuned.code, 0) << tuned.err;
  EXPECT_EQ(tuned.err.find("are for another valve"), std::string::npos) << tuned.err;
  const std::string track = next_of(tuned, "track");
  EXPECT_EQ(track, "track cyl-2.toml --local --fast --rig twin.toml");
  const Ended checked = eha(track + " --hold 2 --no-sweep");
  EXPECT_TRUE(checked.code == 0 || checked.code == static_cast<int>(ExitCode::model_rejected)) << checked.err;
}

/// The shipped record is of the shipped rig, but nothing shows it: its axis is that of a twin, not of the rig here.
TEST(AxisOfARecord, OffersATwinAlsoWhereTheRigHereWouldTakeTheController) {
  const TemporaryFolder folder;
  const auto eha = [&](const std::string& line) { return run_eha(words(line), folder.path()); };
  ASSERT_EQ(
      eha("fit " + source_file("config/records/bench.csv").string() + " --model integrator_lag_valve -o models").code,
      0);
  const Ended tuned = eha("tune models/integrator_lag_valve.json -o x.toml");
  ASSERT_EQ(tuned.code, 0) << tuned.err;
  EXPECT_NE(tuned.out.find("and not for the plant of"), std::string::npos) << tuned.out;
  EXPECT_EQ(next_of(tuned, "track"), "") << tuned.out;
  EXPECT_NE(next_of(tuned, "replay").find("--twin twin.toml"), std::string::npos) << tuned.out;
  EXPECT_EQ(next_of(tuned, "tune").find("tune models/integrator_lag_valve.json --twin twin.toml"), 0U) << tuned.out;
}

}  // namespace
}  // namespace eha::test
