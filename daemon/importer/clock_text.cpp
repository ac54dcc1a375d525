// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/clock_text.hpp"

#include <fmt/format.h>

#include <algorithm>
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

void RowClock::add(double time_s, double quantum_s, bool wraps) {
  constexpr double kDay_s = 86400.0;
  if (restart_) return;
  time_s += day_s_;
  if (wraps && rows_ > 0 && time_s < last_s_ - kDay_s / 2.0) {
    day_s_ += kDay_s;
    time_s += kDay_s;
  }
  if (rows_ > 0 && time_s < last_s_) {
    restart_ = rows_;
    return;
  }
  if (rows_ == 0) first_s_ = last_s_ = time_s;
  quantum_s_ = rows_ == 0 ? quantum_s : std::min(quantum_s_, quantum_s);
  if (time_s > last_s_) {
    if (changes_ == 0) {
      first_change_ = rows_;
      first_change_s_ = time_s;
    }
    last_change_ = rows_;
    last_s_ = time_s;
    ++changes_;
  }
  ++rows_;
}

std::optional<RowPeriod> RowClock::period() const {
  if (changes_ == 0) return std::nullopt;
  RowPeriod found{.rows = rows_, .span_s = last_s_ - first_s_, .restart = restart_};
  // Each time is less than a digit off.
  const double steps = static_cast<double>(rows_ - 1);
  found.lowest_s = std::max(0.0, found.span_s - quantum_s_) / steps;
  found.highest_s = (found.span_s + quantum_s_) / steps;
  if (changes_ + 1 < rows_ && last_change_ > first_change_ + 1) {
    // Several rows show the same time: where it changes is known to a row.
    const double span_s = last_s_ - first_change_s_;
    const auto between = static_cast<double>(last_change_ - first_change_);
    found.lowest_s = std::max(found.lowest_s, span_s / (between + 1.0));
    found.highest_s = std::min(found.highest_s, span_s / (between - 1.0));
  }
  found.roundest_s = 0.5 * (found.lowest_s + found.highest_s);
  constexpr int kMostDigits = 12;
  for (int digits = 1; digits < kMostDigits; ++digits) {
    const double round_s = std::stod(fmt::format("{:.{}e}", found.roundest_s, digits - 1));
    if (round_s <= found.lowest_s || round_s >= found.highest_s) continue;
    found.roundest_s = round_s;
    break;
  }
  return found;
}

}  // namespace eha::importer
