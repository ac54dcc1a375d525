// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/run_store.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::web {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kRun = "20261122T100000Z-test";

class RunStoreTest : public ::testing::Test {
 protected:
  RunStoreTest() {
    fs::create_directories(runs_ / kRun / "models");
    std::ofstream(outside_) << "secret";
    store_.set_folder(runs_);
  }

  void put(const std::string& name, const std::string& content, const std::string& run = kRun) const {
    fs::create_directories((runs_ / run / name).parent_path());
    std::ofstream(runs_ / run / name) << content;
  }

  test::TemporaryFolder folder_;
  fs::path runs_ = folder_.path() / "runs";
  fs::path outside_ = folder_.path() / "outside.csv";
  RunStore store_;
};

TEST_F(RunStoreTest, OpensFilesOfARun) {
  put("fit.csv", "a,b\n");
  put("models/io.json", "{}");
  const auto file = store_.open(kRun, "fit.csv");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size, 4U);
  EXPECT_EQ(test::content_of(file->path()), "a,b\n");
  EXPECT_TRUE(store_.open(kRun, "models/io.json"));
  EXPECT_FALSE(store_.open(kRun, "absent.csv"));
  EXPECT_FALSE(store_.open("absent", "fit.csv"));
}

TEST_F(RunStoreTest, ReadsNoManifestThatIsLongerThanItCanBe) {
  put("run.json", "{}");
  EXPECT_EQ(store_.manifest(kRun), "{}");
  // Sparse: it takes no room on the disk, but would take as much memory as it says.
  fs::resize_file(runs_ / kRun / "run.json", std::uint64_t{1} << 40U);
  try {
    static_cast<void>(store_.manifest(kRun));
    ADD_FAILURE();
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()),
              std::string(kRun) + ": its run.json has 1099511627776 bytes; expected at most 16777216");
  }
  EXPECT_EQ(store_.list(1).at(0).at("outcome"), "unreadable");
  EXPECT_THROW(static_cast<void>(store_.manifest("absent")), DataError);
}

TEST_F(RunStoreTest, OpensNothingOutsideOfTheRuns) {
  fs::create_symlink(outside_, runs_ / kRun / "link.csv");
  fs::create_directory_symlink(folder_.path(), runs_ / kRun / "folder");
  fs::create_directory_symlink(folder_.path(), runs_ / "other");
  fs::create_directory_symlink(runs_ / kRun, runs_ / "latest");
  put("fit.csv", "");
  for (const char* path : {"../../outside.csv", "link.csv", "folder/outside.csv", "./../../outside.csv", "/etc/passwd",
                           "models/../../../outside.csv", "", ".", "models"}) {
    EXPECT_FALSE(store_.open(kRun, path)) << path;
  }
  for (const char* id : {"..", ".", "", "other", "latest", "../runs/20261122T100000Z-test", "/etc", "a/b"}) {
    EXPECT_FALSE(store_.open(id, "outside.csv")) << id;
    EXPECT_FALSE(store_.open(id, "fit.csv")) << id;
  }
  EXPECT_FALSE(store_.open(kRun, outside_.string())) << "an absolute path";
}

TEST_F(RunStoreTest, OpensNoPipeAndDoesNotWaitForItsWriter) {
  ASSERT_EQ(mkfifo((runs_ / kRun / "fit.csv").c_str(), 0644), 0);
  EXPECT_FALSE(store_.open(kRun, "fit.csv"));
}

TEST_F(RunStoreTest, OpensNothingBeforeTheFolderIsKnownOrAfterItIsGone) {
  put("fit.csv", "");
  EXPECT_FALSE(RunStore().open(kRun, "fit.csv"));
  EXPECT_TRUE(RunStore().list(10).empty());
  fs::remove_all(runs_);
  EXPECT_FALSE(store_.open(kRun, "fit.csv"));
  EXPECT_TRUE(store_.list(10).empty());
  EXPECT_EQ(store_.newest(), "");
}

