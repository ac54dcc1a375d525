// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

TEST(Command, WithoutTheServiceRunsOnlyLocally) {
  const TemporaryFolder folder;
  expect_refused(folder, {"run", source_file("config/experiments/paper.toml")}, ExitCode::device_unavailable,
                 {"ehad is not running", "--local"});
  if (std::filesystem::exists("/etc/ehad/rig.toml")) GTEST_SKIP() << "this machine has a rig";
  const Ended simulated = run_eha({"run", source_file("config/experiments/paper.toml")}, folder.path());
  EXPECT_LT(simulated.err.find("paper.toml --local` plays it on the simulated rig"),
            simulated.err.find("emergency stop"))
      << simulated.err;
}

TEST(Command, WithoutStandardStreamsWritesItsMessagesIntoNoFile) {
  const TemporaryFolder folder;
  const std::string said =
      output_of_shell(fmt::format("cd {} && {} goto 3in --local --fast --rig {} <&- >&- 2>&-; echo \"ended: $?\"",
                                  folder.path().string(), EHA_PROGRAM, source_file("config/rigs/sim.toml").string()));
  EXPECT_EQ(said, "ended: 0\n");
  const std::filesystem::path run = std::filesystem::directory_iterator(folder.path() / "runs")->path();
  EXPECT_EQ(json::parse(content_of(run / "run.json")).at("outcome"), "completed");
}

TEST(Command, ExportsOverNoRecordAndValidatesOnAnotherOneThanTheModelsOwn) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_file("config/records/bench.csv"), folder.path() / "bench.csv");
  const std::string record = content_of(folder.path() / "bench.csv");
  ASSERT_EQ(run_eha({"fit", "bench.csv", "--model", "integrator_lag_valve", "-o", "models"}, folder.path()).code, 0);
  expect_refused(folder, {"export", "models/integrator_lag_valve.json", "--format", "octave", "-o", "bench.csv"},
                 ExitCode::usage, {"a file of data is there"});
  EXPECT_EQ(content_of(folder.path() / "bench.csv"), record);
  const Ended own = run_eha({"validate", "models/integrator_lag_valve.json", "bench.csv"}, folder.path());
  EXPECT_NE(own.err.find("was estimated on this record, which proves nothing of it"), std::string::npos) << own.err;
  std::filesystem::copy_file(folder.path() / "bench.csv", folder.path() / "other.csv");
  const Ended other = run_eha({"validate", "models/integrator_lag_valve.json", "other.csv"}, folder.path());
  EXPECT_EQ(other.err.find("proves nothing"), std::string::npos) << other.err;
}

TEST(Command, ThatIsUnknownIsAUsageError) {
  const TemporaryFolder folder;
  expect_refused(folder, {"frobnicate"}, ExitCode::usage, {"frobnicate", "--help"});
  expect_refused(folder, {}, ExitCode::usage, {"--help"});
  expect_refused(folder, {"fit", "r.csv", "--poles", "none"}, ExitCode::usage, {"--poles"});
}

TEST(Command, PrintsHelpAndVersion) {
  const TemporaryFolder folder;
  const Ended help = run_eha({"--help"}, folder.path());
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.out.find("Exit codes"), std::string::npos);
  const Ended version = run_eha({"--version"}, folder.path());
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out.rfind("eha ", 0), 0U);
}

TEST(Command, ReportsAFullStandardOutput) {
  const TemporaryFolder folder;
  const Ended ended = run_eha({"--help"}, folder.path(), "/dev/full");
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::io));
  EXPECT_NE(ended.err.find("No space left"), std::string::npos) << ended.err;
}

