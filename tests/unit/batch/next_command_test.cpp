// SPDX-License-Identifier: GPL-3.0-or-later
// The command after the table of a batch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/batch/batch_page.hpp"
#include "daemon/batch/next_of_batch.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::batch {
namespace {

using Json = nlohmann::ordered_json;

struct Judged {
  double gain = 0.13;
  bool accepted = true;
  std::string failure = {};  ///< last line of a record that was not judged
  std::string warning = {};
};

Result result_of(const Judged& one) {
  Result result;
  result.exit_code = one.failure.empty() ? 0 : 10;
  result.message = one.failure;
  if (!one.failure.empty()) return result;
  if (!one.warning.empty()) result.message = "eha: warning: " + one.warning + "\n";
  result.fit = Json::parse(fmt::format(
      R"({{"models": [{{"name": "io", "parameters": [{{"name": "K", "value": {0}, "std": 0.0005, "lower95": {1},
          "upper95": {2}, "fixed": false}}], "verdict": {{"accepted": {3}, "grade": "{4}"}}}}],
          "recommendation": {{"model": {5}}}}})",
      one.gain, one.gain - 0.001, one.gain + 0.001, one.accepted, one.accepted ? "good" : "rejected",
      one.accepted ? "\"io\"" : "null"));
  return result;
}