TEST_F(RunStoreTest, ListsTheNewestRunsFirstWithWhatTheirManifestsSay) {
  put("run.json",
      R"({"schema": "eha-run/1", "outcome": "completed", "utc_start": "2026-11-22T10:00:00Z", "name": "test",
    "files": [{"path": "data_40ms.csv", "sha256": ""}, {"path": "raw.ehalog", "sha256": ""},
              {"path": "models/io.json", "sha256": ""}, {"path": "../x.csv", "sha256": ""}],
    "identification": {"accepted": true,
      "models": [{"name": "io", "file": "models/io.json", "accepted": true, "grade": "good"}],
      "recommendation": {"model": "io", "reason": "the only one", "runner_up": null}}})");
  put("report.html", "<html></html>");
  put("run.json", "{ half", "20261122T110000Z-broken");
  fs::create_directories(runs_ / "20261122T120000Z-empty");
  fs::create_directories(runs_ / ".hidden");
  const Json runs = store_.list(10);
  ASSERT_EQ(runs.size(), 3U) << runs;
  EXPECT_EQ(runs[0].at("id"), "20261122T120000Z-empty");
  EXPECT_EQ(runs[0].at("outcome"), "unreadable");
  EXPECT_EQ(runs[1].at("outcome"), "unreadable");
  EXPECT_FALSE(runs[1].at("error").get<std::string>().empty());
  const Json& run = runs[2];
  EXPECT_EQ(run.at("id"), kRun);
  EXPECT_EQ(run.at("name"), "test");
  EXPECT_EQ(run.at("started"), "2026-11-22T10:00:00Z");
  EXPECT_EQ(run.at("outcome"), "completed");
  EXPECT_EQ(run.at("grade"), "good");
  EXPECT_EQ(run.at("recommended"), "io");
  EXPECT_EQ(run.at("reason"), "the only one");
  EXPECT_EQ(run.at("has_report"), true);
  EXPECT_EQ(run.at("files"), Json::parse(R"(["run.json", "data_40ms.csv", "models/io.json"])"));
  EXPECT_EQ(store_.list(1).size(), 1U);
}

TEST_F(RunStoreTest, SaysOfACharacterisationWhatItMeasuredAndNothingOfModels) {
  put("run.json", R"({"schema": "eha-run/1", "outcome": "completed", "experiment": {"characterises": true},
    "identification": {"accepted": false, "models": [], "error": "no valve sheet: rows are lost"}})");
  EXPECT_EQ(store_.list(1).at(0).at("measured"), "no valve sheet");
  EXPECT_EQ(store_.list(1).at(0).at("grade"), nullptr) << "the page would say that no model was accepted";
  EXPECT_EQ(store_.list(1).at(0).at("reason"), "no valve sheet: rows are lost");
  put("valve_sheet.json", R"({"null_V": {"value": -0.2}, "dead_band_V": {"value": 0.1511},
    "gain_positive_in_per_V_s": {"value": 0.14845}, "gain_negative_in_per_V_s": {"value": 0.13071}})");
  EXPECT_EQ(store_.list(1).at(0).at("measured"),
            "valve: null -0.200 V, half dead band 0.151 V, 0.148 in/(V s) extending, 0.131 in/(V s) retracting");
}

TEST_F(RunStoreTest, ReadsAManifestAgainWhenItChanged) {
  put("run.json", R"({"schema": "eha-run/1", "outcome": "in_progress", "name": "test"})");
  EXPECT_EQ(store_.list(1).at(0).at("outcome"), "in_progress");
  put("run.json", R"({"schema": "eha-run/1", "outcome": "interrupted", "name": "test"})");
  EXPECT_EQ(store_.list(1).at(0).at("outcome"), "interrupted");
  fs::remove_all(runs_ / kRun);
  EXPECT_TRUE(store_.list(1).empty());
}

TEST_F(RunStoreTest, KnowsTheNewestRunWithAJournal) {
  EXPECT_EQ(store_.newest(), "");
  put("raw.ehalog", "x");
  fs::create_directories(runs_ / "20261122T120000Z-prepared");
  EXPECT_EQ(store_.newest(), kRun);
}

TEST(Download, IsARecordATableOrAModelOfTheRun) {
  for (const char* path :
       {"run.json", "raw.h5", "data_40ms.csv", "fit.csv", "models/io.json", "models/rejected/fo.json"}) {
    EXPECT_TRUE(is_download(path)) << path;
  }
  for (const char* path : {"", "raw.ehalog", "report.html", ".csv", "models/.json", "models/x/io.json",
                           "models/../run.json", "../fit.csv", "/etc/x.csv", "a/b.csv", "models/rejected/../io.json",
                           ".hidden.csv", "models/.hidden.json", "x.csv\n", "x.csv/"}) {
    EXPECT_FALSE(is_download(path)) << path;
  }
}

}  // namespace
}  // namespace eha::web
