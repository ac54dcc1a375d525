// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::config {

/// Treatment of the files that a configuration file names, such as an excitation's table of volts.
enum class NamedFiles {
  read,    ///< relative to the folder of the configuration file
  refuse,  ///< the text came without its files, as through the service
  leave,   ///< not read: the experiment is over and its volts are in the record
};

}  // namespace eha::config
