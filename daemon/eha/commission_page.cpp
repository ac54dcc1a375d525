// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/commission_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "core/capitalised.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/report.hpp"
#include "daemon/track/track_result.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "ident/valve/leak.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Adds a row to a table of measured values; nothing if the step did not observe the value.
void add_measured(std::vector<std::vector<std::string>>& rows, const Json& sheet, const char* key, const char* name,
                  const char* unit_text, double factor) {
  const auto found = sheet.find(key);
  if (found == sheet.end() || !found->is_object()) return;
  rows.push_back({name, fmt::format("{:.4g}", factor * found->at("value").get<double>()),
                  fmt::format("{:.2g}", factor * found->at("half_width95").get<double>()), unit_text});
}

/// The leak that the numbers of a valve sheet show, as the sheet itself says it.
std::optional<ident::Leak> leak_in(const Json& sheet) {
  const auto value = [&](const char* key) {
    const auto found = sheet.find(key);
    return found != sheet.end() && found->is_object() ? found->value("value", 0.0) : 0.0;
  };
  return ident::leak_of(value("creep_in_per_s"), value("gain_positive_in_per_V_s"), value("gain_negative_in_per_V_s"));
}

std::string valve_table(const Json& sheet, const DisplayUnit& unit) {
  std::vector<std::vector<std::string>> rows;
  const std::string gain_unit = unit.of("in/(V s)");
  const double gain = unit.factor("in/(V s)");
  add_measured(rows, sheet, "null_V", "null", "V", 1.0);
  add_measured(rows, sheet, "dead_band_V", "half dead band", "V", 1.0);
  add_measured(rows, sheet, "gain_positive_in_per_V_s", "velocity gain extending", gain_unit.c_str(), gain);
  add_measured(rows, sheet, "gain_negative_in_per_V_s", "velocity gain retracting", gain_unit.c_str(), gain);
  const std::string speed_unit = unit.of("in/s");
  add_measured(
      rows, sheet, "creep_in_per_s",
      leak_in(sheet) ? "speed within the dead band: a leak to repair" : "speed within the dead band: no leak to repair",
      speed_unit.c_str(), unit.factor("in/s"));
  return report::table({{"valve"}, {"value", report::Column::number}, {"+- (95 %)", report::Column::number}, {"unit"}},
                       rows) +
         report::paragraph(
             "Rig file and controller use these numbers of the valve. Null and dead band in the equation below are "
             "fitted: friction and leakage shift them.");
}

/// Returns the ticks of a run as time [s].
double rig_time_s(const record::Manifest& manifest) {
  return manifest.report
             ? static_cast<double>(manifest.report->counters.ticks) * manifest.other.value("sample_period_s", 0.0)
             : 0.0;
}

/// Describes a step's run: purpose, duration of the motion, and its report beside this page.
std::string item(const char* what, const Json& step, const fs::path& folder) {
  const fs::path run = step.at("run").get<std::string>();
  std::string text = fmt::format("{}: {:.0f} s", what, rig_time_s(record::read_manifest(run)));
  std::error_code ignored;
  const fs::path page = fs::absolute(run / report::kReportFile, ignored);
  const std::string name = report::escaped(run.filename().string());
  if (!fs::exists(page, ignored)) return fmt::format("<li>{}, run {}</li>", report::escaped(text), name);
  const fs::path link = fs::proximate(page, fs::absolute(folder, ignored), ignored);
  return fmt::format("<li>{}, <a href=\"{}\">run {}</a></li>", report::escaped(text), report::escaped(link.string()),
                     name);
}

/// Returns the warnings of doctor; empty without.
std::string warnings_of(const Json& prepare) {
  std::vector<std::string> found;
  for (const Json& check : prepare.value("checks", Json::array())) {
    if (check.value("level", "") == "ok") continue;
    found.push_back(fmt::format("{}: {}", check.value("name", ""), check.value("found", "")));
  }
  return found.empty() ? "" : report::paragraph("`eha doctor` warned of this machine:") + report::list(found);
}

/// Returns the recommended model of a run; none if its file no longer exists.
std::optional<ident::Model> model_of_run(const fs::path& run, const std::string& name) {
  for (ident::Model& model : answer_of_run(run, record::read_manifest(run)).models) {
    if (model.name == name) return std::move(model);
  }
  return std::nullopt;
}

