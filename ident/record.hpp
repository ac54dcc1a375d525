// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace eha::ident {

/// A named quantity with its unit, as in a record's header `voltage_V`.
struct Channel {
  std::string name;  ///< "voltage"
  std::string unit;  ///< "V"; empty when the header gave none
};

/// An evenly sampled record: row k is output[k] sampled, then input[k] applied and held until row k+1.
struct Record {
  double step_s = 0.0;     ///< sample period [s], positive
  double start_s = 0.0;    ///< time of row 0 [s]
  Eigen::VectorXd input;   ///< N samples [input_channel.unit]
  Eigen::VectorXd output;  ///< N samples [output_channel.unit]
  Channel input_channel{"voltage", "V"};
  Channel output_channel{"displacement", "in"};
  /// Rows of which a value was not measured, ascending. The output is interpolated there; the input is, too, or held in
  /// a gap.
  std::vector<std::size_t> unmeasured = {};
  int parts = 1;  ///< rows that in_parts() has made of each that was recorded
};

/// So many neighbouring rows that were not measured are a gap: what the input did there matters.
inline constexpr std::size_t kRowsOfGap = 5;

}  // namespace eha::ident
