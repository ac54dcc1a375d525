// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/sheet_beside.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {

namespace fs = std::filesystem;

namespace {

/// What tells a rig from another one: copies of a rig file have one name. Its limits, [following] and calibration
/// change, and of a simulated one the start, the seed and the sensor's noise.
nlohmann::ordered_json rig_of(const fs::path& run) {
  const nlohmann::ordered_json other = read_manifest(run).other;
  const auto rig = other.find("rig");
  nlohmann::ordered_json known;
  if (rig == other.end() || !rig->is_object()) return known;
  for (const char* key : {"name", "sim"}) known[key] = rig->value(key, nlohmann::ordered_json());
  if (known["sim"].is_object()) {
    for (const char* key : {"initial_displacement_in", "seed", "sensor_noise_V"}) known["sim"].erase(key);
  }
  return known;
}

}  // namespace

std::optional<fs::path> newest_sheet_run(const fs::path& run) {
  std::error_code ignored;
  const nlohmann::ordered_json rig = rig_of(run);
  const std::vector<fs::path> runs = list_runs(fs::canonical(run, ignored).parent_path());
  const auto sheet = std::find_if(runs.rbegin(), runs.rend(), [&](const fs::path& one) {
    return fs::is_regular_file(one / kSheetFile, ignored) && rig_of(one) == rig;
  });
  if (sheet == runs.rend()) return std::nullopt;
  return run.parent_path() / sheet->filename();
}

namespace {

/// The values of the sheet in a run folder, by their keys.
class Sheet {
 public:
  explicit Sheet(const fs::path& run) {
    std::error_code ignored;
    if (fs::is_regular_file(run / kSheetFile, ignored)) {
      values_ = parse_json_text<nlohmann::json>(os::read_file(run / kSheetFile));
    }
  }
  [[nodiscard]] std::optional<double> value(const char* key) const {
    const nlohmann::json::json_pointer place(std::string("/") + key + "/value");
    if (!values_.contains(place) || !values_.at(place).is_number()) return std::nullopt;
    return values_.at(place).get<double>();
  }

 private:
  nlohmann::json values_;
};

/// What a sheet file has of a leak.
struct SeenCreep {
  double in_per_s = 0.0;
  double gain_positive = 0.0;
  double gain_negative = 0.0;
};

/// None without a sheet that can be read, and where the dead band was too narrow to see it.
std::optional<SeenCreep> creep_in(const fs::path& sheet_run) {
  const Sheet sheet(sheet_run);
  const auto creep = sheet.value("creep_in_per_s");
  const auto positive = sheet.value("gain_positive_in_per_V_s");
  const auto negative = sheet.value("gain_negative_in_per_V_s");
  if (!creep || !positive || !negative) return std::nullopt;
  return SeenCreep{*creep, *positive, *negative};
}

}  // namespace

std::optional<MeasuredValve> valve_in(const fs::path& sheet_run) {
  const Sheet sheet(sheet_run);
  const auto null_V = sheet.value("null_V");
  const auto dead_band_V = sheet.value("dead_band_V");
  if (!null_V || !dead_band_V) return std::nullopt;
  const auto positive = sheet.value("gain_positive_in_per_V_s");
  const auto negative = sheet.value("gain_negative_in_per_V_s");
  return MeasuredValve{.run = sheet_run,
                       .zone = {*null_V, std::max(0.0, *dead_band_V)},
                       .gains = positive && negative ? std::optional(std::pair(*positive, *negative)) : std::nullopt};
}

std::optional<ident::Leak> leak_in(const fs::path& sheet_run) {
  const auto creep = creep_in(sheet_run);
  return creep ? ident::leak_of(creep->in_per_s, creep->gain_positive, creep->gain_negative) : std::nullopt;
}

SheetBeside sheet_beside(const fs::path& run) {
  try {
    const auto sheet = newest_sheet_run(run);
    if (!sheet) return {};
    SheetBeside found{.valve = valve_in(*sheet), .leak = leak_in(*sheet)};
    if (creep_in(*sheet) && !found.leak) found.says = ident::SheetSays::is_tight;
    return found;
  } catch (const Error&) {
    return {};
  }
}

std::optional<ident::Leak> leak_beside(const fs::path& run) { return sheet_beside(run).leak; }

ident::SheetSays sheet_says_beside(const fs::path& run) { return sheet_beside(run).says; }

}  // namespace eha::record
