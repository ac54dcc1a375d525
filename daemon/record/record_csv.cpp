// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/record_csv.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string>

#include "core/unit_names.hpp"
#include "daemon/record/csv_field.hpp"

namespace eha::record {
ident::Channel channel_from_header(std::string_view name) {
  const std::size_t bar = name.rfind('_');
  if (bar == std::string_view::npos || bar == 0 || bar + 1 == name.size()) return {std::string(name), ""};
  return {std::string(name.substr(0, bar)), unit_as_written_here(std::string(name.substr(bar + 1)))};
}

std::string header_from_channel(const ident::Channel& channel) {
  return channel.unit.empty() ? channel.name : channel.name + "_" + channel.unit;
}

std::string series_csv(const std::vector<double>& time_s, const ident::Channel& channel,
                       const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text = fmt::format("time_s,{}\n", csv_name(header_from_channel(channel)));
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{},{}\n", time_s[k], values[static_cast<Eigen::Index>(k)]);
  }
  return text;
}

}  // namespace eha::record
