// SPDX-License-Identifier: GPL-3.0-or-later
// What the records of a batch can show of a parameter.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/batch/batch_page.hpp"
#include "daemon/batch/batch_table.hpp"
#include "daemon/batch/record_list.hpp"
#include "daemon/batch/table_text.hpp"
#include "ident/model/model_file.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::batch {
namespace {

using Json = nlohmann::ordered_json;

/// A record's fit with one model of a dead band.
Result fit_with(double dead_band, bool accepted) {
  Result result;
  result.fit = Json::parse(fmt::format(
      R"({{"models": [{{"name": "io_valve", "parameters": [{{"name": "dead_band", "value": {0}, "std": 0.0005,
          "lower95": {1}, "upper95": {2}, "fixed": false}}], "verdict": {{"accepted": {3}, "grade": "{4}"}}}}],
          "recommendation": {{"model": {5}}}}})",
      dead_band, dead_band - 0.001, dead_band + 0.001, accepted, accepted ? "good" : "rejected",
      accepted ? "\"io_valve\"" : "null"));
  return result;
}

Table table_with(const std::vector<double>& accepted, const std::vector<double>& rejected,
                 const std::filesystem::path& path) {
  Batch batch{rules_of({}), {}};
  std::vector<Result> results;
  const auto add = [&](double dead_band, bool is_accepted) {
    const std::string id = fmt::format("{:04}", batch.records.size() + 1);
    batch.records.push_back({.id = id, .source = id + ".csv", .sha256 = id});
    results.push_back(fit_with(dead_band, is_accepted));
  };
  for (const double value : accepted) add(value, true);
  for (const double value : rejected) add(value, false);
  BatchFolder folder(path, batch);
  folder.claim({});
  for (std::size_t i = 0; i < results.size(); ++i) {
    (void)folder.work_folder(batch.records[i]);
    folder.publish(batch.records[i], results[i]);
  }
  return table_of(folder);
}

TEST(BatchTable, SaysTheSmallestChangeThatItsRecordsCanShow) {
  const test::TemporaryFolder folder;
  const std::vector<double> few{0.143, 0.148, 0.151, 0.154, 0.209};
  const Table table = table_with(few, {}, folder.path() / "few");
  ASSERT_EQ(table.resolutions.size(), 1U);
  const Resolution& found = table.resolutions.front();
  // The one that lies furthest is named, with what would have been needed.
  EXPECT_EQ(found.parameter, "dead_band");
  EXPECT_EQ(found.furthest_row, 4U);
  EXPECT_NEAR(found.median, 0.151, 1e-12);
  for (const Row& row : table.rows) {
    for (const Outlier& one : row.outliers) EXPECT_GT(std::abs(one.value - one.median), found.change);
  }
  EXPECT_EQ(table.rows[4].outliers.empty(), 0.209 - 0.151 <= found.change) << found.change;
  EXPECT_NE(spread_text(table, table.resolutions.front()).find("median 0.151, furthest from it 0.209 (0005)"),
            std::string::npos)
      << spread_text(table, table.resolutions.front());
  // A record that is off by more than the most precise one shows, and is not called apart, has its own figure.
  const Resolution unlike{.parameter = "K",
                          .change = 0.0019,
                          .change_row = 1,
                          .furthest_change = 0.005,
                          .furthest_row = 3,
                          .furthest = 0.152,
                          .median = 0.148};
  EXPECT_TRUE(spread_text(table, unlike)
                  .ends_with("; a change of 0.0019 or more would have been seen in 0002, the most precise record, and "
                             "of 0.005 in 0004"))
      << spread_text(table, unlike);
  // More records show a smaller change.
  std::vector<double> many = few;
  for (int i = 0; i < 15; ++i) many.push_back(0.148 + 0.0005 * (i % 7));
  EXPECT_LT(table_with(many, {}, folder.path() / "many").resolutions.front().change, found.change);
}

