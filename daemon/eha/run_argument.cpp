// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_argument.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "daemon/control/client.hpp"

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

std::vector<std::string>& notes_on_runs() {
  static std::vector<std::string> list;
  return list;
}

/// The same name among the service's runs; empty without one.
fs::path at_service(const fs::path& name) {
  std::error_code ignored;
  const fs::path socket = control::default_socket();
  if (!fs::exists(socket, ignored)) return {};
  try {
    const fs::path folder = control::Client(socket).call("runs").at("folder").get<std::string>();
    return fs::exists(folder / name, ignored) ? folder / name : fs::path();
  } catch (const Error&) {
    return {};  // no service answers
  }
}

}  // namespace

std::vector<std::string> taken_notes_on_runs() { return std::exchange(notes_on_runs(), {}); }

std::string run_named(const std::string& given) {
  std::error_code ignored;
  fs::path name = fs::path(given).lexically_normal();
  if (fs::exists(name, ignored) || name.is_absolute()) return given;
  if (!name.empty() && *name.begin() == "runs") name = name.lexically_relative("runs");
  if (name.empty() || !may_be_run(name.begin()->string())) return given;
  const fs::path here = "runs" / name;
  if (fs::exists(here, ignored)) {
    // A link that each folder of runs has, so that the name alone says little.
    if (*name.begin() == "latest") {
      const fs::path there = at_service(name);
      if (!there.empty() && !fs::equivalent(here, there, ignored)) {
        notes_on_runs().push_back(
            fmt::format("{} is {}; the service has another one, {}", given, here.string(), there.string()));
      }
    }
    return here.string();
  }
  const fs::path there = at_service(name);
  return there.empty() ? given : there.string();
}

CLI::Option* takes_run_name(CLI::Option* option) {
  return option->transform(CLI::Validator(
      [](std::string& given) {
        given = run_named(given);
        return std::string();
      },
      ""));
}

}  // namespace eha::cli
