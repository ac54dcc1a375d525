// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/clock_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace eha::importer {
namespace {

constexpr std::size_t kLongest = 40;

/// The digits after the seconds, "" or ".25" or ",25Z", or milliseconds as ":250".
std::optional<double> fraction_of(std::string_view rest) {
  constexpr std::size_t kMilliseconds = 4;
  if (rest.empty() || rest == "Z") return 0.0;
  const bool are_milliseconds = rest[0] == ':' && rest.size() == kMilliseconds;
  if (rest[0] != '.' && rest[0] != ',' && !are_milliseconds) return std::nullopt;
  double fraction = 0.0;
  double unit = 0.1;
  for (const char c : rest.substr(1)) {
    if (c < '0' || c > '9') break;
    fraction += unit * (c - '0');
    unit /= 10.0;
  }
  return fraction;
}

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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
  if (wraps && rows_ > 0 && time_s < changes_.back().time_s - kDay_s / 2.0) {
    day_s_ += kDay_s;
    time_s += kDay_s;
  }
  if (rows_ > 0 && time_s < changes_.back().time_s) {
    restart_ = rows_;
    return;
  }
  quantum_s_ = rows_ == 0 ? quantum_s : std::min(quantum_s_, quantum_s);
  if (rows_ == 0 || time_s > changes_.back().time_s) changes_.push_back({rows_, time_s});
  ++rows_;
}

/// Median over the changes of the time per row; the rows that show the first time may have begun earlier.
double RowClock::typical_period_s() const {
  std::vector<double> periods;
  for (std::size_t i = changes_.size() > 3 ? 2 : 1; i < changes_.size(); ++i) {
    periods.push_back((changes_[i].time_s - changes_[i - 1].time_s) /
                      static_cast<double>(changes_[i].row - changes_[i - 1].row));
  }
  return middle_of(std::move(periods));
}

/// Of changes_, those before which the clock went on by more than its own unevenness and half a row.
std::vector<std::size_t> RowClock::pauses(double typical_s) const {
  // Times of rows that a coarse clock shows alike are known to a row or so from its changes; those of a fine one to its
  // last digit. Stamps of a busy computer come late and catch up: three times the usual unevenness is none of it.
  constexpr double kOverUsual = 3.0;
  constexpr double kUsualShare = 0.9;
  std::vector<double> surplus(changes_.size(), 0.0);
  for (std::size_t i = 2; i < changes_.size(); ++i) {
    surplus[i] = changes_[i].time_s - changes_[i - 1].time_s -
                 static_cast<double>(changes_[i].row - changes_[i - 1].row) * typical_s;
  }
  std::vector<double> uneven;
  for (std::size_t i = 2; i < surplus.size(); ++i) uneven.push_back(std::abs(surplus[i]));
  std::vector<std::size_t> found;
  if (uneven.empty()) return found;
  const auto usual = uneven.begin() + static_cast<std::ptrdiff_t>(kUsualShare * static_cast<double>(uneven.size() - 1));
  std::nth_element(uneven.begin(), usual, uneven.end());
  const double least_s = std::max({kOverUsual * *usual, 0.5 * typical_s, 1.05 * std::min(quantum_s_, 2.0 * typical_s)});
  for (std::size_t i = 2; i < surplus.size(); ++i) {
    // After a pause the time within the digit shown is not known until the next change.
    const bool is_rest = !found.empty() && found.back() + 1 == i && surplus[i] < quantum_s_;
    if (surplus[i] > least_s && !is_rest) found.push_back(i);
  }
  return found;
}

/// @param first, last  of changes_, between which there is no pause  @param end_row  the row behind the part
void RowClock::set_bounds(RowPeriod& found, std::size_t first, std::size_t last, std::size_t end_row) const {
  found.first_row = changes_[first].row;
  found.end_row = end_row;
  found.rows = end_row - found.first_row;
  found.span_s = changes_[last].time_s - changes_[first].time_s;
  // Each time is less than a digit off.
  const double steps = static_cast<double>(found.rows - 1);
  found.lowest_s = std::max(0.0, found.span_s - quantum_s_) / steps;
  found.highest_s = (found.span_s + quantum_s_) / steps;
  const std::size_t changes = last - first;
  if (changes + 1 >= found.rows || changes < 2) return;
  // Several rows show the same time: where it changes is known to a row.
  const double span_s = changes_[last].time_s - changes_[first + 1].time_s;
  const std::size_t between = changes_[last].row - changes_[first + 1].row;
  if (between < 2) return;
  found.lowest_s = std::max(found.lowest_s, span_s / (static_cast<double>(between) + 1.0));
  found.highest_s = std::min(found.highest_s, span_s / (static_cast<double>(between) - 1.0));
}

std::optional<RowPeriod> RowClock::period() const {
  if (changes_.size() < 2) return std::nullopt;
  RowPeriod found{.restart = restart_};
  std::vector<std::size_t> parts = pauses(typical_period_s());
  found.pauses = parts.size();
  for (const std::size_t i : parts) {
    const double length_s = changes_[i].time_s - changes_[i - 1].time_s;
    if (found.longest_pause && found.longest_pause->length_s >= length_s) continue;
    found.longest_pause = RowPeriod::Pause{changes_[i].row, length_s};
  }
  // The longest part between two pauses.
  parts.push_back(changes_.size());
  std::size_t first = 0;
  std::size_t longest_first = 0;
  std::size_t longest_end = 0;
  std::size_t most_rows = 0;
  for (const std::size_t end : parts) {
    const std::size_t rows = (end < changes_.size() ? changes_[end].row : rows_) - changes_[first].row;
    if (rows > most_rows && end - first > 1) {
      most_rows = rows;
      longest_first = first;
      longest_end = end;
    }
    first = end;
  }
  if (most_rows == 0) longest_end = changes_.size();
  set_bounds(found, longest_first, longest_end - 1, longest_end < changes_.size() ? changes_[longest_end].row : rows_);
  found.is_part = restart_.has_value() || found.end_row < rows_;
  found.roundest_s = 0.5 * (found.lowest_s + found.highest_s);
  constexpr int kMostRoundDigits = 12;
  for (int digits = 1; digits < kMostRoundDigits; ++digits) {
    const double round_s = std::stod(fmt::format("{:.{}e}", found.roundest_s, digits - 1));
    if (round_s <= found.lowest_s || round_s >= found.highest_s) continue;
    found.roundest_s = round_s;
    break;
  }
  return found;
}

}  // namespace eha::importer
