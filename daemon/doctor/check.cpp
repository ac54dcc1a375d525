// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/check.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace eha::doctor {

Check ok(std::string name, std::string found) {
  return {std::move(name), Level::ok, std::move(found), {}, ExitCode::ok};
}

Check warn(std::string name, std::string found, std::string remedy) {
  return {std::move(name), Level::warn, std::move(found), std::move(remedy), ExitCode::ok};
}

Check fail(std::string name, std::string found, std::string remedy, ExitCode code) {
  return {std::move(name), Level::fail, std::move(found), std::move(remedy), code};
}

ExitCode exit_code(const std::vector<Check>& checks) noexcept {
  constexpr std::array<ExitCode, 4> kWorstFirst{ExitCode::configuration, ExitCode::device_unavailable,
                                                ExitCode::permission, ExitCode::io};
  for (const ExitCode code : kWorstFirst) {
    if (std::any_of(checks.begin(), checks.end(), [code](const Check& check) { return check.code == code; })) {
      return code;
    }
  }
  return ExitCode::ok;
}

std::string_view to_text(Level level) noexcept {
  switch (level) {
    case Level::ok:
      return "ok";
    case Level::warn:
      return "warn";
    case Level::fail:
      break;
  }
  return "fail";
}

}  // namespace eha::doctor
