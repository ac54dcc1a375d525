// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_argument.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>

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

}  // namespace

std::string run_named(const std::string& given) {
  std::error_code ignored;
  fs::path name = fs::path(given).lexically_normal();
  if (fs::exists(name, ignored) || name.is_absolute()) return given;
  if (!name.empty() && *name.begin() == "runs") name = name.lexically_relative("runs");
  if (name.empty() || !may_be_run(name.begin()->string())) return given;
  if (const fs::path here = "runs" / name; fs::exists(here, ignored)) return here.string();
  const fs::path socket = control::default_socket();
  if (!fs::exists(socket, ignored)) return given;
  try {
    const fs::path folder = control::Client(socket).call("runs").at("folder").get<std::string>();
    if (const fs::path there = folder / name; fs::exists(there, ignored)) return there.string();
  } catch (const Error&) {
    // No service answers: the search ends here.
  }
  return given;
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
