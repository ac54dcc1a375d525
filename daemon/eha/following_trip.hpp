// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "daemon/suggest/commands.hpp"

namespace eha::cli {

/// Whether a wrong [following] can cause a fault. @param fault  its name, such as "no_motion", or a sentence that
/// begins with it
[[nodiscard]] bool may_be_of_following(std::string_view fault);

/// Says how to measure the valve of a rig whose characterisation was ended by a fault that a wrong [following] can
/// cause; empty for another fault.
/// @param fault  as of may_be_of_following()
[[nodiscard]] std::string way_out_of_following(std::string_view fault, const std::string& rig_file,
                                               const suggest::RigAccess& rig);

/// The same of a rig file without [following], where the valve's edges may lie beyond what its rules allow, and the
/// lines to write into the file.
struct WayOut {
  std::string sentence;  ///< empty for another fault
  std::string lines;
};
[[nodiscard]] WayOut way_out_without_following(std::string_view fault, const std::string& rig_file);

/// The description of the end of a characterisation without the causes in [following] that the rig file has not.
[[nodiscard]] std::string without_causes_of_following(std::string description);

}  // namespace eha::cli
