// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_argument.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "ident/model/model_file.hpp"

namespace eha::cli {
namespace {

/// The run folder whose models' folder has this file, RUN/models/NAME.json or RUN/models/rejected/NAME.json; empty
/// without one.
std::filesystem::path run_of_models_file(const std::string& file) {
  std::filesystem::path folder = std::filesystem::path(file).parent_path();
  if (folder.filename() == record::kRejectedFolder) folder = folder.parent_path();
  if (folder.filename() != record::kModelsFolder) return {};
  const std::filesystem::path run = folder.has_parent_path() ? folder.parent_path() : ".";
  return record::is_run_folder(run) ? run : std::filesystem::path();
}

}  // namespace

ident::Model read_model(const std::string& file) {
  if (record::is_run_folder(file)) {
    throw UsageError(
        fmt::format("{}: a run, where a model file was expected; its models are in {}/{}, and "
                    "`eha runs show {}` lists them",
                    file, file, record::kModelsFolder, shell_word(file)));
  }
  const std::filesystem::path path(file);
  if (path.filename() == record::kManifestFile && record::is_run_folder(path.parent_path())) {
    throw UsageError(
        fmt::format("{}: the manifest of a run, where a model file was expected; the run's models are in {}", file,
                    (path.parent_path() / record::kModelsFolder).string()));
  }
  ident::Model model = ident::model_from_text(os::read_file(file), file);
  // A folder that was renamed, or a link that leads to a later run now, names another record.
  const auto record = model.provenance.find("record");
  if (const std::filesystem::path run = run_of_models_file(file); record != model.provenance.end() && !run.empty()) {
    std::error_code ignored;
    if (!std::filesystem::equivalent(record->second, run, ignored)) record->second = run.string();
  }
  return model;
}

std::string rig_units_of_model(const std::string& file) {
  // RUN/models/NAME.json or RUN/models/rejected/NAME.json
  std::error_code ignored;
  std::filesystem::path folder = std::filesystem::absolute(file, ignored).parent_path();
  for (int level = 0; level < 3; ++level, folder = folder.parent_path()) {
    if (!record::is_run_folder(folder)) continue;
    try {
      return record::rig_units(record::read_manifest(folder).other);
    } catch (const Error&) {
      return {};  // a damaged manifest does not prevent the use of the model
    }
  }
  return {};
}

std::string record_of(const ident::Model& model) {
  const auto record = model.provenance.find("record");
  return record == model.provenance.end() ? std::string() : record->second;
}

bool is_one_record(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return !a.empty() && (a == b || std::filesystem::equivalent(a, b, ignored));
}

ident::Intersample intersample_for(const std::optional<ident::Intersample>& given, const ident::Model& model,
                                   const Console& console) {
  if (given) return *given;
  const ident::Intersample own = identify::intersample_of(model);
  if (own == ident::Intersample::straight) {
    console.info(fmt::format(
        "the input is taken as straight lines between its rows, as {} was estimated (--intersample zoh: as held)",
        model.name));
  }
  return own;
}

std::string own_record_text(const std::string& model_file, const identify::Source& source) {
  if (!source.run_folder) return {};
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::canonical(*source.run_folder, ignored);
  for (std::filesystem::path at = std::filesystem::canonical(model_file, ignored); at.has_relative_path();
       at = at.parent_path()) {
    if (at.parent_path() != folder) continue;
    return fmt::format(
        "{} was estimated on this very run, {}: that it fits says nothing about the rig since; name a later run, `eha "
        "runs` lists them",
        model_file, folder.filename().string());
  }
  return {};
}

void warn_of_own_record(const std::string& model_file, const identify::Source& source, const Console& console) {
  if (const std::string text = own_record_text(model_file, source); !text.empty()) console.warning(text);
}

}  // namespace eha::cli