TEST(BatchTable, CarriesTheWarningsOfItsRecordsOncePerKind) {
  const test::TemporaryFolder folder;
  BatchFolder batch(folder.path(), {rules_of({}),
                                    {{.id = "0001-a", .source = "recs/a.csv", .sha256 = "1"},
                                     {.id = "0002-b", .source = "recs/b.csv", .sha256 = "2"}}});
  batch.claim({});
  for (const Record& record : batch.batch().records) {
    Result result = fit_with(0.15, true);
    const bool is_first = record.id == "0001-a";
    result.message = fmt::format(
        "eha: info: read as CSV\neha: warning: within half a row the input moves by {} % of its spread, taken as held; "
        "as straight lines the error of {} falls: `eha fit {} --intersample foh`\n",
        is_first ? "3.1" : "42", is_first ? "io_valve" : "fo", record.source);
    if (is_first) result.message += "eha: warning: recs/a.csv: the rod stands still\n";
    (void)batch.work_folder(record);
    batch.publish(record, result);
  }
  const Table table = table_of(batch);
  const std::vector<WarningKind> kinds = warning_kinds(table);
  ASSERT_EQ(kinds.size(), 2U);
  EXPECT_EQ(kinds[0].rows, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(warning_text(table, kinds[0]).rfind("2 of 2 records (a, b): within half a row", 0), 0U);
  EXPECT_NE(kinds[0].text.find("(figures of a, the others have their own)"), std::string::npos);
  EXPECT_EQ(kinds[1].text.find("(figures of"), std::string::npos) << "one record";
  EXPECT_EQ(kinds[1].rows, (std::vector<std::size_t>{0}));
  EXPECT_EQ(to_json(table)["records"][0]["warnings"].size(), 2U);
  EXPECT_EQ(to_json(table)["records"][1]["warnings"].size(), 1U);
  const std::string html = page_of(table).html;
  EXPECT_NE(html.find("Warned: 2 of 2 records"), std::string::npos);
  EXPECT_NE(html.find("To do: follow the warnings"), std::string::npos);
}

TEST(BatchTable, NamesARunOfALinkByItsOwnName) {
  const test::TemporaryFolder folder;
  for (const char* bench : {"a", "b"}) {
    const std::filesystem::path runs = folder.path() / bench;
    std::filesystem::create_directories(runs / fmt::format("20261126T101500Z-{}", bench));
    std::filesystem::create_directory_symlink(fmt::format("20261126T101500Z-{}", bench), runs / "latest");
    folder.write(fmt::format("{}/latest/run.json", bench), "{}");
  }
  const FoundRecords found = records_of({(folder.path() / "a/latest").string(), (folder.path() / "b/latest").string()});
  ASSERT_EQ(found.records.size(), 2U);
  EXPECT_EQ(found.records[0].id, "0001-20261126T101500Z-a");
  EXPECT_EQ(found.records[1].id, "0002-20261126T101500Z-b");
}

TEST(BatchTable, TakesTheRunsOfAFolderByWhenTheyBegan) {
  const test::TemporaryFolder folder;
  const auto names = [&] {
    std::string all;
    for (const Record& record : records_of({folder.path().string()}).records) {
      all += std::filesystem::path(record.source).filename().string() + " ";
    }
    return all;
  };
  const auto write = [&](const std::string& name, const std::string& utc_start) {
    std::filesystem::create_directories(folder.path() / name);
    folder.write(name + "/run.json",
                 fmt::format(R"({{"schema": "eha-run/1", "outcome": "completed", "utc_start": {}}})", utc_start));
  };
  write("after", "\"2026-11-26T11:00:00Z\"");
  write("before", "\"2026-11-26T10:00:00Z\"");
  EXPECT_EQ(names(), "before after ");
  write("another", "null");
  EXPECT_EQ(names(), "after another before ") << "one does not say when";
}

TEST(BatchTable, HasTheWordsOfTheTablesForVerdicts) {
  const test::TemporaryFolder folder;
  Table table = table_with({0.150, 0.151, 0.149, 0.150, 0.152}, {}, folder.path());
  table.rows[0].fit["models"][0]["verdict"]["word"] = "outdone";
  const std::string csv = to_csv(table);
  EXPECT_NE(csv.find(",io_valve,yes,outdone,yes,"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",io_valve,yes,good,yes,"), std::string::npos) << csv;
}

TEST(BatchTable, GivesUnitsAndNoPluralOfOne) {
  const Outlier one{.parameter = "null", .value = 0.4, .median = 0.3, .half_width = 0.05, .unit = "V"};
  EXPECT_EQ(outlier_text(one), "null is 0.4 V, more than 0.05 V from the median of all, 0.3 V");
  const test::TemporaryFolder folder;
  const std::string html = page_of(table_with({0.15}, {}, folder.path())).html;
  EXPECT_EQ(html.find("over 1 records"), std::string::npos);
  EXPECT_EQ(html.find("<svg"), std::string::npos) << "a plot of one point";
  EXPECT_NE(html.find("1 of 1 record is judged."), std::string::npos);
}

TEST(BatchTable, SaysAsACompareDoesWhatAChangedGainMayBe) {
  Row row;
  row.fit = {{"models", Json::array({{{"name", "io"}}, {{"name", "io_valve"}, {"input_map", Json::object()}}})}};
  row.outliers = {{.parameter = "K"}};
  EXPECT_TRUE(instead_text(row, "io").starts_with("without a valve map a dead band")) << instead_text(row, "io");
  EXPECT_EQ(instead_text(row, "io_valve"), "");
  row.outliers.push_back({.parameter = "dead_band"});
  EXPECT_EQ(instead_text(row, "io_valve"), "dead_band or K changed, or both, as the fit lets one follow the other");
}

TEST(BatchTable, SaysWhyARecordHasNoModel) {
  const test::TemporaryFolder folder;
  Table table = table_with({0.150}, {0.9}, folder.path());
  EXPECT_EQ(why_none(table.rows[0]), "");
  EXPECT_EQ(why_none(table.rows[1]), "") << "a result without a reason";
  table.rows[1].fit["recommendation"]["reason"] = "What is left is plain noise.";
  EXPECT_EQ(why_none(table.rows[1]), "What is left is plain noise.");
  const std::string html = page_of(table).html;
  EXPECT_NE(html.find("What is left is plain noise."), std::string::npos);
  EXPECT_NE(html.find("0002"), std::string::npos) << "in the table";
}

TEST(BatchPage, SaysOnceThatFewRecordsAreNotCompared) {
  const test::TemporaryFolder folder;
  const std::string html = page_of(table_with({0.150, 0.151}, {}, folder.path())).html;
  EXPECT_NE(html.find("<svg"), std::string::npos);
  EXPECT_NE(html.find("Nothing was compared: that needs 5 records"), std::string::npos);
  EXPECT_EQ(html.find("Nothing is compared"), std::string::npos) << "again, beside a plot";
  EXPECT_EQ(html.find("Record more."), std::string::npos);
}

TEST(BatchPage, NamesTheRigOfARunAndBreaksNoName) {
  const test::TemporaryFolder folder;
  const std::string run = (folder.path() / "20261126T101500Z-a").string();
  std::filesystem::create_directories(run);
  folder.write("20261126T101500Z-a/run.json",
               R"({"schema": "eha-run/1", "outcome": "completed", "rig": {"name": "bench, worn"}})");
  const Record record{.id = "0001-20261126T101500Z-a", .source = run, .sha256 = "1"};
  BatchFolder batch(folder.path() / "judged", {rules_of({}), {record}});
  batch.claim({});
  (void)batch.work_folder(record);
  batch.publish(record, fit_with(0.15, true));
  const std::string html = page_of(table_of(batch)).html;
  EXPECT_NE(html.find(">bench, worn</td>"), std::string::npos);
  EXPECT_NE(html.find("<td class=\"id\">0001-<wbr>20261126T101500Z-<wbr>a</td>"), std::string::npos);
  EXPECT_EQ(page_of(table_with({0.15}, {}, folder.path() / "files")).html.find(">rig</th>"), std::string::npos)
      << "of files alone";
}

TEST(BatchTable, HasNoRigOfARunWhoseNameOfItIsNoText) {
  const test::TemporaryFolder folder;
  const std::string run = (folder.path() / "20261126T101500Z-a").string();
  std::filesystem::create_directories(run);
  folder.write("20261126T101500Z-a/run.json", R"({"schema": "eha-run/1", "outcome": "completed", "rig": {"name": 7}})");
  const Record record{.id = "0001-a", .source = run, .sha256 = "1"};
  BatchFolder batch(folder.path() / "judged", {rules_of({}), {record}});
  batch.claim({});
  (void)batch.work_folder(record);
  batch.publish(record, fit_with(0.15, true));
  EXPECT_EQ(table_of(batch).rows.at(0).rig, "");
}

TEST(BatchTable, LeavesRejectedModelsOut) {
  const test::TemporaryFolder folder;
  const Table table = table_with({0.150, 0.151, 0.149, 0.150, 0.152}, {0.9, 1.2}, folder.path());
  ASSERT_EQ(table.common_model, "io_valve");
  ASSERT_EQ(parameters_of(table.rows, "io_valve").size(), 1U);
  EXPECT_EQ(parameters_of(table.rows, "io_valve").front().estimates.size(), 5U);
  for (const Row& row : table.rows) EXPECT_TRUE(row.outliers.empty()) << row.record.id;
}

TEST(BatchTable, NamesEachRecordThatItDoesNotCompare) {
  const test::TemporaryFolder folder;
  Table table = table_with({0.150, 0.151, 0.149, 0.150, 0.152}, {0.9}, folder.path());
  table.rows[5].fit["models"][0]["verdict"]["reasons"] = {"The rod stands on an end stop; cut it.", "More."};
  table.rows[4].fit["models"] = Json::array();
  const std::vector<NotCompared> left_out = not_compared(table.rows, "io_valve");
  ASSERT_EQ(left_out.size(), 2U);
  EXPECT_EQ(left_out[0].row, 4U);
  EXPECT_EQ(left_out[0].reason, "io_valve was not fitted");
  EXPECT_EQ(left_out[1].row, 5U);
  EXPECT_EQ(left_out[1].reason, "io_valve is rejected: The rod stands on an end stop");
  Table other = table;
  other.rows[5].fit["models"].push_back({{"name", "io1"}, {"verdict", {{"accepted", true}, {"word", "good"}}}});
  other.rows[5].recommended = "io1";
  EXPECT_EQ(not_compared(other.rows, "io_valve")[1].reason,
            "io_valve is rejected, as another structure suits this record: io1")
      << "nothing is wrong with the record";
  EXPECT_EQ(to_json(table)["records"][5]["not_compared"], left_out[1].reason);
  EXPECT_EQ(to_json(table)["records"][0]["not_compared"], "");
  const std::string html = page_of(table).html;
  EXPECT_NE(html.find("0006 is not compared, so it may be the one that changed: io_valve is rejected"),
            std::string::npos);
  EXPECT_EQ(html.find("No record lies apart"), std::string::npos);
}

TEST(BatchTable, NamesARecordWhoseModelLacksAParameterThatTheOthersHave) {
  const test::TemporaryFolder folder;
  Table table = table_with({0.150, 0.151, 0.149, 0.150, 0.152, 0.150}, {}, folder.path());
  EXPECT_TRUE(not_compared(table.rows, "io_valve").empty());
  const Json lag = {{"name", "a2"},     {"value", 0.006},   {"std", 0.0005},
                    {"lower95", 0.005}, {"upper95", 0.007}, {"fixed", false}};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    Json& parameters = table.rows[i].fit["models"][0]["parameters"];
    parameters.push_back(lag);
    if (i == 3) parameters.back()["name"] = "delay_s";
  }
  const std::vector<NotCompared> left_out = not_compared(table.rows, "io_valve");
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out.front().row, 3U);
  EXPECT_TRUE(left_out.front().in_part);
  EXPECT_EQ(left_out.front().reason, "its io_valve has delay_s in place of a2");
  const std::string html = page_of(table).html;
  EXPECT_NE(html.find("0004 is compared in part, so it may be the one that changed"), std::string::npos);
  EXPECT_EQ(html.find("No record lies apart"), std::string::npos);
}

