// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/identification_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <map>

#include "daemon/eha/cross_validation_table.hpp"
#include "daemon/eha/frequency_table.hpp"
#include "daemon/eha/model_report.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/identify/publish.hpp"
#include "daemon/identify/size_hint.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/report/report.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/recommendation.hpp"

namespace eha::cli {
namespace {

/// Converts models for display.
std::vector<identify::IdentifiedModel> shown_in(std::vector<identify::IdentifiedModel> models,
                                                const DisplayUnit& unit) {
  for (identify::IdentifiedModel& identified : models) {
    identified.result.model = in_unit(std::move(identified.result.model), unit);
  }
  return models;
}

/// Prints what was written; of models that are not accepted their number, with -v each file.
void print_written(const std::vector<std::filesystem::path>& written,
                   const std::vector<identify::IdentifiedModel>& models, const Console& console) {
  std::map<std::filesystem::path, std::size_t> rejected;  // number of files by folder
  std::vector<ident::Model> judged;
  for (const identify::IdentifiedModel& identified : models) judged.push_back(identified.result.model);
  for (const std::filesystem::path& path : written) {
    if (path.parent_path().filename() != record::kRejectedFolder || console.verbose()) {
      console.print(fmt::format("written: {}", path.string()));
    } else {
      ++rejected[path.parent_path()];
    }
  }
  for (const auto& [folder, files] : rejected) {
    const std::string words = words_of_rejected(judged);
    console.print(fmt::format("written: {} {} in {}{}", files, files == 1 ? "model" : "models", folder.string(),
                              words.empty() ? "" : ": " + words));
  }
}

/// "Left out: io_valve, lag_valve, as the record does not allow them: model io_valve: 3 % of ..."; empty without any.
std::string left_out_text(const std::vector<ident::Refusal>& refused) {
  if (refused.empty()) return {};
  std::vector<std::string> names;
  for (const ident::Refusal& refusal : refused) names.push_back(refusal.model);
  return fmt::format("Left out: {}, as the record does not allow {}: {}.", fmt::join(names, ", "),
                     names.size() == 1 ? "it" : "them", refused.front().reason);
}

}  // namespace

void write_report(const record::OpenRun& run, const DisplayUnit& unit, std::vector<std::filesystem::path>& written,
                  const Console& console) {
  try {
    for (const std::string& sentence : report::write_into_run(run, unit)) console.warning(sentence);
    written.push_back(run.path() / report::kReportFile);
  } catch (const std::exception& error) {
    console.warning(fmt::format("no report was written: {}", error.what()));
  }
}

void print_warnings(const identify::Source& source, int decimation, const Console& console,
                    const std::function<std::string(int)>& command) {
  for (const std::string& sentence : identify::warnings(source)) console.warning(sentence);
  const auto hint = identify::size_hint(source, decimation, command);
  if (!hint) return;
  if (hint->is_grave) {
    console.warning(hint->sentence);
  } else {
    console.info(hint->sentence);
  }
}

void print_identification(const identify::Identification& identification,
                          const std::vector<std::filesystem::path>& written, nlohmann::ordered_json document,
                          const DisplayUnit& unit, const Console& console) {
  for (const std::string& sentence : identification.warnings) console.warning(sentence);
  for (const std::string& sentence : identification.response_notes) console.warning(sentence);
  for (const std::string& sentence : identification.notes) console.debug(sentence);
  document["models"] = identify::to_json(identification.models);
  document["recommendation"] = record::to_json(identification.recommendation);
  document["rounds"] = identify::to_json(identification.rounds);
  document["refused"] = identify::to_json(identification.refused);
  document["work"] = identify::to_json(identification.work);
  document["paper_procedure"] = identify::to_json(identification.paper);
  if (identification.frequency_response) {
    document["frequency_response"] = frequency_json(*identification.frequency_response, identification.models);
  }
  if (!identification.cross_validation.empty()) {
    document["cross_validation"] = cross_validation_json(identification.cross_validation);
  }
  document["files"] = nlohmann::ordered_json::array();
  for (const std::filesystem::path& path : written) document["files"].push_back(path.string());
  document["exit_code"] = static_cast<int>(identify::exit_code(identification.models));
  console.print_json(document);
  console.print(short_report(answer_of(identification), unit, console.verbose() ? Reasons::all : Reasons::first));
  for (const identify::Round& round : identification.rounds) {
    if (round.reason.empty()) continue;
    const bool is_fit = round.kind == identify::Round::Kind::fit;
    // The reason stands above already where it is that of the answer.
    const std::string because =
        round.reason == identification.recommendation.reason ? "." : ", because " + round.reason;
    console.print(wrapped(fmt::format("{} {}{}", is_fit ? "Tried" : "Next:", round.what, because), 0));
  }
  if (identification.next_experiment) {
    console.print(
        wrapped(fmt::format("{}: {}.", identify::kNextExperimentFile, identification.next_experiment->reason), 0));
  }
  if (console.verbose()) {
    console.print(wrapped(recommendation_text(answer_of(identification), unit), 0));
    const auto model_of = [](const identify::IdentifiedModel& row) -> const ident::Model& { return row.result.model; };
    const std::vector<identify::IdentifiedModel> rows =
        ident::in_table_order(shown_in(identification.models, unit), identification.recommendation, model_of);
    console.print(model_report(rows, shown_in(identification.paper, unit)));
  }
  if (const std::string text = left_out_text(identification.refused); !text.empty()) console.print(wrapped(text, 0));
  if (console.verbose() && identification.frequency_response) {
    console.print(frequency_table(*identification.frequency_response, identification.models, unit));
  }
  if (!identification.cross_validation.empty()) {
    console.print(cross_validation_table(identification.cross_validation));
  }
  print_written(written, identification.models, console);
}

}  // namespace eha::cli
