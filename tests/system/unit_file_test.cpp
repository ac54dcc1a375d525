// SPDX-License-Identifier: GPL-3.0-or-later
// The units in systemd/, checked by systemd's own tools.
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <string>

#include "tests/system/program.hpp"

namespace eha::test {
namespace {

constexpr const char* kServices[] = {"ehad.service", "eha-web.service"};
constexpr const char* kUnits[] = {"ehad.service", "eha-web.service", "eha-web.socket"};

TEST(UnitFile, IsExposedByAtMostOneAndAHalfOfTen) {
  if (output_of_shell("command -v systemd-analyze").empty()) GTEST_SKIP() << "systemd-analyze is not installed";
  for (const std::string name : kServices) {
    const std::string unit = source_file("systemd/" + name).string();
    const std::string analysis =
        output_of_shell("systemd-analyze security --no-pager --offline=true '" + unit + "' 2>&1");
    std::smatch match;
    ASSERT_TRUE(std::regex_search(analysis, match, std::regex("Overall exposure level for " + name + ": ([0-9.]+)")))
        << analysis;
    EXPECT_LE(std::strtod(match[1].str().c_str(), nullptr), 1.5) << analysis;
  }
}

TEST(UnitFile, HasNoWordThatSystemdDoesNotKnow) {
  if (output_of_shell("command -v systemd-analyze").empty()) GTEST_SKIP() << "systemd-analyze is not installed";
  for (const std::string name : kUnits) {
    const std::string unit = source_file("systemd/" + name).string();
    const std::string analysis = output_of_shell("systemd-analyze verify --man=no '" + unit + "' 2>&1");
    // The programs need not be installed where the tests run.
    const std::regex not_installed(
        "eha[a-z-]*.service: Command /usr/s?bin/(ehad|eha-safe|eha-web) is not executable: [^\n]*\n");
    EXPECT_EQ(std::regex_replace(analysis, not_installed, ""), "");
  }
}

}  // namespace
}  // namespace eha::test
