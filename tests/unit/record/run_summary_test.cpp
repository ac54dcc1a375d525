// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_summary.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

TEST(RunSummary, SaysLengthFaultAndPurposeAndSurvivesItsJson) {
  const Manifest manifest = manifest_from_json(Json::parse(R"({
    "schema": "eha-run/1", "outcome": "faulted", "sample_period_s": 0.002, "experiment": {"place_in": 3.0},
    "report": {"description": "no_motion at 1 s", "fault": {"cause": "no_motion"}, "counters": {"ticks": 2000}}})"),
                                               "run.json");
  const RunSummary summary = summary_from_json(to_json(summary_of("/runs/a", manifest)), "answer");
  EXPECT_EQ(summary.folder, "/runs/a");
  EXPECT_EQ(summary.outcome, "faulted");
  EXPECT_EQ(summary.fault, "no_motion");
  EXPECT_EQ(summary.purpose, Purpose::placing);
  EXPECT_DOUBLE_EQ(summary.recorded_s, 4.0);
  EXPECT_TRUE(summary.models.empty());
}

TEST(RunSummary, TakesTheLengthOfARecoveredRunFromItsRows) {
  const Manifest manifest =
      manifest_from_json(Json::parse(R"({"schema": "eha-run/1", "outcome": "recovered", "sample_period_s": 0.001,
                      "recovery": {"utc": "", "rows": 8138, "torn_bytes": 0, "end": null}})"),
                         "run.json");
  const RunSummary summary = summary_of("/runs/b", manifest);
  EXPECT_DOUBLE_EQ(summary.recorded_s, 8.138);
  EXPECT_EQ(summary.fault, "");
  EXPECT_EQ(summary.purpose, Purpose::models);
}

TEST(RunSummary, TakesTheFaultOfAKilledRunFromItsRows) {
  const Manifest manifest =
      manifest_from_json(Json::parse(R"({"schema": "eha-run/1", "outcome": "recovered", "fault_of_rows": "sensor_slip",
                      "recovery": {"utc": "", "rows": 8138, "torn_bytes": 0, "end": null}})"),
                         "run.json");
  EXPECT_EQ(summary_of("/runs/b", manifest).fault, "sensor_slip");
}

TEST(RunSummary, NamesTheRecommendedModel) {
  Json run = Json::parse(R"({"schema": "eha-run/1", "outcome": "completed", "identification": {"models": [],
      "recommendation": {"model": "io", "reason": "the only one", "runner_up": null}}})");
  const Json json = to_json(summary_of("/runs/d", manifest_from_json(run, "run.json")));
  EXPECT_EQ(json.at("recommended"), "io");
  EXPECT_EQ(summary_from_json(json, "answer").recommended, "io");
  run["identification"]["recommendation"]["model"] = nullptr;
  EXPECT_TRUE(to_json(summary_of("/runs/d", manifest_from_json(run, "run.json"))).at("recommended").is_null());
}

TEST(RunSummary, ReadsAnAnswerOfAnEarlierVersionAndRefusesOneWithoutAFolder) {
  const Json earlier{{"folder", "/runs/c"}, {"outcome", "completed"}, {"models", Json::array()}};
  EXPECT_DOUBLE_EQ(summary_from_json(earlier, "answer").recorded_s, 0.0);
  EXPECT_THROW(static_cast<void>(summary_from_json({{"outcome", "completed"}}, "answer")), DataError);
}

TEST(ReasonAgainstLatest, IsThatARunEndedBeforeHalfOfItsExperiment) {
  const auto reason = [](const char* outcome, int ticks) {
    const Json run{{"schema", "eha-run/1"},    {"outcome", outcome},
                   {"sample_period_s", 0.001}, {"samples_per_repetition", 25000},
                   {"repetitions", 2},         {"report", {{"counters", {{"ticks", ticks}}}}}};
    return reason_against_latest(manifest_from_json(run, "run.json"));
  };
  EXPECT_NE(reason("interrupted", 4100).find("interrupted after 4.1 of 50 s"), std::string::npos)
      << reason("interrupted", 4100);
  EXPECT_FALSE(reason("faulted", 24000).empty());
  EXPECT_TRUE(reason("faulted", 26000).empty());
  EXPECT_TRUE(reason("precise_enough", 4100).empty()) << "it ended itself, with what was wanted";
  EXPECT_TRUE(reason("completed", 50000).empty());
}

}  // namespace
}  // namespace eha::record
