// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/publish.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "daemon/record/run_folder.hpp"
#include "tests/unit/identify/fitted_model.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::identify {
namespace {

namespace fs = std::filesystem;
using eha::test::content_of;
using eha::test::TemporaryFolder;
using test::Came;
using test::model_that;

TEST(WriteModels, MakesTheFolderAndOneFileForEachModel) {
  const TemporaryFolder folder;
  const auto written = write_models({.models = {model_that(Came::accepted, "io"), model_that(Came::rejected, "fo")}},
                                    folder.path() / "a" / "b");
  EXPECT_EQ(written,
            (std::vector<fs::path>{folder.path() / "a" / "b" / "io.json", folder.path() / "a" / "b" / "fo.json"}));
  EXPECT_EQ(nlohmann::json::parse(content_of(written[0])).at("name"), "io");
}

class PublishModels : public testing::Test {
 protected:
  PublishModels() : run_(record::create_run_folder(folder_.path(), "test")) {
    folder_.write(fs::relative(run_ / "run.json", folder_.path()),
                  R"({"schema": "eha-run/1", "outcome": "completed"})");
  }
  [[nodiscard]] bool has(const char* file) const { return fs::exists(run_ / file); }

  TemporaryFolder folder_;
  fs::path run_;
};

TEST_F(PublishModels, PutsAcceptedModelsInPlaceAndMovesLatest) {
  static_cast<void>(
      publish({.models = {model_that(Came::accepted, "io"), model_that(Came::rejected, "fo")}}, record::OpenRun(run_)));
  EXPECT_TRUE(has("models/io.json"));
  EXPECT_FALSE(has("models/fo.json"));
  EXPECT_TRUE(has("models/rejected/fo.json"));
  EXPECT_EQ(fs::canonical(folder_.path() / "latest"), fs::canonical(run_));
  const auto identification = nlohmann::json::parse(content_of(run_ / "run.json")).at("identification");
  EXPECT_EQ(identification.at("accepted"), true);
  EXPECT_EQ(identification.at("models").at(1).at("file"), "models/rejected/fo.json");
}

TEST_F(PublishModels, WritesWhatIsRecommendedWhatWasTriedAndTheNextExperiment) {
  Identification identification{.models = {model_that(Came::rejected)}};
  identification.recommendation.reason = "none is identified";
  identification.rounds = {{"the asked models", "", false}, {"other starts (seed 2)", "none is identified", false}};
  identification.refused = {{"io_valve", "too few samples beyond one side"}};
  identification.next_experiment = {"schema = 1\n", "a longer one"};
  const auto written = publish(identification, record::OpenRun(run_));
  EXPECT_EQ(next_experiment_file(written), run_ / "next_experiment.toml");
  EXPECT_EQ(content_of(run_ / "next_experiment.toml"), "schema = 1\n");
  const auto entry = nlohmann::json::parse(content_of(run_ / "run.json")).at("identification");
  EXPECT_TRUE(entry.at("recommendation").at("model").is_null());
  EXPECT_EQ(entry.at("rounds").at(1).at("reason"), "none is identified");
  EXPECT_EQ(entry.at("refused").at(0).at("model"), "io_valve");
  EXPECT_EQ(entry.at("next_experiment").at("file"), "next_experiment.toml");
  // A later fit that needs none takes it away.
  EXPECT_FALSE(next_experiment_file(publish({.models = {model_that(Came::accepted)}}, record::OpenRun(run_))));
  EXPECT_FALSE(has("next_experiment.toml"));
}

TEST_F(PublishModels, LeavesLatestAloneWhenAllAreRejected) {
  static_cast<void>(publish({.models = {model_that(Came::rejected)}}, record::OpenRun(run_)));
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder_.path() / "latest")));
  EXPECT_TRUE(has("models/rejected/fo.json"));
}

TEST_F(PublishModels, LeavesLatestAloneForARunThatWasStoppedEarlyAndSaysWhy) {
  folder_.write(fs::relative(run_ / "run.json", folder_.path()),
                R"({"schema": "eha-run/1", "outcome": "interrupted", "sample_period_s": 0.001, "repetitions": 1,
                    "samples_per_repetition": 50000, "report": {"counters": {"ticks": 2500}}})");
  static_cast<void>(publish({.models = {model_that(Came::accepted, "io")}}, record::OpenRun(run_)));
  EXPECT_TRUE(has("models/io.json")) << "its models are kept all the same";
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder_.path() / "latest")));
  const auto entry = nlohmann::json::parse(content_of(run_ / "run.json")).at("identification");
  EXPECT_NE(entry.at("not_latest").get<std::string>().find("after 2.5 of 50 s"), std::string::npos) << entry;
}

TEST_F(PublishModels, WritesThroughNoLinkedFolder) {
  const auto elsewhere = folder_.path() / "elsewhere";
  fs::create_directories(elsewhere);
  fs::create_directories(run_ / "models");
  fs::create_directory_symlink(elsewhere, run_ / "models" / "rejected");
  EXPECT_THROW(static_cast<void>(publish({.models = {model_that(Came::rejected)}}, record::OpenRun(run_))),
               PermissionError);
  EXPECT_TRUE(fs::is_empty(elsewhere));
}

TEST_F(PublishModels, WritesThroughNoLinkThatTakesTheFoldersPlaceMeanwhile) {
  const fs::path elsewhere = folder_.path() / "elsewhere";
  fs::create_directories(elsewhere / "rejected");
  folder_.write("elsewhere/fo.json", "of somebody else");
  const fs::path models = run_ / "models";
  const fs::path link = run_ / "link";
  fs::create_directories(models / "rejected");
  fs::create_directory_symlink(elsewhere, link);
  std::atomic<bool> is_over{false};
  std::thread exchange([&] {
    while (!is_over) {
      syscall(SYS_renameat2, AT_FDCWD, models.c_str(), AT_FDCWD, link.c_str(), RENAME_EXCHANGE);
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
  });
  for (int i = 0; i < 200; ++i) {
    for (const Came came : {Came::accepted, Came::rejected}) {
      try {
        static_cast<void>(publish({.models = {model_that(came)}}, record::OpenRun(run_)));
      } catch (const std::exception&) {
        // Refused, or a file is gone: what the other user wants of the own folder.
      }
    }
  }
  is_over = true;
  exchange.join();
  EXPECT_EQ(content_of(elsewhere / "fo.json"), "of somebody else");
  EXPECT_TRUE(fs::is_empty(elsewhere / "rejected"));
  EXPECT_EQ(std::distance(fs::directory_iterator(elsewhere), fs::directory_iterator()), 2);
}

TEST_F(PublishModels, TakesBackAModelThatALaterFitRejects) {
  static_cast<void>(publish({.models = {model_that(Came::accepted)}}, record::OpenRun(run_)));
  static_cast<void>(publish({.models = {model_that(Came::rejected)}}, record::OpenRun(run_)));
  EXPECT_FALSE(has("models/fo.json"));
  EXPECT_TRUE(has("models/rejected/fo.json"));
}

}  // namespace
}  // namespace eha::identify
