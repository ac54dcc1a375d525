// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {

/// The text with the value of a key replaced, and what follows it on the line.
inline std::string with_value(std::string text, const std::string& key, double value) {
  const std::size_t at = text.find("\n" + key + " = ");
  if (at == std::string::npos) throw std::runtime_error("the rig file has no " + key);
  const std::size_t end = text.find('\n', at + 1);
  return text.replace(at + 1, end - at - 1, fmt::format("{} = {:.6f}", key, value));
}

/// The shipped simulated rig, with nothing known of its valve.
inline std::string unknown_rig() {
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::size_t begin = rig.find("[following]");
  return rig.erase(begin, rig.find("# How ticks are kept.") - begin);
}

inline nlohmann::json json_of(const std::filesystem::path& file) { return nlohmann::json::parse(content_of(file)); }

/// The manifests of a folder's runs, in the order of their names.
inline std::vector<nlohmann::json> manifests_of(const std::filesystem::path& runs) {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(runs)) {
    if (entry.is_directory() && !entry.is_symlink()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  std::vector<nlohmann::json> manifests;
  for (const auto& folder : folders) manifests.push_back(json_of(folder / "run.json"));
  return manifests;
}

}  // namespace eha::test
