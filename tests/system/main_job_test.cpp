// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One run of the paper's experiment on the simulated rig, shared by the tests that only look at it.
class MainJob : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    ended_ = new Ended(run_paper(*folder_, "runs"));
  }
  static void TearDownTestSuite() {
    delete ended_;
    delete folder_;
  }

  static Ended run_paper(const TemporaryFolder& folder, const std::string& output) {
    return run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig",
                    source_file("config/rigs/sim.toml"), "--output", output, "--json"},
                   folder.path());
  }

  [[nodiscard]] static fs::path run_folder() {
    return folder_->path() / json::parse(ended_->out).at("run").get<std::string>();
  }

  /// The recommended model among those of an `eha run --json`.
  [[nodiscard]] static json recommended(const json& document) {
    for (const json& model : document.at("models")) {
      if (model.at("name") == document.at("recommendation").at("model")) return model;
    }
    throw std::runtime_error("no recommended model");
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* ended_ = nullptr;
};

TEST_F(MainJob, EndsWithAnAcceptedModelThatValidatesAbove99Percent) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  const json document = json::parse(ended_->out);
  EXPECT_EQ(document.at("outcome"), "completed");
  double best = 0.0;
  for (const json& model : document.at("models")) {
    if (!model.at("verdict").at("accepted").get<bool>()) continue;
    best = std::max(best, model.at("validation").at("r2_percent").get<double>());
  }
  EXPECT_GE(best, 99.0);
  EXPECT_EQ(document.at("paper_procedure").size(), 2U);
}

TEST_F(MainJob, RecommendsAModelBehindTheSimulatedValve) {
  const json document = json::parse(ended_->out);
  const json& recommendation = document.at("recommendation");
  const json model = recommended(document);
  ASSERT_TRUE(model.contains("input_map")) << recommendation;
  // The plant of sim.toml: valve_null_offset_V = 0.2, which is the null's distance below 0, valve_dead_band_V = 0.15.
  EXPECT_NEAR(model.at("input_map").at("null").get<double>(), -0.2, 0.02);
  EXPECT_NEAR(model.at("input_map").at("dead_band").get<double>(), 0.15, 0.02);
  EXPECT_GE(model.at("validation").at("fit_percent").get<double>(), 99.5);
  EXPECT_TRUE(model.at("verdict").at("accepted").get<bool>());
  EXPECT_FALSE(recommendation.at("needs_fresh_record").get<bool>());
  EXPECT_FALSE(recommendation.at("runner_up").is_null());
  // The manifest says the same, and that one round was enough.
  const json entry = json::parse(content_of(run_folder() / "run.json")).at("identification");
  EXPECT_EQ(entry.at("recommendation"), recommendation);
  EXPECT_EQ(entry.at("rounds").size(), 1U);
  // The customer's two structures are always there, judged.
  for (const char* name : {"io", "fo"}) {
    const bool is_there = std::any_of(document.at("models").begin(), document.at("models").end(),
                                      [&](const json& m) { return m.at("name") == name; });
    EXPECT_TRUE(is_there) << name;
  }
}

TEST_F(MainJob, LeavesEveryFileOfTheRunFolder) {
  for (const char* file : {"run.json", "raw.ehalog", "raw.h5", "data_40ms.csv"}) {
    EXPECT_TRUE(fs::is_regular_file(run_folder() / file)) << file;
  }
  const json manifest = json::parse(content_of(run_folder() / "run.json"));
  EXPECT_EQ(manifest.at("outcome"), "completed");
  for (const json& model : manifest.at("identification").at("models")) {
    EXPECT_TRUE(fs::is_regular_file(run_folder() / model.at("file").get<std::string>())) << model;
  }
  EXPECT_EQ(fs::canonical(folder_->path() / "runs" / "latest"), fs::canonical(run_folder()));
}

