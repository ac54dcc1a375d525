// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace eha::batch {

/// What may tell a record from the others.
struct RecordParts {
  std::string name = {};    ///< of its experiment, or of its file: "paper", "pump 1"
  std::string rig = {};     ///< of a run
  std::string folder = {};  ///< that it lies in
  std::string time = {};    ///< of a run, from its folder: "20261129T105158Z"
};

/// @param source  run folder or file, as listed   @param rig  its name; empty of a file
[[nodiscard]] RecordParts parts_of(const std::string& source, const std::string& rig);

/// The shortest names that tell records apart, for people: of name, rig and folder the fewest that tell the most apart,
/// and the time of a run where these leave two alike, without the day if all are of one day; last the place in the
/// list. "worn rig", "simulated rig 10:51:58". One record has its name.
[[nodiscard]] std::vector<std::string> labels_of(const std::vector<RecordParts>& records);

}  // namespace eha::batch
