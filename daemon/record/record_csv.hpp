// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "ident/record.hpp"

// Records as CSV text, see eha-record(5): a header row, `time_s` first, units as the suffix of a name (`voltage_V`).
// eha::importer reads them.

namespace eha::record {

/// One input to simulate a model with.
struct InputSeries {
  ident::Channel channel;
  std::vector<double> time_s;  ///< as printed in the file [s]
  Eigen::VectorXd values;      ///< [channel.unit], one a time
  double step_s = 0.0;         ///< [s], positive
};

/// Splits a column's name at its last underscore: "voltage_V" is voltage in V; no underscore, no unit.
[[nodiscard]] ident::Channel channel_from_header(std::string_view name);

/// The column's name of a channel, the reverse of channel_from_header.
[[nodiscard]] std::string header_from_channel(const ident::Channel& channel);

/// CSV text of `time_s` and one column; numbers read back to the same bits. Cost O(N), 35 bytes a row.
[[nodiscard]] std::string series_csv(const std::vector<double>& time_s, const ident::Channel& channel,
                                     const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace eha::record
