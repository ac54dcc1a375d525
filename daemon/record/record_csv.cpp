// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/record_csv.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "daemon/record/csv_columns.hpp"
#include "daemon/record/time_grid.hpp"

namespace eha::record {
namespace {

/// Copies a column and frees its vector, so that a long record is not held twice.
Eigen::VectorXd taken(std::vector<double>& column) {
  Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(column.size()));
  std::vector<double>().swap(column);
  return values;
}

}  // namespace

ident::Channel channel_from_header(std::string_view name) {
  const std::size_t bar = name.rfind('_');
  if (bar == std::string_view::npos || bar == 0 || bar + 1 == name.size()) return {std::string(name), ""};
  return {std::string(name.substr(0, bar)), std::string(name.substr(bar + 1))};
}

std::string header_from_channel(const ident::Channel& channel) {
  return channel.unit.empty() ? channel.name : channel.name + "_" + channel.unit;
}

ident::Record read_record_csv(const std::filesystem::path& path) {
  CsvColumns columns = read_csv_columns(path, WantedColumns::all);
  ident::Record record;
  record.step_s = even_step_s(columns, path);
  record.start_s = columns.values[0].front();
  std::vector<double>().swap(columns.values[0]);
  record.input = taken(columns.values[1]);
  record.output = taken(columns.values[2]);
  record.input_channel = channel_from_header(columns.names[1]);
  record.output_channel = channel_from_header(columns.names[2]);
  return record;
}

InputSeries read_input_csv(const std::filesystem::path& path) {
  CsvColumns columns = read_csv_columns(path, WantedColumns::first_and_last);
  InputSeries series;
  series.step_s = even_step_s(columns, path);
  series.channel = channel_from_header(columns.names.back());
  series.time_s = std::move(columns.values[0]);
  series.values = taken(columns.values[1]);
  return series;
}

std::string series_csv(const std::vector<double>& time_s, const ident::Channel& channel,
                       const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text = fmt::format("time_s,{}\n", header_from_channel(channel));
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{},{}\n", time_s[k], values[static_cast<Eigen::Index>(k)]);
  }
  return text;
}

}  // namespace eha::record