TEST_F(MainJob, SaysThatARefitMovesTheLatestLink) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "runs");
  fs::copy(run_folder(), folder.path() / "runs" / "a", fs::copy_options::recursive);
  fs::create_symlink("b", folder.path() / "runs" / "latest");
  const Ended moved = run_eha({"fit", "runs/a"}, folder.path());
  EXPECT_EQ(moved.code, 0) << moved.err;
  EXPECT_NE(moved.err.find("runs/latest leads to this run now, and led to b before"), std::string::npos) << moved.err;
  EXPECT_EQ(fs::read_symlink(folder.path() / "runs" / "latest"), "a");
}

TEST_F(MainJob, GivesTheSameBytesAndModelsAgain) {
  const TemporaryFolder folder;
  const Ended again = run_paper(folder, "again");
  ASSERT_EQ(again.code, 0) << again.err;
  const fs::path second = folder.path() / json::parse(again.out).at("run").get<std::string>();
  for (const char* file : {"raw.ehalog", "raw.h5", "data_40ms.csv"}) {
    EXPECT_EQ(content_of(run_folder() / file), content_of(second / file)) << file;
  }
  const json one = json::parse(ended_->out);
  const json two = json::parse(again.out);
  for (const char* list : {"models", "paper_procedure"}) {
    ASSERT_EQ(one.at(list).size(), two.at(list).size());
    for (std::size_t i = 0; i < one.at(list).size(); ++i) {
      EXPECT_EQ(one.at(list)[i].at("transfer_function"), two.at(list)[i].at("transfer_function"));
      EXPECT_EQ(one.at(list)[i].at("parameters"), two.at(list)[i].at("parameters"));
    }
  }
}

TEST_F(MainJob, IsFittedAgainToTheSameModels) {
  const Ended again = run_eha({"fit", run_folder().string(), "--json"}, folder_->path());
  ASSERT_EQ(again.code, 0) << again.err;
  const json first = json::parse(ended_->out);
  const json second = json::parse(again.out);
  for (std::size_t i = 0; i < first.at("models").size(); ++i) {
    EXPECT_EQ(first.at("models")[i].at("transfer_function"), second.at("models")[i].at("transfer_function"));
  }
}

TEST_F(MainJob, ModelsSimulateAndValidateTheirOwnRun) {
  const json document = json::parse(ended_->out);
  const std::string model = run_folder() / "models" / (recommended(document).at("name").get<std::string>() + ".json");
  const Ended validated = run_eha({"validate", model, run_folder().string(), "--json"}, folder_->path());
  EXPECT_EQ(validated.code, 0) << validated.err;
  const json report = json::parse(validated.out);
  EXPECT_GE(report.at("model").at("validation").at("r2_percent").get<double>(), 95.0);

  const Ended simulated =
      run_eha({"simulate", model, (run_folder() / "data_40ms.csv").string(), "-o", "y.csv"}, folder_->path());
  EXPECT_EQ(simulated.code, 0) << simulated.err;
}

TEST_F(MainJob, BehindAValveMapFindsTheSimulatedValve) {
  const Ended fitted = run_eha(
      {"fit", run_folder().string(), "--model", "integrator_lag", "--input-map", "valve", "-o", "behind", "--json"},
      folder_->path());
  ASSERT_EQ(fitted.code, 0) << fitted.err;
  const json model = json::parse(content_of(folder_->path() / "behind" / "integrator_lag_valve.json"));
  // The plant of sim.toml: valve_null_offset_V = 0.2, which is the null's distance below 0, valve_dead_band_V = 0.15.
  EXPECT_NEAR(model.at("input_map").at("null").get<double>(), -0.2, 0.02);
  EXPECT_NEAR(model.at("input_map").at("dead_band").get<double>(), 0.15, 0.02);
  EXPECT_GE(model.at("validation").at("fit_percent").get<double>(), 99.5);

  const Ended validated =
      run_eha({"validate", "behind/integrator_lag_valve.json", run_folder().string(), "--json"}, folder_->path());
  EXPECT_EQ(validated.code, 0) << validated.err;
  EXPECT_GE(json::parse(validated.out).at("model").at("validation").at("fit_percent").get<double>(), 99.0);
}