TEST(Simulate, GivesTheStepResponseOfALag) {
  const TemporaryFolder folder;
  folder.write("m.json", R"({"transfer_function": {"numerator": [{"coefficient": 2, "order": 0}],
                             "denominator": [{"coefficient": 0.5, "order": 1}, {"coefficient": 1, "order": 0}]},
                             "input_bias": 0.25, "initial_output": 3})");
  std::string input = "time_s,note,voltage_V\n";
  for (int k = 0; k < 100; ++k) input += fmt::format("{:.2f},x,1\n", 5.0 + 0.01 * k);
  folder.write("u.csv", input);
  const Ended ended = run_eha({"simulate", "m.json", "u.csv"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  std::istringstream lines(ended.out);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "time_s,output_in");
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(std::getline(lines, line)) << k;
    const std::size_t comma = line.find(',');
    EXPECT_NEAR(std::stod(line.substr(0, comma)), 5.0 + 0.01 * k, 1e-12);
    // y = 3 + 2 (1 + 0.25) (1 - exp(-t / 0.5))
    EXPECT_NEAR(std::stod(line.substr(comma + 1)), 3.0 + 2.5 * (1.0 - std::exp(-0.01 * k / 0.5)), 1e-7) << k;
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(Simulate, WritesAFileOrOneJsonDocument) {
  const TemporaryFolder folder;
  folder.write("m.json", R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
                             "denominator": [{"coefficient": 1, "order": 1}, {"coefficient": 1, "order": 0}]}})");
  folder.write("u.csv", "time_s,voltage_V\n0,1\n0.5,1\n1,1\n");
  const Ended file = run_eha({"simulate", "m.json", "u.csv", "-o", "y.csv"}, folder.path());
  EXPECT_EQ(file.code, 0) << file.err;
  const std::string text = content_of(folder.path() / "y.csv");
  EXPECT_EQ(text.rfind("time_s,output_in\n0,", 0), 0U) << text;
  EXPECT_NEAR(std::stod(text.substr(text.find("\n1,") + 3)), 1.0 - std::exp(-1.0), 1e-7) << text;
  const Ended document = run_eha({"simulate", "m.json", "u.csv", "--json", "--method", "cq2"}, folder.path());
  EXPECT_EQ(json::parse(document.out).at("output").size(), 3U);
}

TEST(Tune, SaysOfARunWithoutAModelHowItEnded) {
  const TemporaryFolder folder;
  folder.write("trip.toml",
               "schema = 1\nname = \"trip\"\nduration_s = 20.0\n[excitation]\nkind = \"step\"\namplitude_V = 4.0\n"
               "hold_s = 0.5\n");
  const Ended tripped = run_eha({"run", "trip.toml", "--local", "--fast", "--accept-travel-risk", "--rig",
                                 source_file("config/rigs/sim.toml"), "--output", "r"},
                                folder.path());
  ASSERT_EQ(tripped.code, static_cast<int>(ExitCode::safety_trip)) << tripped.err;
  const std::string run = "r/" + fs::directory_iterator(folder.path() / "r")->path().filename().string();
  const Ended refused = run_eha({"tune", run}, folder.path());
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::bad_data));
  for (const std::string& part : {std::string("the run did not end as planned (travel_limit) and has no model"),
                                  "`eha runs show " + run + "` says how", "`eha fit " + run + "` fits it"}) {
    EXPECT_NE(refused.err.find(part), std::string::npos) << part << refused.err;
  }
}

TEST(Check, AcceptsEveryShippedFile) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/pci1716.toml"));
  folder.write("sample.toml", rig);
  const std::size_t sample = rig.find("sample = true");
  ASSERT_NE(sample, std::string::npos);
  folder.write("rig.toml", rig.erase(sample, rig.find('\n', sample) - sample));
  for (const std::string& file : {source_file("config/rigs/sim.toml").string(), std::string("rig.toml"),
                                  source_file("config/experiments/paper.toml").string()}) {
    const Ended ended = run_eha({"check", file}, folder.path());
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
  }
  expect_refused(folder, {"check", "sample.toml"}, ExitCode::configuration, {"sample = true", "/etc/ehad"});
}

TEST(Design, WritesTheTableThatItDescribes) {
  const TemporaryFolder folder;
  folder.write("e.toml", R"(schema = 1
name = "two_tones"
duration_s = 20.0
[excitation]
kind = "multisine"
offset_V = 0.5
tones = [
  { frequency_Hz = 0.05, amplitude_V = 2.0, phase_rad = 0.3 },
  { frequency_Hz = 0.2, amplitude_V = 1.0, phase_rad = 1.9 },
]
[[model]]
name = "io"
structure = "io"
)");
  const Ended ended = run_eha(
      {"design", "e.toml", "-o", "u.csv", "--json", "--rig", source_file("config/rigs/sim.toml")}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("samples"), 20000);
  EXPECT_EQ(document.at("lines_Hz"), json::parse("[0.05, 0.2]"));
  // Over whole periods the tones' mean squares add up.
  EXPECT_NEAR(document.at("rms_V").get<double>(), std::sqrt(0.25 + 2.0 + 0.5), 1e-9);
  const std::string table = content_of(folder.path() / "u.csv");
  EXPECT_EQ(table.rfind("time_s,voltage_V\n0,", 0), 0U);
  EXPECT_NEAR(std::stod(table.substr(table.find("\n0,") + 3)), 0.5 + 2.0 * std::cos(0.3) + std::cos(1.9), 1e-12);
  EXPECT_EQ(lines_beginning_with(table, "19.999,"), 1U);
}