TEST(BatchTable, DrawsTheIntervalsByWhichItCompares) {
  const test::TemporaryFolder folder;
  const Table table = table_with({0.150, 0.151, 0.149, 0.150, 0.152, 0.150, 0.151, 0.3}, {}, folder.path());
  const Parameter parameter = parameters_of(table.rows, "io_valve").front();
  for (const Estimate& one : parameter.estimates) {
    const bool holds_median = std::abs(one.value - parameter.median) <= one.half_width;
    EXPECT_EQ(holds_median, table.rows[one.row].outliers.empty()) << one.row;
  }
  EXPECT_FALSE(table.rows[7].outliers.empty());
}

TEST(BatchTable, DoesNotCompareInchesWithMillimetres) {
  const test::TemporaryFolder folder;
  Table table = table_with({0.150, 0.151, 3.81}, {}, folder.path());
  for (std::size_t i = 0; i < 3; ++i) {
    table.rows[i].fit["models"][0]["units"] = {{"input", "V"}, {"output", i < 2 ? "in" : "mm"}};
  }
  EXPECT_EQ(parameters_of(table.rows, "io_valve").front().estimates.size(), 2U);
  EXPECT_EQ(rows_in_other_units(table.rows, "io_valve"), std::vector<std::size_t>{2});
  const std::string html = page_of(table).html;
  EXPECT_NE(html.find("in other units: 0003."), std::string::npos);
  EXPECT_NE(html.find("Nothing was compared"), std::string::npos) << "of fewer than five";
  EXPECT_LT(html.find("<h2>Records</h2>"), html.find("<svg")) << "the answer comes first";
}

