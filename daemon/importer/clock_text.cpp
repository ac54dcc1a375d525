// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/clock_text.hpp"

#include <ctime>
#include <string>

namespace eha::importer {
namespace {

constexpr std::size_t kLongest = 40;

/// The digits after the seconds, "" or ".25" or ",25Z".
std::optional<double> fraction_of(std::string_view rest) {
  if (rest.empty() || rest == "Z") return 0.0;
  if (rest[0] != '.' && rest[0] != ',') return std::nullopt;
  double fraction = 0.0;
  double unit = 0.1;
  for (const char c : rest.substr(1)) {
    if (c < '0' || c > '9') break;
    fraction += unit * (c - '0');
    unit /= 10.0;
  }
  return fraction;
}

}  // namespace

std::optional<double> clock_seconds(std::string_view text) {
  if (text.size() > kLongest) return std::nullopt;
  const std::string whole(text);
  for (const char* form : {"%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S", "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S",
                           "%m/%d/%Y %H:%M:%S", "%Y/%m/%d %H:%M:%S", "%H:%M:%S"}) {
    std::tm parts{};
    const char* const rest = strptime(whole.c_str(), form, &parts);
    if (rest == nullptr) continue;
    const auto fraction = fraction_of(rest);
    if (!fraction) continue;
    if (parts.tm_year == 0) return 3600.0 * parts.tm_hour + 60.0 * parts.tm_min + parts.tm_sec + *fraction;
    return static_cast<double>(timegm(&parts)) + *fraction;
  }
  return std::nullopt;
}

}  // namespace eha::importer
