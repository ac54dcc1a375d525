// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>

#include "daemon/importer/header_facts.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/csv_field.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kWriteBytes = std::size_t{1} << 20U;
constexpr std::size_t kRowsBetweenProgress = 1U << 17U;

/// Decimals with which every time of the grid is written exactly; -1 when there are too many.
int decimals_of(double start_s, double step_s) {
  constexpr int kMost = 9;
  for (int decimals = 0; decimals <= kMost; ++decimals) {
    const double unit = std::pow(10.0, decimals);
    const auto is_whole = [&](double x) { return std::abs(x * unit - std::round(x * unit)) <= 1e-9 * step_s * unit; };
    if (is_whole(start_s) && is_whole(step_s)) return decimals;
  }
  return -1;
}

}  // namespace

void write_record_csv(const Imported& imported, const std::function<void(std::string_view)>& write,
                      const Progress& progress) {
  const ident::Record& record = imported.record;
  const bool has_filled = !imported.record.unmeasured.empty();
  const int decimals = decimals_of(record.start_s, record.step_s);
  std::string text = imported.is_closed_loop
                         ? fmt::format("{}: a set point of the rod stood beside input and output\n", kClosedLoopComment)
                         : "";
  text +=
      fmt::format("time_s,{},{}{}\n", record::csv_name(record::header_from_channel(record.input_channel)),
                  record::csv_name(record::header_from_channel(record.output_channel)), has_filled ? ",filled" : "");
  auto next_filled = imported.record.unmeasured.begin();
  const Eigen::Index rows = record.input.size();
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double time_s = record.start_s + static_cast<double>(k) * record.step_s;
    const auto out = std::back_inserter(text);
    if (decimals >= 0) {
      fmt::format_to(out, "{:.{}f}", time_s, decimals);
    } else {
      fmt::format_to(out, "{}", time_s);
    }
    fmt::format_to(out, ",{},{}", record.input[k], record.output[k]);
    if (has_filled) {
      const bool is_filled =
          next_filled != imported.record.unmeasured.end() && *next_filled == static_cast<std::size_t>(k);
      if (is_filled) ++next_filled;
      text += is_filled ? ",1" : ",0";
    }
    text += '\n';
    if (text.size() >= kWriteBytes) {
      write(text);
      text.clear();
    }
    if (progress && static_cast<std::size_t>(k) % kRowsBetweenProgress == 0) {
      progress(static_cast<double>(k) / static_cast<double>(rows), fmt::format("writing: {} rows", k));
    }
  }
  write(text);
}

}  // namespace eha::importer
