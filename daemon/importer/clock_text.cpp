// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/clock_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ctime>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/importer/column_names.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kLongest = 40;
constexpr std::string_view kDigits = "0123456789";

/// Seconds behind the whole ones: "", ".25" or ",25", milliseconds as ":250", and then perhaps a time zone, "Z" or
/// "+01:00", which is passed over.
std::optional<double> fraction_of(std::string_view rest) {
  constexpr std::size_t kMilliseconds = 4;
  double fraction = 0.0;
  const bool are_milliseconds = rest.size() == kMilliseconds && rest[0] == ':';
  if (are_milliseconds || rest.starts_with('.') || rest.starts_with(',')) {
    const std::size_t end = std::min(rest.find_first_not_of(kDigits, 1), rest.size());
    double unit = 0.1;
    for (const char c : rest.substr(1, end - 1)) {
      fraction += unit * (c - '0');
      unit /= 10.0;
    }
    rest.remove_prefix(end);
  }
  const bool is_zone = rest == "Z" || (rest.size() > 1 && (rest[0] == '+' || rest[0] == '-') &&
                                       rest.find_first_not_of("0123456789:", 1) == std::string_view::npos);
  return rest.empty() || is_zone ? std::optional(fraction) : std::nullopt;
}

/// Hours to be added to those before "AM" or "PM", which are cut off.
struct HalfDay {
  bool is_told = false;
  bool is_afternoon = false;
};
HalfDay cut_half_day(std::string& text) {
  if (text.size() < 4) return {};
  const char half = static_cast<char>(text[text.size() - 2] & ~0x20);
  if ((half != 'A' && half != 'P') || (text.back() & ~0x20) != 'M') return {};
  text.erase(text.find_last_not_of(' ', text.size() - 3) + 1);
  return {true, half == 'P'};
}

/// Minutes and a fraction of seconds as a spreadsheet shows them, "00:07,3", or seconds with their unit, "0.01 sec".
std::optional<double> elapsed_seconds(std::string text) {
  std::replace(text.begin(), text.end(), ',', '.');
  const char* const end = text.data() + text.size();
  double first = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), end, first);
  if (error != std::errc() || rest == end) return std::nullopt;
  const std::string_view behind(rest, static_cast<std::size_t>(end - rest));
  if (behind.starts_with(' ')) {
    const auto unit = known_unit(behind);
    const auto seconds = unit ? seconds_in(*unit) : std::nullopt;
    return seconds ? std::optional(first * *seconds) : std::nullopt;
  }
  double seconds = 0.0;
  const auto [last, fault] = std::from_chars(std::min(rest + 1, end), end, seconds);
  const bool has_fraction = behind.find('.') != std::string_view::npos;
  if (behind.front() != ':' || fault != std::errc() || last != end || !has_fraction || !(seconds < 60.0)) {
    return std::nullopt;
  }
  return 60.0 * first + seconds;
}

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<double> clock_seconds(std::string_view text) {
  if (text.size() > kLongest || text.find_first_of(":abcdefghijklmnopqrstuvwxyz") == std::string_view::npos) {
    return std::nullopt;
  }
  std::string whole(text);
  const HalfDay half = cut_half_day(whole);
  for (const char* form : {"%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S", "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S",
                           "%m/%d/%Y %H:%M:%S", "%Y/%m/%d %H:%M:%S", "%d-%b-%Y %H:%M:%S", "%d %b %Y %H:%M:%S",
                           "%b %d %Y %H:%M:%S", "%b %d, %Y %H:%M:%S", "%H:%M:%S"}) {
    std::tm parts{};
    const char* const rest = strptime(whole.c_str(), form, &parts);
    if (rest == nullptr) continue;
    const auto fraction = fraction_of(rest);
    if (!fraction) continue;
    if (half.is_told) parts.tm_hour = parts.tm_hour % 12 + (half.is_afternoon ? 12 : 0);
    if (parts.tm_year == 0) return 3600.0 * parts.tm_hour + 60.0 * parts.tm_min + parts.tm_sec + *fraction;
    return static_cast<double>(timegm(&parts)) + *fraction;
  }
  return half.is_told ? std::nullopt : elapsed_seconds(whole);
}

