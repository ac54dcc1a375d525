// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/tuned_rig.hpp"

#include <fmt/format.h>

#include <system_error>
#include <variant>

#include "core/error.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// Whether a controller for one rig does what it promises on the other.
bool is_same_rig(const config::RigConfig& a, const config::RigConfig& b) {
  if (!is_one_rig(a, b)) return false;
  const auto& valve_a = a.limits.following;
  const auto& valve_b = b.limits.following;
  if (!valve_a || !valve_b) return valve_a.has_value() == valve_b.has_value();
  return valve_a->null_V == valve_b->null_V && valve_a->dead_band_V == valve_b->dead_band_V;
}

}  // namespace

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

std::string rig_option(const config::RigConfig& rig) {
  try {
    if (is_same_rig(load_rig_or_default(std::nullopt), rig)) return "";
  } catch (const Error&) {  // there is no default
  }
  return " --rig RIG.toml";
}

}  // namespace eha::cli
