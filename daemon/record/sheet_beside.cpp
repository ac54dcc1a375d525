// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/sheet_beside.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {

namespace fs = std::filesystem;

std::optional<fs::path> newest_sheet_run(const fs::path& run) {
  const auto rig_of = [](const fs::path& folder) {
    return read_manifest(folder).other.value(nlohmann::ordered_json::json_pointer("/rig/name"), std::string());
  };
  std::error_code ignored;
  const std::string rig = rig_of(run);
  const std::vector<fs::path> runs = list_runs(fs::canonical(run, ignored).parent_path());
  const auto sheet = std::find_if(runs.rbegin(), runs.rend(), [&](const fs::path& one) {
    return fs::is_regular_file(one / kSheetFile, ignored) && rig_of(one) == rig;
  });
  if (sheet == runs.rend()) return std::nullopt;
  return run.parent_path() / sheet->filename();
}

std::optional<ident::Leak> leak_in(const fs::path& sheet_run) {
  std::error_code ignored;
  if (!fs::is_regular_file(sheet_run / kSheetFile, ignored)) return std::nullopt;
  const auto sheet = nlohmann::json::parse(os::read_file(sheet_run / kSheetFile), nullptr, false);
  const auto value = [&](const char* key) -> std::optional<double> {
    const nlohmann::json::json_pointer place(std::string("/") + key + "/value");
    if (!sheet.contains(place) || !sheet.at(place).is_number()) return std::nullopt;
    return sheet.at(place).get<double>();
  };
  const auto creep = value("creep_in_per_s");
  const auto positive = value("gain_positive_in_per_V_s");
  const auto negative = value("gain_negative_in_per_V_s");
  return creep && positive && negative ? ident::leak_of(*creep, *positive, *negative) : std::nullopt;
}

std::optional<ident::Leak> leak_beside(const fs::path& run) {
  try {
    const auto sheet = newest_sheet_run(run);
    return sheet ? leak_in(*sheet) : std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace eha::record
