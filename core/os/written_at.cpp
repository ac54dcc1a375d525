// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/written_at.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <system_error>

namespace eha::os {

std::string written_at(const std::vector<std::filesystem::path>& files) {
  std::optional<std::chrono::sys_seconds> newest;
  for (const std::filesystem::path& file : files) {
    std::error_code unknown;
    const std::filesystem::file_time_type time = std::filesystem::last_write_time(file, unknown);
    if (unknown) continue;
    const auto at = std::chrono::floor<std::chrono::seconds>(std::chrono::file_clock::to_sys(time));
    newest = newest ? std::max(*newest, at) : at;
  }
  if (!newest) return {};
  const std::time_t seconds = newest->time_since_epoch().count();
  std::tm utc{};
  if (gmtime_r(&seconds, &utc) == nullptr) return {};
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                     utc.tm_min);
}

}  // namespace eha::os
