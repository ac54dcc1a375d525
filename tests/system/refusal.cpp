// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/refusal.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "tests/system/program.hpp"

namespace eha::test {
namespace {

/// Every file below a folder with its content.
std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    files[entry.path().string()] = entry.is_regular_file() ? content_of(entry.path()) : "";
  }
  return files;
}

}  // namespace

void expect_refused(const TemporaryFolder& folder, const std::vector<std::string>& arguments, ExitCode code,
                    const std::vector<std::string>& fragments, std::size_t faults) {
  SCOPED_TRACE(fmt::format("eha {}", fmt::join(arguments, " ")));
  const auto before = contents(folder.path());
  const Ended ended = run_eha(arguments, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(code)) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(lines_beginning_with(ended.err, "eha: error: "), faults) << ended.err;
  for (const std::string& fragment : fragments) {
    EXPECT_NE(ended.err.find(fragment), std::string::npos) << "no \"" << fragment << "\" in\n" << ended.err;
  }
  EXPECT_EQ(contents(folder.path()), before) << "something was left behind";
}

std::string sound_record(int rows) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  double output = 0.0;
  for (int k = 0; k < rows; ++k) {
    const double input = (k / 37) % 2 == 0 ? 1.0 : -1.0;
    text += fmt::format("{:.2f},{},{:.9f}\n", 0.01 * k, input, output);
    output += 0.05 * (0.8 * input - output);
  }
  return text;
}

}  // namespace eha::test
