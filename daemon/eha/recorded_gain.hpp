// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

namespace eha::cli {

/// A run of a commissioning, with or without a model.
struct Recorded {
  std::filesystem::path folder;
  std::string outcome;
  double gain_percent = std::numeric_limits<double>::infinity();  ///< half of the 95 % interval of the gain
  std::optional<std::string> model;                               ///< name of the recommended model
};

/// "the gain is known to +-0.84 %", or that it has no interval.
[[nodiscard]] inline std::string gain_known(const Recorded& run) {
  return std::isfinite(run.gain_percent) ? fmt::format("the gain is known to +-{:.2g} %", run.gain_percent)
                                         : std::string("the gain has no interval");
}

/// Why of two runs one is taken.
[[nodiscard]] inline std::string why_taken(const Recorded& taken, const Recorded& other) {
  const std::string name = taken.folder.filename().string();
  const std::string left = other.folder.filename().string();
  if (!other.model) {
    return fmt::format("by {} {}, but no model of it passes; {} is taken, whose {} does", left, gain_known(other), name,
                       taken.model.value_or("model"));
  }
  return fmt::format("by {} {}, by {} {}: {} is taken, the {} one", name, gain_known(taken), left, gain_known(other),
                     name, taken.gain_percent < other.gain_percent ? "more precise" : "first");
}

}  // namespace eha::cli
