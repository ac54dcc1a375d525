// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>

#include "core/display_unit.hpp"

namespace eha::cli {

/// Range of rod and command over the last second of the sample stream, for a line of `eha status --watch`.
class RecentSamples {
 public:
  /// @param samples  the member `samples` of an event, ehad-protocol(7)
  void add(const nlohmann::ordered_json& samples);

  /// "2.912 to 3.105 in, -1.20 to +1.40 V"; without the volts if nothing drives the rig; "not read yet" without a
  /// sample. @param unit  of displayed lengths
  [[nodiscard]] std::string text(const DisplayUnit& unit) const;

 private:
  static constexpr std::size_t kKept = 25;  ///< blocks of 40 ms
  std::deque<nlohmann::ordered_json> blocks_;
};

}  // namespace eha::cli
