// SPDX-License-Identifier: GPL-3.0-or-later
// The commands that `eha` names for people to copy, with files whose names are commands of the shell.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

constexpr const char* kModel = R"({"name": "io", "transfer_function": {"numerator": [{"coefficient": 0.13, "order": 0}],
  "denominator": [{"coefficient": 0.013, "order": 2}, {"coefficient": 1, "order": 1}, {"coefficient": 0.0028, "order": 0}]},
  "initial_output": 2.9})";

/// The commands behind "Next: " and between backquotes.
std::vector<std::string> commands_of(const std::string& text) {
  std::vector<std::string> commands;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("Next: ")) commands.push_back(line.substr(6));
    const std::size_t from = line.find("`eha ");
    if (from != std::string::npos) commands.push_back(line.substr(from + 1, line.rfind('`') - from - 1));
  }
  return commands;
}

TEST(CopiedCommands, RunNothingThatTheNameOfAFileHolds) {
  const TemporaryFolder folder;
  std::string record = "time_s,voltage_V,displacement_in\n";
  for (int k = 0; k < 400; ++k) record += fmt::format("{:.2f},{:.1f},{:.3f}\n", 0.04 * k, k % 9 - 4.0, 2.9 + 0.001 * k);
  const std::vector<std::string> names{"$(touch pwned)", "`touch pwned`", "a;touch pwned;", "a b", "a'b", "a\"b"};
  std::size_t seen = 0;
  for (const std::string& name : names) {
    const std::string csv = name + ".csv";
    const std::string model = name + ".json";
    folder.write(csv, record);
    folder.write(model, kModel);
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"replay", csv},
                                               {"import", csv, "-o", name + "-2.csv"},
                                               {"simulate", model, csv, "-o", name + "-3.csv"},
                                               {"report", model, "-o", name + ".html"},
                                               {"doctor", "--rig", csv}}) {
      const Ended ended = run_eha(words, folder.path());
      for (const std::string& command : commands_of(ended.out + ended.err)) {
        if (command.find(name.substr(0, 1)) == std::string::npos) continue;
        ++seen;
        folder.write("command.sh", "eha() { :; }\nxdg-open() { :; }\nsudo() { :; }\n" + command + "\n");
        const std::string errors =
            output_of_shell("cd '" + folder.path().string() + "' && bash ./command.sh 2>&1 >/dev/null");
        EXPECT_EQ(errors, "") << command;
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "pwned")) << command;
        std::filesystem::remove(folder.path() / "pwned");
      }
    }
  }
  EXPECT_GE(seen, 3 * names.size());
}

TEST(CopiedCommands, NameFilesThatAreThereOrSayWhatToReplace) {
  const TemporaryFolder folder;
  const auto record = [](int seed) {
    std::string text = "time_s,voltage_V,displacement_in\n";
    double y = 0.0;
    for (int k = 0; k < 1200; ++k) {
      const double u = (k / 25 + seed) % 3 == 0 ? 1.0 : (k / 40) % 2 == 0 ? -0.5 : 0.2;
      text += fmt::format("{:.2f},{:.2f},{:.5f}\n", 0.04 * k, u, y + 0.001 * ((k * 7919 + seed) % 13 - 6));
      y += 0.06 * (1.3 * u - y);
    }
    return text;
  };
  folder.write("a b.csv", record(0));
  folder.write("other.csv", record(1));
  const auto next_of = [](const Ended& ended) {
    const std::size_t at = ended.out.rfind("Next: ");
    return at == std::string::npos ? ended.out + ended.err : ended.out.substr(at + 6);
  };
  ASSERT_EQ(run_eha({"fit", "a b.csv", "--model", "io1", "-o", "models"}, folder.path()).code, 0);
  const Ended validated = run_eha({"validate", "models/io1.json", "other.csv"}, folder.path());
  EXPECT_EQ(next_of(validated), "eha simulate models/io1.json other.csv -o output.csv\n") << validated.out;
  const Ended simulated = run_eha({"simulate", "models/io1.json", "other.csv", "-o", "output.csv"}, folder.path());
  EXPECT_EQ(next_of(simulated), "eha validate models/io1.json other.csv\n");
  // Its own record proves nothing.
  const Ended own = run_eha({"simulate", "models/io1.json", "a b.csv", "-o", "own.csv"}, folder.path());
  EXPECT_EQ(next_of(own),
            "eha validate models/io1.json RECORD.csv\n"
            "      RECORD.csv: a record of the same plant that the model has not seen\n");
  const Ended exported = run_eha({"export", "models/io1.json", "--format", "octave", "-o", "plant.m"}, folder.path());
  const std::string next = next_of(exported);
  EXPECT_TRUE(next.starts_with("eha simulate models/io1.json 'a b.csv' ")) << next;
  EXPECT_TRUE(next.ends_with(" -o output-2.csv\n")) << next << "output.csv is there";
}

/// A record of a lag that answers 1.3 times the input or `gain`, with one row left out where `has_gap`.
std::string record_of_lag(double gain, bool has_gap) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  double y = 0.0;
  for (int k = 0; k < 1200; ++k) {
    const double u = (k / 25) % 3 == 0 ? 1.0 : (k / 40) % 2 == 0 ? -0.5 : 0.2;
    if (!has_gap || k != 700) {
      text += fmt::format("{:.2f},{:.2f},{:.5f}\n", 0.04 * k, u, y + 0.001 * ((k * 7919) % 13 - 6));
    }
    y += 0.06 * (gain * u - y);
  }
  return text;
}

std::string next_of(const Ended& ended) {
  const std::size_t at = ended.out.rfind("Next: ");
  return at == std::string::npos ? ended.out + ended.err : ended.out.substr(at + 6);
}

