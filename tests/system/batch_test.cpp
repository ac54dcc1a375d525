// SPDX-License-Identifier: GPL-3.0-or-later
// `eha batch` as a user meets it: its table does not depend on kills, parts or the number of processes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/system/batch_records.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kRecords = 12;
constexpr int kOdd = 7;  // has another gain
const std::vector<std::string> kFit{"--", "--model", "io1", "--decimate", "1"};

std::string record_text(int number) { return first_order_record(number, number == kOdd ? 3.0 : 2.0, 300); }

class Batch : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    fs::create_directory(folder_->path() / "records");
    for (int i = 1; i <= kRecords; ++i) folder_->write("records/r" + std::to_string(10 + i) + ".csv", record_text(i));
    whole_ = new Ended(batch({"batch", "records", "-o", "whole"}));
  }
  static void TearDownTestSuite() {
    delete whole_;
    delete folder_;
  }

  static std::vector<std::string> with_fit(std::vector<std::string> words) {
    words.insert(words.end(), kFit.begin(), kFit.end());
    return words;
  }
  static Ended batch(const std::vector<std::string>& words) { return run_eha(with_fit(words), folder_->path()); }
  static fs::path path(const std::string& name) { return folder_->path() / name; }
  static std::string table(const std::string& name) {
    // The page says when it was written.
    const std::string page = content_of(path(name) / "report.html");
    const std::size_t written = page.find("<p class=\"subtitle\">Written ");
    EXPECT_NE(written, std::string::npos);
    const std::string undated = page.substr(0, written) + page.substr(std::min(page.find('\n', written), page.size()));
    return content_of(path(name) / "table.csv") + content_of(path(name) / "table.json") + undated;
  }
  static std::ptrdiff_t results(const std::string& name) {
    std::error_code none_yet;
    return std::distance(fs::directory_iterator(path(name) / "records", none_yet), fs::directory_iterator());
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* whole_ = nullptr;
};

TEST_F(Batch, JudgesEveryRecordAndNamesTheOneThatIsApart) {
  ASSERT_EQ(whole_->code, 0) << whole_->err;
  const json document = json::parse(content_of(path("whole") / "table.json"));
  EXPECT_EQ(document.at("records_judged"), kRecords);
  EXPECT_EQ(document.at("common_model"), "io1");
  for (const json& record : document.at("records")) {
    const bool is_odd = record.at("source") == "records/r" + std::to_string(10 + kOdd) + ".csv";
    const json& outliers = record.at("outliers");
    ASSERT_EQ(outliers.empty(), !is_odd) << record.at("source") << outliers;
    if (is_odd) {
      EXPECT_EQ(outliers.front().at("parameter"), "K/a0");
    }
    EXPECT_TRUE(fs::exists(path("whole") / "records" / record.at("id") / "models" / "io1.json"));
  }
  EXPECT_NE(whole_->out.find("apart    r17: K"), std::string::npos) << whole_->out;
  const std::size_t row = whole_->out.find("r11 ");
  EXPECT_NE(whole_->out.substr(row, whole_->out.find('\n', row) - row).find("K/a0 = "), std::string::npos)
      << "in figures: " << whole_->out;
  const std::string page = content_of(path("whole") / "report.html");
  EXPECT_NE(page.find("r17 lies apart: K/a0 is"), std::string::npos);
  for (const char* heading : {"Parameters of io1 over the records", "Recommended models", "Records"}) {
    EXPECT_NE(page.find(heading), std::string::npos) << heading;
  }
  EXPECT_EQ(page.find("Not judged"), std::string::npos);
  // What the last line names is a command that works.
  const std::size_t next = whole_->out.rfind("Next: eha compare records/");
  ASSERT_NE(next, std::string::npos) << whole_->out;
  const std::string command = whole_->out.substr(next + 6, whole_->out.find('\n', next) - next - 6);
  EXPECT_TRUE(command.ends_with(" records/r17.csv")) << command;
  const std::string bin = fs::path(EHA_PROGRAM).parent_path().string();
  const std::string said =
      output_of_shell("cd '" + folder_->path().string() + "' && PATH='" + bin + "':$PATH " + command + " 2>&1");
  EXPECT_NE(said.substr(0, said.find('\n')).find(" changed"), std::string::npos) << said;
}

TEST_F(Batch, GoesOnWhereItWasKilled) {
  for (const int after : {1, 4, 9}) {
    const std::string name = "killed" + std::to_string(after);
    const std::vector<std::string> words = with_fit({"batch", "records", "-o", name, "--jobs", "1"});
    const Ended killed = interrupt_eha(
        words, folder_->path(), [&] { return results(name) >= after; }, SIGKILL);
    ASSERT_EQ(killed.code, 128 + SIGKILL);
    ASSERT_LT(results(name), kRecords) << "killed too late to prove anything";
    const fs::path done = path(name) / "records" / "0001-r11" / "result.json";
    const auto written = fs::last_write_time(done);
    const Ended resumed = batch({"batch", "records", "-o", name});
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    EXPECT_EQ(fs::last_write_time(done), written) << "fitted again";
    EXPECT_EQ(table(name), table("whole"));
  }
}

