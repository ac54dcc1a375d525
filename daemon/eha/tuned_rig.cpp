// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/tuned_rig.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <variant>

#include "core/error.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::cli {
namespace fs = std::filesystem;

config::RigConfig rig_of(const fs::path& file_or_run) {
  std::error_code ignored;
  if (!fs::is_directory(file_or_run, ignored)) return config::load_rig(file_or_run.string());
  const record::Manifest manifest = record::read_manifest(file_or_run);
  const auto rig = manifest.other.find("rig");
  if (rig == manifest.other.end() || !rig->contains("text")) {
    throw DataError(file_or_run.string() + ": its run.json holds no rig file; name one with --rig");
  }
  return config::parse_rig(rig->at("text").get<std::string>(), (file_or_run / "run.json (rig)").string());
}

bool is_one_rig(const config::RigConfig& a, const config::RigConfig& b) {
  const auto* sim_a = std::get_if<hal::SimOptions>(&a.backend);
  const auto* sim_b = std::get_if<hal::SimOptions>(&b.backend);
  return a.name == b.name && (sim_a == nullptr) == (sim_b == nullptr) && (sim_a == nullptr || *sim_a == *sim_b);
}

hal::SimOptions twin_of(const std::string& file) {
  const config::RigConfig twin = config::load_rig(file);
  const auto* sim = std::get_if<hal::SimOptions>(&twin.backend);
  if (sim == nullptr) {
    throw UsageError(
        fmt::format("--twin {}: expected a simulated rig; make one with `eha replay RUN --calibrate ...`", file));
  }
  return *sim;
}

std::optional<std::string> rig_file_of(const fs::path& run) {
  std::error_code ignored;
  try {
    const record::Manifest manifest = record::read_manifest(run);
    const nlohmann::ordered_json::json_pointer place("/rig/file");
    if (!manifest.other.contains(place) || !manifest.other.at(place).is_string()) return std::nullopt;
    auto file = manifest.other.at(place).get<std::string>();
    if (!fs::is_regular_file(file, ignored)) return std::nullopt;
    return file;
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string rig_name_of(const fs::path& file_or_run) {
  std::error_code ignored;
  if (!fs::is_directory(file_or_run, ignored)) return rig_name(file_or_run);
  const auto file = rig_file_of(file_or_run);
  return file ? rig_name(*file) : std::string();
}

}  // namespace eha::cli