TEST(CopiedCommands, LeaveTheModelsThatAreThere) {
  const TemporaryFolder folder;
  folder.write("a.csv", record_of_lag(1.3, false));
  const auto next = [&](const std::vector<std::string>& words) { return next_of(run_eha(words, folder.path())); };
  EXPECT_EQ(next({"fit", "a.csv", "--model", "io1"}), "eha fit a.csv --model io1 -o models\n");
  EXPECT_EQ(run_eha({"fit", "a.csv", "--model", "io1", "-o", "models"}, folder.path()).code, 0);
  EXPECT_EQ(next({"fit", "a.csv", "--model", "io1"}), "eha fit a.csv --model io1 -o models-2\n");
  EXPECT_EQ(next({"plot", "a.csv"}), "eha fit a.csv -o models-2\n");
  EXPECT_EQ(next({"export", "a.csv", "--format", "csv", "-o", "b.csv"}), "eha fit b.csv -o models-2\n");
  // A model that is rejected leads to the ladder, which would replace its file.
  for (const std::vector<std::string>& into : {std::vector<std::string>{"-o", "mine"}, {"-omine"}, {"-o", "mine/"}}) {
    std::vector<std::string> words{"fit", "a.csv", "--model", "integrator_lag"};
    words.insert(words.end(), into.begin(), into.end());
    EXPECT_EQ(next(words), "eha fit a.csv -o mine-2\n");
  }
  // A folder without a name of its own has none to number.
  for (const char* here : {".", "./", "mine/.."}) {
    EXPECT_EQ(next({"fit", "a.csv", "--model", "integrator_lag", "-o", here}), "eha fit a.csv -o models-2\n") << here;
  }
  const Ended other = run_eha({"fit", "b.csv", "-o", "models"}, folder.path());
  EXPECT_NE(other.err.find("for instance -o models-b\n"), std::string::npos) << other.err;
  folder.write("models-b", "");
  const Ended again = run_eha({"fit", "b.csv", "-o", "models"}, folder.path());
  EXPECT_NE(again.err.find("for instance -o models-b-2\n"), std::string::npos) << again.err;
}

TEST(CopiedCommands, CompareRecordsAsTheyWereRead) {
  const TemporaryFolder folder;
  folder.write("gap.csv", record_of_lag(1.3, true));
  folder.write("other.csv", record_of_lag(1.7, true));
  ASSERT_EQ(run_eha({"fit", "gap.csv", "--resample", "--model", "io1", "-o", "models"}, folder.path()).code, 0);
  const std::string next = next_of(run_eha({"validate", "models/io1.json", "other.csv", "--resample"}, folder.path()));
  EXPECT_EQ(next,
            "eha import gap.csv --resample -o gap-record.csv && eha import other.csv --resample -o other-record.csv && "
            "eha compare gap-record.csv other-record.csv -o comparison.html\n");
  const std::string eha = EHA_PROGRAM;
  const std::string said = output_of_shell("cd '" + folder.path().string() + "' && eha() { '" + eha +
                                           "' \"$@\"; } && " + next.substr(0, next.find('\n')) + " 2>&1");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "comparison.html")) << said;
  EXPECT_NE(next_of(run_eha({"validate", "models/io1.json", "other.csv", "--resample"}, folder.path()))
                .find("-o comparison-2.html"),
            std::string::npos);
}

TEST(CopiedCommands, GiveTwoCopiesTwoNames) {
  const TemporaryFolder folder;
  folder.write("r.csv", record_of_lag(1.3, true));
  std::filesystem::create_directory(folder.path() / "b");
  folder.write("b/r.csv", record_of_lag(1.7, true));
  folder.write("r-record.csv", "");
  ASSERT_EQ(run_eha({"fit", "r.csv", "--resample", "--model", "io1", "-o", "models"}, folder.path()).code, 0);
  const std::string next = next_of(run_eha({"validate", "models/io1.json", "b/r.csv", "--resample"}, folder.path()));
  EXPECT_EQ(next,
            "eha import r.csv --resample -o r-record-2.csv && eha import b/r.csv --resample -o r-record-3.csv && "
            "eha compare r-record-2.csv r-record-3.csv -o comparison.html\n");
}

TEST(CheckedRig, SaysWhatItsLimitsLeaveUnwatched) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::string check = "frozen_sensor_s = 0.5 ";
  rig.replace(rig.find(check), check.size(), "frozen_sensor_s = 0 ");
  folder.write("rig.toml", rig);
  const Ended ended = run_eha({"check", "rig.toml"}, folder.path());
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.err.find("warning: limits.frozen_sensor_s is off"), std::string::npos) << ended.err;
}

TEST(CopiedCommands, TakeNoCommandFromAModelFile) {
  const TemporaryFolder folder;
  folder.write("gap.csv", record_of_lag(1.3, true));
  folder.write("other.csv", record_of_lag(1.7, false));
  ASSERT_EQ(run_eha({"fit", "gap.csv", "--resample", "--model", "io1", "-o", "models"}, folder.path()).code, 0);
  std::string model = content_of(folder.path() / "models/io1.json");
  const std::string command = "eha fit gap.csv --resample";
  ASSERT_NE(model.find(command), std::string::npos) << model;
  model.replace(model.find(command), command.size(), "eha fit gap.csv;pwn --decimal $(pwn) --resample;pwn");
  folder.write("forged.json", model);
  const std::string next = next_of(run_eha({"validate", "forged.json", "other.csv"}, folder.path()));
  EXPECT_TRUE(next.starts_with("eha import gap.csv --decimal '$(pwn)' -o gap-record.csv && eha compare ")) << next;
}

}  // namespace
}  // namespace eha::test
