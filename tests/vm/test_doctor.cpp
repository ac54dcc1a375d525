// SPDX-License-Identifier: GPL-3.0-or-later
// `eha doctor` with a real device file: its findings and exit codes, and that it moves nothing.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "board.hpp"
#include "eha_run.hpp"
#include "process.hpp"

namespace eha::test {
namespace {

struct Examined {
  int exit_code;
  std::map<std::string, std::string> levels;  ///< of each line
  std::string output;
  [[nodiscard]] std::string level(const std::string& name) const {
    return levels.count(name) == 1 ? levels.at(name) : "no line";
  }
};

Examined examine(const std::string& rig_file) {
  Process doctor({"eha", "doctor", "--rig", rig_file, "--json"});
  Examined examined{doctor.wait(), {}, doctor.output()};
  const auto document = nlohmann::json::parse(examined.output, nullptr, false);
  if (document.is_discarded()) return examined;
  for (const auto& check : document.at("checks")) examined.levels[check.at("name")] = check.at("level");
  return examined;
}

TEST(Doctor, FindsTheShippedRigFilesCardFitAndMovesNothing) {
  const Board board("pci1716_card");
  const std::size_t changes = read_wire_changes().size();
  const Examined examined = examine(pci1716_rig());
  EXPECT_EQ(examined.exit_code, 0) << examined.output;
  for (const char* name : {"device", "board", "emergency_stop", "enable", "heartbeat"}) {
    EXPECT_EQ(examined.level(name), "ok") << name << '\n' << examined.output;
  }
  EXPECT_EQ(read_wire_changes().size(), changes);
}

TEST(Doctor, NamesAnotherCardsBoardAndEndsWithTheDevicesExitCode) {
  const Board board("comedi_test");
  const Examined examined = examine(pci1716_rig());
  EXPECT_EQ(examined.exit_code, 69) << examined.output;
  EXPECT_EQ(examined.level("device"), "ok") << examined.output;
  EXPECT_EQ(examined.level("board"), "fail") << examined.output;
  EXPECT_NE(examined.output.find("comedi_test"), std::string::npos) << examined.output;
}

TEST(Doctor, SaysWhatIsMissingWithoutACard) {
  const Examined examined = examine(pci1716_rig());
  EXPECT_EQ(examined.exit_code, 69) << examined.output;
  EXPECT_EQ(examined.level("device"), "fail") << examined.output;
  EXPECT_EQ(examined.level("card"), "fail") << examined.output;
  EXPECT_EQ(examined.level("driver"), "warn") << examined.output;
}

TEST(Doctor, WarnsOfTheSafetyLinesThatARigFileSaysItHasNot) {
  const Board board("comedi_test");
  const Examined examined = examine(kernel_board_rig());
  for (const char* name : {"emergency_stop", "enable", "heartbeat"}) {
    EXPECT_EQ(examined.level(name), "warn") << examined.output;
  }
}

TEST(Doctor, RefusesARigFileThatSaysNothingOfASafetyLine) {
  std::ifstream shipped(kPci1716Rig);
  std::string text{std::istreambuf_iterator<char>(shipped), {}};
  const auto begin = text.find("[comedi.heartbeat]");
  ASSERT_NE(begin, std::string::npos);
  text.erase(begin, text.find("\n[", begin) - begin);
  const std::string file = "/tmp/without-heartbeat.toml";
  std::ofstream(file) << text;
  const Examined examined = examine(file);
  EXPECT_EQ(examined.exit_code, 78) << examined.output;
  EXPECT_NE(examined.output.find("heartbeat"), std::string::npos) << examined.output;
}

}  // namespace
}  // namespace eha::test
