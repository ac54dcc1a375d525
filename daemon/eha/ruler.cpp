// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/ruler.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <iostream>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/rod_status.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/rod_view.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

/// Greatest difference of the sensor from the ruler [in].
constexpr double kRulerTolerance_in = 0.1;

/// Returns the rod's position by the sensor [in]; none: the rig moves no machine, or its file has [following].
std::optional<double> place_without_following(const DriveOptions& command) {
  if (command.local) {
    const config::RigConfig config = load_rig_or_default(command.rig_file);
    if (config.limits.following || !hal::moves_machine(config.backend)) return std::nullopt;
    require_local_rig_file(config);
    return place_of(*open_at_rest(config));
  }
  control::Client client(command.socket);
  const nlohmann::ordered_json status = status_with_rod(client);
  if (status.at("rig").at("moves") != true || status.at("rig").value("characterised", true)) return std::nullopt;
  const nlohmann::ordered_json rod = status.value("rod", nlohmann::ordered_json());
  if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
  if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
  return rod.at("displacement_in").get<double>();
}

std::string asked_ruler() {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) {
    throw UsageError(
        "the rig file has no [following], so that nothing shows a wrong calibration of the sensor before the rod "
        "moves: read its position off a ruler and add --ruler LENGTH, or calibrate first (`eha calibrate`)");
  }
  std::cerr << "The rig file has no [following]. Position of the rod by a ruler, such as 2.95in or 75mm: "
            << std::flush;
  std::string line;
  std::getline(std::cin, line);
  return line;
}

}  // namespace

void require_agreement_with_ruler(const DriveOptions& command, const std::optional<std::string>& ruler,
                                  const Console& console) {
  const std::optional<double> shown_in = place_without_following(command);
  if (!shown_in) return;
  const std::string text = ruler ? *ruler : asked_ruler();
  const std::optional<double> ruler_in = inches_of(text);
  if (!ruler_in) throw UsageError(fmt::format("\"{}\": expected a length with its unit, such as 2.95in or 75mm", text));
  if (std::abs(*ruler_in - *shown_in) > kRulerTolerance_in) {
    throw ConfigError(
        fmt::format("the sensor shows the rod at {:.3f} in, the ruler at {:.3f} in; they may differ by {:g} in: "
                    "calibrate the sensor "
                    "(`eha calibrate`) before the rod moves",
                    *shown_in, *ruler_in, kRulerTolerance_in));
  }
  console.info(
      fmt::format("the sensor shows the rod at {:.3f} in, the ruler at {:.3f} in; a scale that is wrong shows "
                  "only away from here: the first minutes are slow, watch the rod and the ruler",
                  *shown_in, *ruler_in));
}

}  // namespace eha::cli