TEST(FitOfARun, NamesTheNextExperimentWithTheOptionsOfTheRun) {
  const TemporaryFolder folder;
  folder.write("rig.toml", content_of(source_file("config/rigs/sim.toml")));
  folder.write("weak.toml",
               "schema = 1\nname = \"weak\"\nduration_s = 20.0\n[excitation]\nkind = \"multisine\"\noffset_V = -0.2\n"
               "tones = [{ frequency_Hz = 0.2, amplitude_V = 0.05, phase_rad = 1.9 }]\n"
               "[record]\ndiscard_s = 5.0\ndecimation = 40\n");
  const Ended ran =
      run_eha({"run", "weak.toml", "--local", "--fast", "--rig", "rig.toml", "--output", "weak"}, folder.path());
  const std::string options = "next_experiment.toml --local --fast --rig rig.toml --output weak\n";
  ASSERT_NE(ran.out.find(options), std::string::npos) << ran.out << ran.err;
  std::string run;
  for (const auto& entry : fs::directory_iterator(folder.path() / "weak")) {
    if (!entry.is_symlink()) run = "weak/" + entry.path().filename().string();
  }
  const Ended fitted = run_eha({"fit", run}, folder.path());
  EXPECT_NE(fitted.out.find(options), std::string::npos) << fitted.out << fitted.err;
}

TEST_F(MainJob, IsListedAndShown) {
  const Ended list = run_eha({"runs", "list", "runs"}, folder_->path());
  EXPECT_EQ(list.code, 0) << list.err;
  EXPECT_NE(list.out.find(run_folder().filename().string()), std::string::npos);
  EXPECT_NE(list.out.find("recommended: "), std::string::npos) << list.out;
  const Ended show = run_eha({"runs", "show", "runs/latest", "--json"}, folder_->path());
  EXPECT_EQ(show.code, 0) << show.err;
  EXPECT_EQ(json::parse(show.out).at("outcome"), "completed");
  const Ended text = run_eha({"runs", "show", "runs/latest"}, folder_->path());
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("0 late, 0 skipped, 0 samples not delivered, 0 dropped"), std::string::npos) << text.out;
}

/// Bytes of the journal after its header, which is as long as the machine's names and paths make it.
std::size_t recorded_bytes(const fs::path& journal) {
  const std::string bytes = fs::exists(journal) ? content_of(journal) : std::string();
  constexpr std::size_t kPreamble = 16;
  constexpr std::size_t kLengthAt = 8;
  if (bytes.size() < kPreamble) return 0;
  std::uint32_t header = 0;
  std::memcpy(&header, bytes.data() + kLengthAt, sizeof(header));
  return bytes.size() - std::min(bytes.size(), kPreamble + header);
}

constexpr int kRowsRecorded = 400;  ///< in whole blocks as soon as is_recording()

/// Whether the excitation plays: half a second is recorded, of which the last block of 100 rows may be torn by a kill.
bool is_recording(const fs::path& runs) {
  constexpr std::size_t kRowSize = 64;
  std::error_code none_yet;
  const fs::directory_iterator folders(runs, none_yet);
  return std::any_of(begin(folders), end(folders), [](const fs::directory_entry& run) {
    return recorded_bytes(run.path() / "raw.ehalog") > (kRowsRecorded + 100) * kRowSize;
  });
}

/// By what ends a process, and by what suspends one: stopped, it would leave the last voltage on a card's output.
class InterruptedRun : public testing::TestWithParam<int> {};

