// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_argument.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// Whether a name is "latest", or begins like that of a run folder: 20260101T120000Z-
bool may_be_run(std::string_view name) {
  constexpr std::string_view kShape = "00000000T000000Z-";
  if (name == "latest") return true;
  return name.size() > kShape.size() && std::equal(kShape.begin(), kShape.end(), name.begin(), [](char shape, char c) {
           return shape == '0' ? std::isdigit(static_cast<unsigned char>(c)) != 0 : shape == c;
         });
}

/// The same name among the service's runs; empty without one.
fs::path at_service(const fs::path& name, const fs::path& socket) {
  const fs::path folder = run_folder_of_service(socket);
  std::error_code ignored;
  return !folder.empty() && fs::exists(folder / name, ignored) ? folder / name : fs::path();
}

/// What to know of a link to the latest run beside which a newer one lies that tripped, was stopped or has no accepted
/// model: the link names the last with one.
std::string newer_than_latest(const fs::path& link, Newer newer) {
  std::error_code ignored;
  if (link.filename() != record::kLatestLink || !fs::is_symlink(link, ignored)) return {};
  const fs::path target = fs::read_symlink(link, ignored);
  std::vector<fs::path> runs;
  try {
    runs = record::list_runs(link.has_parent_path() ? link.parent_path() : fs::path("."));
    if (runs.empty()) return {};
    const record::Manifest newest = record::read_manifest(runs.back());
    const bool is_of_models = record::purpose_of(newest) == record::Purpose::models;
    if (newer == Newer::of_models && record::is_whole(record::outcome_text(newest)) && !is_of_models) return {};
  } catch (const Error&) {
    return {};  // a folder that the caller may not list
  }
  if (runs.back().filename() <= target.filename()) return {};
  return fmt::format("{} is {}, the last run with an accepted model; the newest run is {}", link.string(),
                     target.string(), runs.back().string());
}

}  // namespace

fs::path run_folder_of_service(const fs::path& socket) {
  std::error_code ignored;
  if (!fs::exists(socket, ignored)) return {};
  try {
    return control::Client(socket).call("runs").at("folder").get<std::string>();
  } catch (const Error&) {
    return {};  // no service answers
  }
}

NamedRun run_named(const std::string& given, const fs::path& socket, Newer newer) {
  std::error_code ignored;
  fs::path name = fs::path(given).lexically_normal();
  if (fs::exists(name, ignored) || name.is_absolute()) return {given, newer_than_latest(name, newer)};
  if (!name.empty() && *name.begin() == "runs") name = name.lexically_relative("runs");
  if (name.empty()) return {given};
  if (!may_be_run(name.begin()->string()) && !record::is_run_folder("runs" / *name.begin())) return {given};
  const fs::path here = "runs" / name;
  if (fs::exists(here, ignored)) {
    // A link that each folder of runs has, so that the name alone says little.
    const fs::path there = *name.begin() == "latest" ? at_service(name, socket) : fs::path();
    if (there.empty() || fs::equivalent(here, there, ignored)) return {here.string(), newer_than_latest(here, newer)};
    return {here.string(),
            fmt::format("{} is {}; the service has another one, {}", given, here.string(), there.string())};
  }
  const fs::path there = at_service(name, socket);
  if (there.empty()) return {given};
  return {there.string(), newer_than_latest(there, newer)};
}

CLI::Option* takes_run_name(CLI::Option* option, ParsedLine& line, Newer newer) {
  return option->transform(CLI::Validator(
      [&line, newer](std::string& given) {
        NamedRun run = run_named(given, control::default_socket(), newer);
        if (!run.note.empty()) line.notes.push_back(std::move(run.note));
        given = std::move(run.path);
        return std::string();
      },
      ""));
}

}  // namespace eha::cli
