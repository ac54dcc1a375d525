// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>

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
};

}  // namespace eha::ident
