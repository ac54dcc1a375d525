// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"

namespace eha::test {
namespace {

/// A shipped file with one piece of its text replaced.
std::string altered(const std::string& file, const std::string& from, const std::string& to) {
  std::string text = content_of(source_file(file));
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error(file + " holds no \"" + from + "\"");
  return text.replace(at, from.size(), to);
}

/// Both `eha check` and `eha run` must refuse the paper's experiment altered this way.
void expect_bad_experiment(const std::string& from, const std::string& to, const std::vector<std::string>& fragments) {
  const TemporaryFolder folder;
  folder.write("e.toml", altered("config/experiments/paper.toml", from, to));
  const std::string rig = source_file("config/rigs/sim.toml");
  expect_refused(folder, {"check", "e.toml", "--rig", rig}, ExitCode::configuration, fragments);
  expect_refused(folder, {"run", "e.toml", "--local", "--fast", "--rig", rig}, ExitCode::configuration, fragments);
}

TEST(BadExperiment, HasATypo) {
  expect_bad_experiment("duration_s = 50.0", "duratoin_s = 50.0\nduration_s = 50.0",
                        {"e.toml:", "duratoin_s", "duration_s"});
}
TEST(BadExperiment, HasAWrongType) {
  expect_bad_experiment("decimation = 40", "decimation = \"many\"", {"e.toml:", "record.decimation", "\"many\""});
}
TEST(BadExperiment, HasAValueOutOfRange) {
  expect_bad_experiment("split = 0.5", "split = 1.5", {"e.toml:", "record.split", "1.5"});
}
TEST(BadExperiment, ExceedsTheRigsLimits) {
  expect_bad_experiment("offset_V = -0.1", "offset_V = -1.0", {"e.toml:", "excitation", "-5..5 V"});
}
TEST(BadExperiment, HasADecimationThatDoesNotDivide) {
  expect_bad_experiment("decimation = 40", "decimation = 37", {"e.toml:", "record.decimation", "37"});
}
TEST(BadExperiment, HasAToneAboveNyquist) {
  expect_bad_experiment("frequency_Hz = 0.65", "frequency_Hz = 650.0", {"e.toml:", "frequency_Hz", "650"});
}
TEST(BadExperiment, LastsNoTime) {
  expect_bad_experiment("duration_s = 50.0", "duration_s = 0.0", {"e.toml:", "duration_s"});
}
TEST(BadExperiment, IsNotToml) { expect_bad_experiment("[record]", "[record", {"e.toml:"}); }

TEST(BadExperiment, IsMissingAFolderEmptyOrBinary) {
  const TemporaryFolder folder;
  expect_refused(folder, {"check", "none.toml"}, ExitCode::configuration, {"none.toml"});
  expect_refused(folder, {"check", "."}, ExitCode::configuration, {"."});
  folder.write("empty.toml", "");
  expect_refused(folder, {"check", "empty.toml"}, ExitCode::configuration, {"empty.toml"});
  folder.write("binary.toml", std::string("\0\1\2\3", 4));
  expect_refused(folder, {"check", "binary.toml"}, ExitCode::configuration, {"binary.toml"});
}

TEST(BadExperiment, IsReportedWithAllItsFaultsAtOnce) {
  const TemporaryFolder folder;
  std::string text = altered("config/experiments/paper.toml", "split = 0.5", "split = 2.0");
  const std::size_t section = text.find("[identification]");
  text.replace(text.find("seed", section), 4, "sede");
  folder.write("e.toml", text);
  expect_refused(folder, {"check", "e.toml"}, ExitCode::configuration, {"record.split", "sede"}, 2);
}

TEST(BadRig, HasFaultsOfItsOwn) {
  const TemporaryFolder folder;
  folder.write("r.toml", altered("config/rigs/sim.toml", "slew_V_per_s = 20.0", "slew_V_per_s = -1.0"));
  expect_refused(folder, {"check", "r.toml"}, ExitCode::configuration, {"r.toml:", "limits.slew_V_per_s", "-1"});
}

TEST(BadRig, DrivesACardButAnyoneMayWriteIt) {
  const TemporaryFolder folder;
  const auto rig = folder.write("r.toml", content_of(source_file("config/rigs/pci1716.toml")));
  std::filesystem::permissions(rig, std::filesystem::perms::all);
  expect_refused(folder, {"run", source_file("config/experiments/paper.toml"), "--local", "--rig", "r.toml", "--yes"},
                 ExitCode::permission, {"r.toml", "root"});
}

TEST(BadRig, CannotBeHurried) {
  const TemporaryFolder folder;
  folder.write("r.toml", content_of(source_file("config/rigs/pci1716.toml")));
  expect_refused(folder, {"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", "r.toml"},
                 ExitCode::usage, {"--fast"});
}

}  // namespace
}  // namespace eha::test
