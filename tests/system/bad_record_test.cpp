// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"

namespace eha::test {
namespace {

const std::string kHeader = "time_s,voltage_V,displacement_in\n";

/// `eha fit` must refuse this text as bad data.
void expect_bad_record(const std::string& text, const std::vector<std::string>& fragments) {
  const TemporaryFolder folder;
  folder.write("r.csv", text);
  expect_refused(folder, {"fit", "r.csv", "-o", "models"}, ExitCode::bad_data, fragments);
}

/// The record with one of its rows (from 0) replaced; an empty text takes the row out.
std::string with_row(int row, const std::string& replacement) {
  std::string text = sound_record(1000);
  std::size_t begin = 0;
  for (int line = 0; line <= row; ++line) begin = text.find('\n', begin) + 1;
  const std::size_t end = text.find('\n', begin) + 1;
  return text.replace(begin, end - begin, replacement.empty() ? "" : replacement + "\n");
}

TEST(BadRecord, IsMissing) {
  const TemporaryFolder folder;
  expect_refused(folder, {"fit", "none.csv"}, ExitCode::io, {"none.csv", "No such file"});
}

TEST(BadRecord, IsAFolderWithoutARun) {
  const TemporaryFolder folder;
  expect_refused(folder, {"fit", "."}, ExitCode::bad_data, {"no run folder"});
}

TEST(BadRecord, MayNotBeRead) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read every file";
  const TemporaryFolder folder;
  ASSERT_EQ(chmod(folder.write("r.csv", sound_record(1000)).c_str(), 0), 0);
  const Ended ended = run_eha({"fit", "r.csv"}, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::permission)) << ended.err;
}

// tests/unit/importer has the other faults of files.
TEST(BadRecord, HasTextWhereANumberBelongs) {
  expect_bad_record(with_row(10, "0.10,high,0.1"), {"r.csv:12", "voltage_V", "\"high\""});
}
TEST(BadRecord, HasAGapInTime) { expect_bad_record(with_row(500, ""), {"r.csv:502", "0.02 s", "1 row missing"}); }
TEST(BadRecord, HasTenRows) { expect_bad_record(sound_record(10), {"r.csv", "10"}); }

TEST(BadRecord, HasAConstantInput) {
  std::string text = kHeader;
  for (int k = 0; k < 1000; ++k) text += fmt::format("{:.2f},1.5,{:.6f}\n", 0.01 * k, 0.001 * k);
  expect_bad_record(text, {"r.csv", "constant"});
}

TEST(BadRecord, HasAConstantOutput) {
  std::string text = kHeader;
  for (int k = 0; k < 1000; ++k) text += fmt::format("{:.2f},{},2.5\n", 0.01 * k, k % 7);
  expect_bad_record(text, {"r.csv", "constant"});
}

/// EHA_BIG_RECORD_ROWS: how many rows instead of two million, e.g. 10000000.
TEST(BigRecord, OfMillionsOfRowsIsFittedWhenItIsDecimated) {
  const char* asked = std::getenv("EHA_BIG_RECORD_ROWS");
  const int rows = asked != nullptr ? std::atoi(asked) : 1'000'000;
  const TemporaryFolder folder;
  std::ofstream file(folder.path() / "r.csv");
  file << kHeader;
  // A square wave of 20 s through a lag of 2 s, exactly.
  const double decay = std::exp(-0.001 / 2.0);
  double y = 0.0;
  std::string block;
  for (int k = 0; k < rows; ++k) {
    const int u = k / 10'000 % 2;
    fmt::format_to(std::back_inserter(block), "{:.3f},{},{:.6f}\n", 0.001 * k, u, y);
    y = decay * y + (1.0 - decay) * u;
    if (block.size() > 1'000'000) {
      file << block;
      block.clear();
    }
  }
  file << block << std::flush;
  ASSERT_TRUE(file);
  const Ended ended =
      run_eha({"fit", "r.csv", "--model", "io", "--poles", "1", "--decimate", "400", "--json"}, folder.path());
  EXPECT_EQ(ended.code, 0) << ended.err;
  const auto model = nlohmann::json::parse(ended.out).at("models").at(0);
  EXPECT_NEAR(model.at("transfer_function").at("denominator").at(1).at("coefficient").get<double>(), 0.5, 1e-4);
}

TEST(BadRecord, LeavesAnEarlierModelFileAsItWas) {
  const TemporaryFolder folder;
  folder.write("r.csv", with_row(900, "9.00,1,nan"));
  folder.write("io.json", "an earlier model");
  expect_refused(folder, {"fit", "r.csv", "--model", "io", "-o", "."}, ExitCode::bad_data, {"r.csv:902"});
}

}  // namespace
}  // namespace eha::test
