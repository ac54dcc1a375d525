// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace eha::test {

/// Reference data that may not be copied into the project are outside it: in $EHA_SHARED, or ../shared of the source
/// tree. Tests that need them skip when they are absent, saying so.
inline std::filesystem::path shared(const std::string& name) {
  const char* set = std::getenv("EHA_SHARED");
  const std::filesystem::path folder = set != nullptr ? set : std::filesystem::path(EHA_SOURCE_DIR) / ".." / "shared";
  return folder / name;
}

}  // namespace eha::test

#define EHA_REQUIRE_SHARED(path)                                                                         \
  if (!std::filesystem::exists(path)) {                                                                  \
    GTEST_SKIP() << "reference data absent: " << (path) << "; set EHA_SHARED to the folder they are in"; \
  }
