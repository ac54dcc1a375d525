// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/manifest.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/error.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

/// A manifest with every section, and in each a member that no struct names.
constexpr const char* kWhole = R"({
  "schema": "eha-run/1", "outcome": "completed", "utc_start": "2026-11-21T11:01:46Z", "utc_end": "2026-11-21T11:02:46Z",
  "name": "sine", "future": {"b": 1, "a": [2, 3]},
  "files": [{"path": "raw.h5", "bytes": 12, "sha256": "00", "future": true}],
  "report": {"description": "", "counters": {"ticks": 2000, "late": 3, "queue_peak": 9}, "latency": {"p50_us": 4.5}},
  "identification": {
    "accepted": true,
    "models": [{"name": "io", "file": "models/io.json", "accepted": true, "reasons": ["It is white."],
                "estimation_r2_percent": 99.5, "seconds": 0.25, "validation_r2_percent": null, "grade": "good"}],
    "recommendation": {"model": "io", "reason": "It is the only one.", "runner_up": null, "needs_fresh_record": false},
    "paper_procedure": [], "of_a_later_version": {"model": "io"}},
  "recovery": {"utc": "2026-11-22T00:00:00Z", "rows": 5, "torn_bytes": 6, "end": {"outcome": "completed"}}})";

TEST(WithoutRemedy, KeepsAnOutputThatIsNotSafe) {
  EXPECT_EQ(without_remedy("no_motion at 4.1 s: it moved 0.1 in where 0.2 in were due; likely, in this order: a; b: c"),
            "no_motion at 4.1 s: it moved 0.1 in where 0.2 in were due");
  EXPECT_EQ(
      without_remedy("travel_limit at 4 s: 5.7 in; lower the excitation; 3 records were lost because the writer was "
                     "too slow; THE OUTPUT IS NOT CONFIRMED SAFE: switch the hydraulics off by hand"),
      "travel_limit at 4 s: 5.7 in; 3 records were lost because the writer was too slow; THE OUTPUT IS NOT "
      "CONFIRMED SAFE: switch the hydraulics off by hand");
  EXPECT_EQ(without_remedy("interrupted"), "interrupted");
}

TEST(Manifest, KeepsEveryMemberAndItsOrder) {
  const Json document = Json::parse(kWhole);
  EXPECT_EQ(to_json(manifest_from_json(document, "run.json")).dump(), document.dump());
}

TEST(Manifest, NamesTheMembersThatTheProgramsUse) {
  const Manifest manifest = manifest_from_json(Json::parse(kWhole), "run.json");
  EXPECT_EQ(manifest.outcome, acquisition::Outcome::completed);
  ASSERT_TRUE(manifest.report && manifest.recovery);
  EXPECT_EQ(manifest.report->counters.ticks, 2000U);
  EXPECT_EQ(manifest.report->counters.late, 3U);
  EXPECT_EQ(manifest.recovery->rows, 5U);
  const std::vector<ModelEntry> models = models_of(manifest);
  ASSERT_EQ(models.size(), 1U);
  EXPECT_EQ(models[0].name, "io");
  EXPECT_EQ(models[0].estimation_r2_percent, 99.5);
  EXPECT_FALSE(models[0].validation_r2_percent);
  EXPECT_EQ(models[0].reasons, std::vector<std::string>{"It is white."});
  ASSERT_TRUE(manifest.identification->recommendation);
  EXPECT_EQ(manifest.identification->recommendation->model, "io");
  EXPECT_EQ(manifest.identification->recommendation->runner_up, "");
}

TEST(Manifest, WritesANewIdentificationInTheOrderOfTheFile) {
  Manifest manifest = manifest_from_header({{"schema", "eha-journal/1"}, {"name", "sine"}});
  manifest.outcome = acquisition::Outcome::faulted;
  manifest.identification = {
      .models = {{.name = "fo", .file = "models/rejected/fo.json", .validation_r2_percent = 50.0}},
      .error = "out of memory"};
  EXPECT_EQ(to_json(manifest).dump(),
            R"({"schema":"eha-run/1","outcome":"faulted","utc_start":null,"utc_end":null,"name":"sine","host":null,)"
            R"("kernel":null,"files":[],"report":null,"identification":{"accepted":false,"models":[{"name":"fo",)"
            R"("file":"models/rejected/fo.json","accepted":false,"reasons":[],"validation_r2_percent":50.0}],)"
            R"("error":"out of memory"}})");
}

TEST(Manifest, IsInProgressUntilItHasAnOutcome) {
  EXPECT_EQ(outcome_text(manifest_from_header(Json::object())), "in_progress");
  EXPECT_FALSE(manifest_from_json(to_json(manifest_from_header(Json::object())), "run.json").outcome);
}

TEST(Manifest, SaysWhichMemberIsWrong) {
  const auto fault_of = [](const std::string& text) -> std::string {
    try {
      static_cast<void>(manifest_from_json(Json::parse(text, nullptr, false), "run.json"));
    } catch (const DataError& error) {
      return error.what();
    }
    return "no fault";
  };
  const std::string head = R"({"schema": "eha-run/1", "outcome": "completed")";
  EXPECT_EQ(fault_of("no json"), "run.json: not the manifest of a run (schema eha-run/1)");
  EXPECT_EQ(fault_of(R"({"schema": "eha-run/2"})"), "run.json: not the manifest of a run (schema eha-run/1)");
  EXPECT_EQ(fault_of(R"({"schema": "eha-run/1"})"), "run.json: outcome: expected a text");
  EXPECT_EQ(fault_of(R"({"schema": "eha-run/1", "outcome": "lost"})"), "run.json: \"lost\" is no outcome of a run");
  EXPECT_EQ(fault_of(head + R"(, "files": [{"path": "a"}]})"),
            "run.json: files: expected a path and a sha256 for each");
  EXPECT_EQ(fault_of(head + R"(, "identification": {"models": [{"accepted": "yes"}]}})"),
            "run.json: identification: models: accepted: expected true or false");
  EXPECT_EQ(fault_of(head + R"(, "report": {"counters": {"late": "many"}}})"),
            "run.json: report: counters: late: expected a number");
}

}  // namespace
}  // namespace eha::record