TEST_P(InterruptedRun, RampsOutKeepsWhatItHasAndIsNotFitted) {
  const TemporaryFolder folder;
  // In real time: the signal comes long before the 50 s are over.
  const Ended ended = interrupt_eha(
      {"run", source_file("config/experiments/paper.toml"), "--local", "--rig", source_file("config/rigs/sim.toml"),
       "--json"},
      folder.path(), [&] { return is_recording(folder.path() / "runs"); }, GetParam());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::interrupted)) << ended.err;
  EXPECT_EQ(lines_beginning_with(ended.err, "eha: error: "), 1U) << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("outcome"), "interrupted");
  const fs::path run = folder.path() / document.at("run").get<std::string>();
  EXPECT_EQ(json::parse(content_of(run / "run.json")).at("outcome"), "interrupted");
  EXPECT_TRUE(fs::is_regular_file(run / "raw.h5"));
  EXPECT_FALSE(fs::exists(run / "models" / "io.json"));
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder.path() / "runs" / "latest")));
}

INSTANTIATE_TEST_SUITE_P(Signals, InterruptedRun, testing::Values(SIGINT, SIGQUIT, SIGTSTP));

TEST(KilledRun, IsRecoveredByTheNextOneWhateverElseCannotBe) {
  const TemporaryFolder folder;
  const fs::path runs = folder.path() / "runs";
  const Ended killed = interrupt_eha(
      {"run", source_file("config/experiments/paper.toml"), "--local", "--rig", source_file("config/rigs/sim.toml")},
      folder.path(), [&] { return is_recording(runs); }, SIGKILL);
  ASSERT_EQ(killed.code, 128 + SIGKILL);
  const fs::path run = fs::directory_iterator(runs)->path();
  ASSERT_EQ(json::parse(content_of(run / "run.json")).at("outcome"), "in_progress");
  const Ended list = run_eha({"runs", "list", "runs"}, folder.path());
  EXPECT_NE(list.out.find("Next: eha runs recover runs\n"), std::string::npos) << list.out;
  fs::create_directory(runs / "20200101T000000Z-spoilt");
  folder.write("runs/20200101T000000Z-spoilt/raw.ehalog", "no journal");

  const Ended next = run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig",
                              source_file("config/rigs/sim.toml")},
                             folder.path());
  EXPECT_EQ(next.code, 0) << next.err;
  EXPECT_NE(next.err.find("20200101T000000Z-spoilt"), std::string::npos) << next.err;
  EXPECT_NE(next.err.find(run.filename().string() + ": recovered: "), std::string::npos) << next.err;
  const json manifest = json::parse(content_of(run / "run.json"));
  EXPECT_EQ(manifest.at("outcome"), "recovered");
  EXPECT_GE(manifest.at("recovery").at("rows").get<int>(), kRowsRecorded);
  EXPECT_TRUE(fs::is_regular_file(run / "raw.h5"));

  const Ended recover = run_eha({"runs", "recover", "runs"}, folder.path());
  EXPECT_EQ(recover.code, static_cast<int>(ExitCode::bad_data)) << recover.err;
}

TEST(LimitedRun, EndsWithItsReasonWhenTheJournalReachesTheLimitOfAFilesSize) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml");
  const std::string experiment = source_file("config/experiments/paper.toml");
  // In units of 512 bytes: half of the journal, and more than the memory that is shared with the guard.
  const std::string out = output_of_shell("cd " + folder.path().string() +
                                          " && ulimit -f 3000 && " EHA_PROGRAM " run --local --fast --rig " + rig +
                                          " " + experiment + " 2>&1; echo $?");
  EXPECT_NE(out.find("raw.ehalog: File too large"), std::string::npos) << out;
  EXPECT_TRUE(out.ends_with("\n74\n")) << out;
  const fs::path run = fs::directory_iterator(folder.path() / "runs")->path();
  EXPECT_EQ(run_eha({"runs", "recover", run}, folder.path()).code, 0);
}

}  // namespace
}  // namespace eha::test