std::string model_part(const Json& record, const DisplayUnit& unit) {
  std::string text;
  if (const Json percent = record.value("gain_percent", Json()); percent.is_number()) {
    text += fmt::format(
        "The gain is known to +-{:.2g} %, {:.2g} % were wanted: by integrator_lag_valve, fitted to the repetitions "
        "while the run was played, and not by the model below, which is of the whole record. ",
        percent.get<double>(), record.at("wanted_percent").get<double>());
  }
  const std::string name = record.value("model", "");
  text += "Model: " + name;
  const std::optional<ident::Model> model = model_of_run(record.at("run").get<std::string>(), name);
  if (!model) return report::paragraph(text + ".");
  const ident::Model shown = ident::in_unit(*model, unit);
  if (shown.validation) {
    text += fmt::format(", fit {:.1f} % on the part of the record that it has not seen",
                        shown.validation->score.fit_percent);
  }
  std::string html = report::paragraph(text + ".") + report::equation(shown);
  if (shown.verdict && shown.verdict->grade != ident::Grade::good) {
    // In few words: what to do about them is done, the valve sheet before the record and the trial after it.
    std::vector<std::string> reasons;
    for (const std::string& reason : shown.verdict->reasons) reasons.push_back(ident::in_few_words(reason));
    html += report::paragraph("The model is " + std::string(ident::verdict_word(*shown.verdict)) +
                              ", not good, for what stands below; the controller's trial shows whether that is good "
                              "enough:") +
            report::list(reasons);
  }
  return html;
}

}  // namespace

std::string missed_precision(const Json& record) {
  const Json wanted = record.value("wanted_percent", Json());
  const Json percent = record.value("gain_percent", Json());
  if (!wanted.is_number() || (percent.is_number() && percent.get<double>() <= wanted.get<double>())) return {};
  return fmt::format(
      "the wanted precision was not reached: the gain {} by {}, {:g} % were wanted; the controller is made of this "
      "record, and its promise allows for that",
      percent.is_number() ? fmt::format("is known to +-{:.2g} %", percent.get<double>()) : "has no interval",
      fs::path(record.value("run", "")).filename().string(), wanted.get<double>());
}

std::string commission_page(const CommissionState& state, const std::string& rig, const std::string& anew,
                            const DisplayUnit& unit) {
  const Json& track = state.result("track");
  const record::OpenRun trial(track.at("run").get<std::string>());
  const std::string axis_file = state.file("axis.toml").string();
  const track::TrackResult result = track::track_result(trial);
  std::string lead = report::paragraph(
      result.leak
          ? fmt::format(
                "The rig leaks: {}. Repair that first, then begin anew: `{}`. Until then no controller of it goes "
                "to a PLC.",
                ident::leak_text(*result.leak, unit), anew)
      : track.at("kept").get<bool>()
          ? "The axis follows its reference as promised: nothing that was measured breaks the promise of " + axis_file +
                "."
          : "The axis does not keep the controller's promise: the table \"Measured beside promised\" shows which "
            "figure. Mend what has changed on the rig, or begin anew: `" +
                anew + "`.");
  if (const std::string missed = missed_precision(state.result("record")); !missed.empty()) {
    lead += "<p><strong>" + report::with_code(capitalised(missed)) + ".</strong></p>\n";
  }
  lead += "<ul>" + item("valve sheet", state.result("sheet"), state.folder()) +
          item("record and models", state.result("record"), state.folder()) +
          item("trial in closed loop", track, state.folder()) + "</ul>" + valve_table(state.result("sheet"), unit) +
          model_part(state.result("record"), unit);
  if (state.has("prepare")) lead += warnings_of(state.result("prepare"));
  if (track::goes_to_plc(result, unit)) {
    lead += report::paragraph(
        fmt::format("For a PLC, C or MATLAB: `{}` (or c, simulink). Later, to see whether the axis "
                    "still keeps its promise: `{}`.",
                    suggest::export_for_plc(axis_file),
                    suggest::track(suggest::access_of_run(record::read_manifest(trial.files()).other), axis_file)));
  }
  return track_page(result, unit, "Commissioning of " + rig, lead).html;
}

}  // namespace eha::cli
