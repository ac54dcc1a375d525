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

}  // namespace
}  // namespace eha::test