TEST(BatchPage, BeginsWithTheWorstThatWasFound) {
  const test::TemporaryFolder folder;
  const auto box_of = [](const Table& table) {
    const std::string html = page_of(table).html;
    const std::size_t begin = html.find("<section class=\"verdict");
    return html.substr(begin, html.find("</section>", begin) - begin);
  };
  const Table alike = table_with({0.150, 0.151, 0.149, 0.1505, 0.1495, 0.1502}, {}, folder.path() / "alike");
  EXPECT_NE(box_of(alike).find("<h2>No record lies apart from the others</h2>"), std::string::npos) << box_of(alike);
  const Table apart = table_with({0.150, 0.151, 0.149, 0.1505, 0.1495, 0.40}, {}, folder.path() / "apart");
  const std::string box = box_of(apart);
  EXPECT_NE(box.find("<h2>1 record lies apart from the others</h2>"), std::string::npos) << box;
  EXPECT_LT(box.find("0006 lies apart"), box.find("records are judged"));
}

TEST(BatchTable, HasFiguresOfARecordThatWasAllEstimatedOn) {
  ident::Model model;
  model.name = "io1";
  model.output_unit = "in";
  model.transfer_function = {{{2.0, 0.0}}, {{1.0, 1.0}, {1.0, 0.0}}};
  model.estimation.emplace();
  model.estimation->score.samples = 100;
  model.estimation->score.mse = 0.01;
  model.estimation->score.r2_percent = 99.0;
  model.estimation->score.fit_percent = 90.25;
  const Json fit{{"models", Json::array({Json::parse(ident::to_text(model))})}};
  const RowFigures figures = figures_of(fit, "io1");
  EXPECT_EQ(figures.fit_percent, "90.2");
  EXPECT_EQ(figures.error, "0.1 in (rms)");
  EXPECT_FALSE(figures.form.empty());
}

}  // namespace
}  // namespace eha::batch