double clock_quantum_s(std::string_view text) {
  const std::size_t seconds = text.find_last_of(':');
  const std::size_t blank = text.find(' ');
  double unit_s = 1.0;
  if (seconds == std::string_view::npos && blank != std::string_view::npos) {
    unit_s = seconds_in(known_unit(text.substr(blank)).value_or("s")).value_or(1.0);
  }
  std::size_t point = text.find_first_of(".,", seconds == std::string_view::npos ? 0 : seconds);
  if (std::count(text.begin(), text.end(), ':') == 3) point = seconds;  // 10:00:00:250
  if (point == std::string_view::npos) return unit_s;
  const std::size_t end = std::min(text.find_first_not_of(kDigits, point + 1), text.size());
  return unit_s * std::pow(10.0, -static_cast<double>(end - point - 1));
}

bool is_clock_of_minutes(std::string_view text) {
  if (text.size() > kLongest) return false;
  std::string whole(text);
  cut_half_day(whole);
  const std::size_t colon = whole.find(':');
  if (colon == std::string::npos || whole.find(':', colon + 1) != std::string::npos) return false;
  // With seconds it is a clock; with a time in its place it is none.
  return !clock_seconds(whole) && clock_seconds(whole + ":00");
}

std::string with_seconds(std::string_view text) {
  std::string whole(text);
  static_cast<void>(cut_half_day(whole));
  return whole + ":00" + std::string(text.substr(std::min(whole.size(), text.size())));
}

std::optional<double> ClockReader::seconds(std::string_view text) {
  constexpr double kDay_s = 86400.0;
  // A date in double precision is known to a fraction of a microsecond.
  constexpr int kMostDecimals = 6;
  const std::optional<double> shown_s = clock_seconds(text);
  if (!shown_s) return std::nullopt;
  const bool has_date = text.substr(0, text.find(':')).find_first_of("-/. ") != std::string_view::npos;
  double time_s = *shown_s + day_s_;
  if (!has_date && first_s_ && time_s < last_s_ - kDay_s / 2.0) {
    day_s_ += kDay_s;
    time_s += kDay_s;
  } else if (!has_date && falls_ && time_s > last_s_ + kDay_s / 2.0) {
    day_s_ -= kDay_s;
    time_s -= kDay_s;
  }
  falls_ = first_s_ && (time_s < last_s_ || (falls_ && !(time_s > last_s_)));
  if (!first_s_) first_s_ = time_s;
  last_s_ = time_s;
  const int decimals = static_cast<int>(std::lround(-std::log10(clock_quantum_s(text))));
  decimals_ = std::clamp(decimals, decimals_, kMostDecimals);
  const double scale = std::pow(10.0, decimals_);
  return std::round((time_s - *first_s_) * scale) / scale;
}

void RowClock::add(double time_s, double quantum_s) {
  if (restart_) return;
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
  const double typical_s = typical_period_s();
  const bool is_coarse = quantum_s_ > 1.5 * typical_s;
  std::vector<std::size_t> parts = pauses(typical_s);
  found.pauses = parts.size();
  for (const std::size_t i : parts) {
    const double length_s = changes_[i].time_s - changes_[i - 1].time_s;
    if (found.longest_pause && found.longest_pause->length_s >= length_s) continue;
    found.longest_pause = RowPeriod::Pause{changes_[i].row, length_s, is_coarse};
  }
  // The longest part between two pauses. Of a clock that shows several rows alike the missing ones are somewhere within
  // the time before the change, which no part has then.
  parts.push_back(changes_.size());
  std::size_t first = 0;
  std::size_t longest_first = 0;
  std::size_t longest_end = 0;
  std::size_t most_rows = 0;
  for (const std::size_t end : parts) {
    const std::size_t stop = is_coarse && end < changes_.size() ? end - 1 : end;
    const std::size_t rows = (stop < changes_.size() ? changes_[stop].row : rows_) - changes_[first].row;
    if (rows > most_rows && stop > first + 1) {
      most_rows = rows;
      longest_first = first;
      longest_end = stop;
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
    // A clock that rounds may show a row that is just between two of its digits as either.
    constexpr double kRounding = 1e-9;
    if (round_s < found.lowest_s * (1.0 - kRounding) || round_s > found.highest_s * (1.0 + kRounding)) continue;
    found.roundest_s = round_s;
    break;
  }
  return found;
}

}  // namespace eha::importer