class NextOfBatch : public testing::Test {
 protected:
  std::string next_of(const std::vector<Judged>& judged, std::vector<std::string> options = {}) {
    Batch batch{rules_of(std::move(options)), {}};
    for (std::size_t i = 0; i < judged.size(); ++i) {
      const std::string id = fmt::format("{:04}", i + 1);
      batch.records.push_back({.id = id, .source = fmt::format("pump {}.csv", i + 1), .sha256 = id});
    }
    BatchFolder folder(folder_.path() / fmt::format("batch{}", ++count_), batch);
    folder.claim({});
    for (std::size_t i = 0; i < judged.size(); ++i) {
      (void)folder.work_folder(batch.records[i]);
      folder.publish(batch.records[i], result_of(judged[i]));
    }
    path_ = folder.path();
    return next_command(folder, table_of(folder));
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_;
  int count_ = 0;
};

const std::vector<Judged> kAlike{{0.1300}, {0.1302}, {0.1299}, {0.1301}, {0.1300}, {0.1303}};

TEST_F(NextOfBatch, ComparesTheRecordThatIsApartWithTheMostOrdinaryOne) {
  std::vector<Judged> judged = kAlike;
  judged[1].gain = 0.25;
  judged[0].gain = 0.1296;
  judged[2].gain = 0.1301;
  // The median of all is that of records 3 and 4.
  EXPECT_EQ(next_of(judged), "eha compare 'pump 3.csv' 'pump 2.csv'");
  EXPECT_EQ(next_of(judged, {"--intersample", "foh"}), "eha compare 'pump 3.csv' 'pump 2.csv' --intersample foh");
}

TEST_F(NextOfBatch, CallsNoRecordOrdinaryThatIsWarnedOf) {
  std::vector<Judged> judged = kAlike;
  judged[1].gain = 0.25;
  judged[3].warning = "the rod sticks";  // at the median, 0.1301
  judged[2].gain = 0.1296;
  EXPECT_EQ(next_of(judged), "eha compare 'pump 1.csv' 'pump 2.csv'");
  for (Judged& one : judged) one.warning = "the rod sticks";
  EXPECT_NE(next_of(judged).find(" 'pump 2.csv'"), std::string::npos) << "where all are";
}

TEST_F(NextOfBatch, ComparesModelsOfRecordsThatOnlyOptionsRead) {
  std::vector<Judged> judged = kAlike;
  judged[1].gain = 0.25;
  const std::string command = next_of(judged, {"--model", "io", "--period=0.01"});
  EXPECT_EQ(command.find(".csv"), std::string::npos) << command;
  EXPECT_TRUE(command.ends_with("records/0002/models/io.json")) << command;
  EXPECT_TRUE(next_of(judged, {"--input-late", "2"}).ends_with("records/0002/models/io.json"));
}

TEST_F(NextOfBatch, FitsARecordThatIsNotComparedAsTheBatchDid) {
  std::vector<Judged> judged = kAlike;
  judged[4].accepted = false;
  EXPECT_EQ(next_of(judged, {"--model", "io"}), "eha fit 'pump 5.csv' --model io -o 'models-pump 5'");
}

TEST_F(NextOfBatch, NamesTheCommandThatReadsAFailedRecord) {
  std::vector<Judged> judged = kAlike;
  judged[3].failure = "pump 4.csv: the sensor shows no motion (`eha read --local` shows it)";
  judged[5].failure = "pump 6.csv:1: which columns? For example: `eha fit 'pump 6.csv' --input 2 --output 3`";
  EXPECT_EQ(next_of(judged), "eha fit 'pump 6.csv' --input 2 --output 3 -o 'models-pump 6'") << "and writes the models";
}

TEST_F(NextOfBatch, ComparesFewRecordsAndOpensThePageOfMany) {
  EXPECT_EQ(next_of({{0.13}, {0.25}}), "eha compare 'pump 1.csv' 'pump 2.csv'");
  EXPECT_EQ(next_of({{0.13}}), "xdg-open " + (folder_.path() / "batch2/report.html").string());
  EXPECT_EQ(next_of(kAlike), "xdg-open " + (folder_.path() / "batch3/report.html").string());
}

TEST_F(NextOfBatch, StandsOnThePageBehindWhatIsToDo) {
  std::vector<Judged> judged = kAlike;
  judged[4].accepted = false;
  const std::string next = next_of(judged);
  const std::string html = page_of(table_of(BatchFolder(path_)), next).html;
  const std::size_t to_do = html.find("<p>To do: cut or repeat");
  ASSERT_NE(to_do, std::string::npos) << html;
  EXPECT_NE(html.find("<p>Next: <code>eha fit &#39;pump 5.csv&#39;", to_do), std::string::npos)
      << html.substr(to_do, 400);
  EXPECT_LT(to_do, html.find("records are judged.")) << "before what was done";
  const std::string opens = next_of(kAlike);
  EXPECT_EQ(page_of(table_of(BatchFolder(path_)), opens).html.find("Next: "), std::string::npos) << opens;
}

TEST_F(NextOfBatch, LetsALongNameOnThePageBreakSoThatTheReasonsColumnHasRoom) {
  (void)next_of(kAlike);
  const std::string html = page_of(table_of(BatchFolder(path_))).html;
  EXPECT_NE(html.find("<td class=\"name\" data-label=\"record\">pump 1</td>"), std::string::npos);
  EXPECT_NE(html.find("<td class=\"name\" data-label=\"source\">"), std::string::npos);
  EXPECT_NE(html.find("td.name { overflow-wrap: anywhere;"), std::string::npos);
}

TEST_F(NextOfBatch, PageNamesRunsAndFilesAndGivesTheirFoldersOnce) {
  Batch batch{rules_of({}), {}};
  const std::vector<std::string> sources{"/home/meier/bench/runs/20261123T101500Z-paper",
                                         "/home/meier/bench/logs/gone.csv"};
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string id = fmt::format("{:04}", i + 1);
    batch.records.push_back({.id = id, .source = sources[i], .sha256 = id});
  }
  BatchFolder folder(folder_.path() / "named", batch);
  folder.claim({});
  for (std::size_t i = 0; i < sources.size(); ++i) {
    (void)folder.work_folder(batch.records[i]);
    folder.publish(batch.records[i], result_of(i == 0 ? Judged{} : Judged{.failure = "eha: error: no such file"}));
  }
  const std::string html = page_of(table_of(folder), "").html;
  EXPECT_NE(html.find(">20261123T101500Z-paper<"), std::string::npos) << html;
  EXPECT_NE(html.find("gone, gone.csv: "), std::string::npos) << html;
  for (const std::string& source : sources) {
    const std::size_t at = html.find(source);
    ASSERT_NE(at, std::string::npos) << source;
    EXPECT_EQ(html.find(source, at + 1), std::string::npos) << source << " stands in the provenance alone";
  }
}

}  // namespace
}  // namespace eha::batch
