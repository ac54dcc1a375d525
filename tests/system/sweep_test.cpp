// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

const std::vector<std::string> kSweep = {"fit",       "r.csv",   "--sweep", "commensurate", "--sweep-orders",
                                         "0.8:1:0.1", "--poles", "1"};

std::vector<std::string> sweep_into(const std::string& folder) {
  std::vector<std::string> arguments = kSweep;
  arguments.insert(arguments.end(), {"-o", folder});
  return arguments;
}

TEST(Sweep, FindsTheOrderOneOfALagAndWritesItsTable) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(400));
  std::vector<std::string> arguments = sweep_into("deep/out");
  arguments.emplace_back("--json");
  const Ended ended = run_eha(arguments, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const auto document = nlohmann::json::parse(ended.out);
  ASSERT_EQ(document.at("points").size(), 3U);
  double best_q = 0.0;
  double best_fit = -1e300;
  for (const auto& point : document.at("points")) {
    const double fit = point.at("model").at("estimation").at("fit_percent");
    if (fit > best_fit) {
      best_fit = fit;
      best_q = point.at("q");
    }
  }
  EXPECT_NEAR(best_q, 1.0, 1e-12);
  const std::string table = content_of(folder.path() / "deep/out/sweep_commensurate.csv");
  EXPECT_EQ(
      lines_beginning_with(table, "0.8,") + lines_beginning_with(table, "0.9,") + lines_beginning_with(table, "1,"), 3U)
      << table;
}

TEST(Sweep, SaysWhyItsFolderCannotBeMade) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(400));
  folder.write("taken", "a file");
  expect_refused(folder, sweep_into("taken/out"), ExitCode::io, {"taken/out", "create"});
}

TEST(Sweep, RefusesOrdersThatMakeNoSense) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(400));
  for (const char* orders : {"1:0.5:0.1", "0.5:1:0.0001"}) {
    expect_refused(folder, {"fit", "r.csv", "--sweep", "commensurate", "--sweep-orders", orders}, ExitCode::usage,
                   {"--sweep-orders", orders});
  }
}

}  // namespace
}  // namespace eha::test
