// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/commission_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/report/html.hpp"
#include "daemon/track/track_result.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using report::Column;

constexpr const char* kStateFile = "commission.json";

/// A row of a table of measured values; nothing where the step did not observe it.
void add_measured(std::vector<std::vector<std::string>>& rows, const Json& sheet, const char* key, const char* name,
                  const char* unit_text, double factor) {
  const auto found = sheet.find(key);
  if (found == sheet.end() || !found->is_object()) return;
  rows.push_back({name, fmt::format("{:.4g}", factor * found->at("value").get<double>()),
                  fmt::format("{:.2g}", factor * found->at("half_width95").get<double>()), unit_text});
}

std::string valve_table(const Json& sheet, const DisplayUnit& unit) {
  std::vector<std::vector<std::string>> rows;
  const std::string gain_unit = unit.of("in/(V s)");
  const double gain = unit.factor("in/(V s)");
  add_measured(rows, sheet, "null_V", "null", "V", 1.0);
  add_measured(rows, sheet, "dead_band_V", "dead band, half width", "V", 1.0);
  add_measured(rows, sheet, "gain_positive_in_per_V_s", "velocity gain extending", gain_unit.c_str(), gain);
  add_measured(rows, sheet, "gain_negative_in_per_V_s", "velocity gain retracting", gain_unit.c_str(), gain);
  return report::table({{"valve"}, {"value", Column::number}, {"+- (95 %)", Column::number}, {"unit"}}, rows);
}

/// A link to a file of a run's folder, or its name alone.
std::string link(const std::string& run) {
  std::error_code ignored;
  const std::filesystem::path page = std::filesystem::absolute(run, ignored) / "report.html";
  if (!std::filesystem::exists(page, ignored)) return report::escaped(run);
  return fmt::format("<a href=\"file://{0}\">{0}</a>", report::escaped(page.string()));
}

}  // namespace

CommissionState::CommissionState(std::filesystem::path folder)
    : folder_(std::move(folder)), document_{{"schema", "eha-commission/1"}, {"steps", Json::object()}} {
  std::error_code ignored;
  if (!std::filesystem::exists(file(kStateFile), ignored)) return;
  const std::string name = file(kStateFile).string();
  document_ = Json::parse(os::read_file(name), nullptr, false);
  if (!document_.is_object() || document_.value("schema", "") != "eha-commission/1" || !document_.contains("steps") ||
      !document_.at("steps").is_object()) {
    throw DataError(name + ": is no state of a commissioning; name another folder with -o");
  }
}

void CommissionState::finish(const std::string& step, Json result) {
  document_["steps"][step] = std::move(result);
  write();
}

void CommissionState::set_rig(const std::string& rig_file, const std::string& sha256) {
  document_["rig"] = rig_file;
  document_["rig_sha256"] = sha256;
  write();
}

void CommissionState::write() const {
  os::create_folders(folder_);
  os::write_file_atomically(file(kStateFile), document_.dump(2) + "\n");
}

std::string commission_page(const CommissionState& state, const std::string& rig, const DisplayUnit& unit) {
  const Json& track = state.result("track");
  const bool is_kept = track.at("kept").get<bool>();
  std::string lead = report::paragraph(
      is_kept ? "The axis follows its reference as promised: nothing that was measured breaks the promise of " +
                    state.file("axis.toml").string() + "."
              : "The promise of the controller is not kept; the table of the axis shows which figure.");
  for (const Json& change : track.value("changes", Json::array())) {
    lead += report::paragraph("The moving rod shows: " + change.get<std::string>() + ".");
  }
  const Json& record = state.result("record");
  std::vector<std::string> notes;
  if (record.contains("gain_percent") && record.at("gain_percent").is_number()) {
    notes.push_back(fmt::format("The gain is known to +-{:.2g} %, {:.2g} % were wanted ({}).",
                                record.at("gain_percent").get<double>(), record.at("wanted_percent").get<double>(),
                                record.value("outcome", "")));
  }
  notes.push_back("Recommended model: " + record.value("model", "") + ". " + record.value("reason", ""));
  lead += report::list(notes) + valve_table(state.result("sheet"), unit) + "<ul>";
  for (const auto& [name, step] : state.document().at("steps").items()) {
    if (!step.contains("run")) continue;
    lead += "<li>" + report::escaped(name) + ": " + link(step.at("run").get<std::string>()) + "</li>";
  }
  lead += "</ul>";
  const std::string axis = shell_word(state.file("axis.toml").string());
  lead += report::paragraph("For a PLC, C or MATLAB: eha export " + axis + " --format st (or c, simulink).");
  return track_page(track::track_result(track.at("run").get<std::string>()), unit, "Commissioning of " + rig, lead)
      .html;
}

}  // namespace eha::cli