TEST(RunsList, SaysThatThereAreNone) {
  const TemporaryFolder folder;
  const Ended ended = run_eha({"runs", "list"}, folder.path());
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find("no runs in runs"), std::string::npos);
}

TEST(RunsList, RefusesAFolderThatIsNotThere) {
  const TemporaryFolder folder;
  expect_refused(folder, {"runs", "list", "nosuch"}, ExitCode::io, {"nosuch: no such folder"});
}

TEST(Fit, MixesNoModelsOfTwoRecordsInOneFolder) {
  const TemporaryFolder folder;
  std::string record = "time_s,voltage_V,displacement_in\n";
  double y = 0.0;
  for (int k = 0; k < 400; ++k) {
    const double u = k % 60 < 30 ? 1.0 : -1.0;
    record += fmt::format("{:.2f},{},{:.6f}\n", 0.05 * k, u, y + 1e-4 * (k * 7919 % 13));
    y += 0.05 * (2.0 * u - y);
  }
  folder.write("first.csv", record);
  folder.write("second.csv", record);
  const std::vector<std::string> options{"--model", "io", "--poles", "1", "-o", "models"};
  const auto fit = [&](const std::string& file) {
    std::vector<std::string> words{"fit", file};
    words.insert(words.end(), options.begin(), options.end());
    return run_eha(words, folder.path());
  };
  ASSERT_EQ(fit("first.csv").code, 0) << fit("first.csv").err;
  EXPECT_EQ(fit("first.csv").code, 0) << "the same record again";
  const Ended refused = fit("second.csv");
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(refused.err.find("first.csv"), std::string::npos) << refused.err;
}

TEST(Fit, OfANamedModelThatFailsGoesOnWithTheLadder) {
  const TemporaryFolder folder;
  const std::string record = source_file("config/records/bench.csv");
  const Ended fit = run_eha({"fit", record, "--model", "friction", "--seed", "2"}, folder.path());
  EXPECT_EQ(fit.code, static_cast<int>(ExitCode::model_rejected)) << fit.err;
  EXPECT_NE(fit.out.find("Next: eha fit " + record + " --seed 2\n"), std::string::npos) << fit.out;
}

TEST(Fit, RefusesAnInitialStateInThePapersProcedure) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(400));
  expect_refused(folder, {"fit", "r.csv", "--procedure", "paper", "--initial-state", "estimated"}, ExitCode::usage,
                 {"--initial-state estimated", "paper"});
}

TEST(ClosedPipe, EndsACommandWithoutAWord) {
  const TemporaryFolder folder;
  const std::string eha = EHA_PROGRAM;
  const auto ended = [&](const std::string& command) {
    return output_of_shell("cd '" + folder.path().string() + "' && { sleep 0.3; " + eha + " " + command +
                           " 2>err; echo $? >code; } | true; cat code err");
  };
  EXPECT_EQ(ended("doctor --help"), std::to_string(static_cast<int>(ExitCode::io)) + "\n");
}

TEST(RunsShow, RefusesWhatIsNoRun) {
  const TemporaryFolder folder;
  expect_refused(folder, {"runs", "show", "none"}, ExitCode::io, {"none"});
}

TEST(RunsShow, SaysOfARunThatWasKilledAfterASlipWhatToDo) {
  const TemporaryFolder folder;
  folder.write("run.json",
               R"({"schema": "eha-run/1", "outcome": "recovered", "name": "sine", "fault_of_rows": "sensor_slip",
                   "recovery": {"utc": "", "rows": 8138, "torn_bytes": 0, "end": null}})");
  const Ended show = run_eha({"runs", "show", folder.path().string()}, folder.path());
  ASSERT_EQ(show.code, 0) << show.err;
  EXPECT_NE(show.out.find("sensor_slip by its rows: its process ended before the report was written; the rod may stand "
                          "elsewhere than its sensor shows it"),
            std::string::npos)
      << show.out;
  EXPECT_NE(show.out.find("`eha arm --ruler LENGTH`"), std::string::npos) << show.out;
  EXPECT_NE(show.out.find("Next: eha read"), std::string::npos) << show.out;
}

}  // namespace
}  // namespace eha::test
