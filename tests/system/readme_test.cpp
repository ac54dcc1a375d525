// SPDX-License-Identifier: GPL-3.0-or-later
// The commands of README's first ten minutes, as they stand there.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

/// The indented lines that follow the line that begins with `above`, up to the next text.
std::string commands_below(const std::string& above) {
  std::ifstream readme(EHA_SOURCE_DIR "/README.md");
  std::string line;
  while (std::getline(readme, line) && !line.starts_with(above)) continue;
  std::string commands;
  while (std::getline(readme, line) && (line.empty() || line.starts_with("    "))) commands += line + "\n";
  return commands;
}

/// What the commands print in a folder that has the package's files, and "every command ran" behind the last one.
std::string said_by(const std::string& commands, const TemporaryFolder& folder) {
  // What the package has below /usr/share/ehad.
  const std::filesystem::path config = std::filesystem::path(EHA_SOURCE_DIR) / "config";
  std::filesystem::create_directory(folder.path() / "config");
  for (const char* part : {"rigs", "experiments", "records"}) {
    std::filesystem::copy(config / part, folder.path() / "config" / part, std::filesystem::copy_options::recursive);
  }
  const std::string bin = std::filesystem::path(EHA_PROGRAM).parent_path().string();
  folder.write("commands.sh", "set -eu\nexport PATH='" + bin + "':$PATH\n" + commands + "echo every command ran\n");
  return output_of_shell("cd '" + folder.path().string() + "' && bash ./commands.sh 2>&1");
}

TEST(Readme, RunsFromTopToBottomInTheFirstTenMinutes) {
  const std::string commands = commands_below("Then, from top to bottom");
  ASSERT_NE(commands.find("eha fit "), std::string::npos);
  const TemporaryFolder folder;
  const std::string said = said_by(commands, folder);
  EXPECT_TRUE(said.ends_with("every command ran\n")) << said;
  for (const char* file : {"report.html", "plant.m", "axis.toml", "runs/latest/report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;
  }
}

TEST(Readme, CommissionsTheRigThatItCopies) {
  const std::string commands = commands_below("## From a model to a controller");
  ASSERT_NE(commands.find("eha commission "), std::string::npos);
  const TemporaryFolder folder;
  const std::string said = said_by(commands, folder);
  EXPECT_TRUE(said.ends_with("every command ran\n")) << said;
  EXPECT_NE(said.find("keeps the controller's promise: the trial measured it"), std::string::npos) << said;
  // Called a guess, it is so until the trial.
  const std::size_t guess = said.find("is a guess");
  if (guess != std::string::npos) {
    EXPECT_EQ(said.find("is a guess until a trial has measured it"), guess) << said;
  }
  for (const char* file : {"commission/rig_before.toml", "commission/axis.toml", "commission/report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;
  }
}

}  // namespace
}  // namespace eha::test