TEST_F(Batch, TakesMoreRecordsAndGivesTheTableOfAFreshOne) {
  // Some of the middle and the last are missing at first.
  folder_->write("some.list", "records/r11.csv\nrecords/r13.csv\nrecords/r14.csv\nrecords/r19.csv\n");
  ASSERT_EQ(batch({"batch", "some.list", "-o", "grown"}).code, 0);
  const auto written_at = [](const std::string& id) {
    return fs::last_write_time(path("grown") / "records" / id / "result.json");
  };
  const auto before = written_at("0004-r19");
  const Ended ended = batch({"batch", "records", "-o", "grown"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(table("grown"), table("whole"));
  EXPECT_EQ(written_at("0009-r19"), before) << "fitted again";
  EXPECT_EQ(results("grown"), kRecords);
}

TEST_F(Batch, EndsAtCtrlCAndSaysHowToGoOn) {
  const Ended ended = interrupt_eha(
      with_fit({"batch", "records", "-o", "stopped", "--jobs", "1"}), folder_->path(),
      [] { return results("stopped") >= 2; }, SIGINT);
  EXPECT_EQ(ended.code, 130);
  EXPECT_NE(ended.err.find("still open"), std::string::npos) << ended.err;
}

TEST_F(Batch, InPartsGivesTheSameTable) {
  for (const std::string part : {"1", "2", "3"}) {
    // The last two share a folder.
    const std::string name = part == "1" ? "part1" : "part23";
    const Ended ended = batch({"batch", "records", "-o", name, "--shard", part + "/3"});
    ASSERT_EQ(ended.code, 0) << ended.err;
  }
  EXPECT_EQ(results("part1"), kRecords / 3);
  const Ended merged = run_eha({"batch", "merge", "part1", "part23", "-o", "merged"}, folder_->path());
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(table("merged"), table("whole"));
}

TEST_F(Batch, ListsWhatCannotBeReadAndJudgesTheRest) {
  fs::create_directory(path("mixed"));
  for (int i = 1; i <= 3; ++i) folder_->write("mixed/good" + std::to_string(i) + ".csv", record_text(i));
  folder_->write("mixed/words.csv", "a;b\nx;y\n");
  folder_->write("mixed/broken.mat", std::string(200, '\1'));
  folder_->write("mixed.list", "# two folders\nmixed/good1.csv\nmixed/gone.csv\nmixed/words.csv\nmixed/broken.mat\n");
  const Ended ended = batch({"batch", "mixed.list", "mixed/good2.csv", "-o", "mixed_out", "--json"});
  EXPECT_EQ(ended.code, 10) << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("records_judged"), 2);
  EXPECT_NE(content_of(path("mixed_out") / "report.html").find("mixed/gone.csv"), std::string::npos);
  for (const json& record : document.at("records")) {
    const bool is_good = record.at("source").get<std::string>().find("good") != std::string::npos;
    EXPECT_EQ(record.at("judged").get<bool>(), is_good) << record;
    EXPECT_EQ(record.at("reason").get<std::string>().empty(), is_good) << record;
  }
}

TEST_F(Batch, PrintsACommandForAFailedFileThatWorks) {
  fs::create_directory(path("asked"));
  folder_->write("asked/good.csv", record_text(1));
  std::string columns = "t,a,b,c\n";
  for (int k = 0; k < 300; ++k) {
    const double u = std::sin(0.1 * k);
    columns += std::to_string(0.02 * k) + "," + std::to_string(u) + "," + std::to_string(0.5 * u) + ",1\n";
  }
  folder_->write("asked/odd name.csv", columns);
  const Ended ended = batch({"batch", "asked", "-o", "asked_out"});
  EXPECT_EQ(ended.code, 10) << ended.out;
  const std::size_t begin = ended.out.find('`');
  ASSERT_NE(begin, std::string::npos) << ended.out;
  const std::string command = ended.out.substr(begin + 1, ended.out.find('`', begin + 1) - begin - 1);
  EXPECT_TRUE(command.starts_with("eha fit 'asked/odd name.csv' --model io1 --decimate 1 ")) << command;
  const std::string bin = fs::path(EHA_PROGRAM).parent_path().string();
  const std::string said = output_of_shell("cd '" + folder_->path().string() + "' && PATH='" + bin + "':$PATH " +
                                           command + " 2>&1; echo code $?");
  EXPECT_TRUE(said.ends_with("code 0\n") || said.ends_with("code 3\n")) << said;
  EXPECT_FALSE(fs::exists(path("asked_out") / "work" / "1-of-1" / "0002-odd-name")) << "left behind";
}

TEST_F(Batch, NamesWhatItSkipsAndWhy) {
  fs::create_directories(path("some/deeper"));
  folder_->write("some/good.csv", record_text(1));
  folder_->write("some/notes.md", "x");
  folder_->write("some/photo.jpg", "x");
  fs::create_symlink("nowhere.csv", path("some/gone.csv"));
  const Ended ended = batch({"batch", "some", "-o", "some/out"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  for (const char* line : {"skipped  2 of some: notes.md, photo.jpg: no ending of a record (.csv, ",
                           "skipped  1 of some: deeper: a folder", "skipped  1 of some: gone.csv: a link to nothing"}) {
    EXPECT_NE(ended.out.find(line), std::string::npos) << line << "\n" << ended.out;
  }
  EXPECT_EQ(ended.out.find("some: out"), std::string::npos) << "the batch's own folder\n" << ended.out;
  const Ended again = batch({"batch", "some", "-o", "some/out"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(again.out.find("some: out"), std::string::npos) << again.out;
}

TEST_F(Batch, TakesNamesAsTheyAreOrRefusesThem) {
  fs::create_directory(path("names"));
  folder_->write("names/-x.csv", record_text(1));
  folder_->write("names/caf\xc3\xa9.csv", record_text(2));
  folder_->write("-y.csv", record_text(3));
  folder_->write("names.list", "-y.csv\n");
  const Ended ended = batch({"batch", "names", "names.list", "-o", "names_out"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  folder_->write("names/caf\xe9.csv", record_text(2));
  const Ended without = batch({"batch", "names", "-o", "other_names"});
  EXPECT_EQ(without.code, 0) << without.err;
  EXPECT_NE(without.out.find("its name is not UTF-8"), std::string::npos) << without.out;
  const Ended refused = batch({"batch", path("names/caf\xe9.csv").string(), "-o", "no_names"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("not UTF-8"), std::string::npos) << refused.err;
}

TEST_F(Batch, LeavesOutRunsThatAreForNoModel) {
  fs::create_directories(path("runs") / "20261122T100000Z-goto");
  folder_->write(
      "runs/20261122T100000Z-goto/run.json",
      R"({"schema": "eha-run/1", "outcome": "completed", "experiment": {"place_in": 2.95, "characterises": false}})");
  folder_->write("runs/r1.csv", record_text(1));
  const Ended ended = batch({"batch", "runs", "-o", "runs_out"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find("1 judged, 0 failed"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("skipped  1 of runs: 20261122T100000Z-goto: a run without"), std::string::npos) << ended.out;
  EXPECT_NE(content_of(path("runs_out") / "report.html").find("that needs 5 records"), std::string::npos);
}

TEST_F(Batch, NamesAParameterThatRises) {
  fs::create_directory(path("drifting"));
  for (int i = 1; i <= kRecords; ++i) {
    folder_->write("drifting/r" + std::to_string(10 + i) + ".csv", first_order_record(i, 2.0 + 0.02 * i, 300));
  }
  const Ended ended = batch({"batch", "drifting", "-o", "drifting_out"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json trends = json::parse(content_of(path("drifting_out") / "table.json")).at("trends");
  ASSERT_EQ(trends.size(), 1U) << trends;
  EXPECT_EQ(trends.front().at("parameter"), "K/a0");
  EXPECT_NEAR(trends.front().at("change").get<double>(), 0.02 * (kRecords - 1) / 1.5, 0.03);
  EXPECT_NE(ended.out.find("trend    K/a0 rises by 0.1"), std::string::npos) << ended.out;
  EXPECT_EQ(ended.out.find("apart    0"), std::string::npos) << ended.out;
  const json whole = json::parse(content_of(path("whole") / "table.json")).at("trends");
  EXPECT_TRUE(whole.empty()) << whole;
}

TEST_F(Batch, RefusesAnotherBatchInItsFolderAndWrongOptions) {
  const auto refused = [](const std::vector<std::string>& words, int code, const std::string& text) {
    const Ended ended = run_eha(words, folder_->path());
    EXPECT_EQ(ended.code, code) << text;
    EXPECT_NE(ended.err.find(text), std::string::npos) << ended.err;
  };
  refused({"batch", "records", "-o", "whole", "--", "--model", "io"}, 2, "holds another batch: its options");
  refused(with_fit({"batch", "records/r11.csv", "-o", "whole"}), 2,
          "it has 12 records, now there are 1, without records/r12.csv");
  refused({"batch", "records", "-o", "new", "--", "--modle", "io"}, 2, "after --:");
  refused({"batch", "records", "-o", "new", "--", "-o", "x"}, 2, "the batch sets this option itself");
  refused({"batch", "records", "-o", "new", "--shard", "4/3"}, 2, "expected I/N");
  refused({"batch", "-o", "new"}, 2, "expected records");
  refused({"batch", "merge", "records"}, 10, "no batch");
  EXPECT_FALSE(fs::exists(path("new")));
}

}  // namespace
}  // namespace eha::test
