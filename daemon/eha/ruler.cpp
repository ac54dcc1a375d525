// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/ruler.hpp"

#include <fmt/format.h>
#include <unistd.h>

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
#include "daemon/rig/ruler_check.hpp"
#include "daemon/rig/trusted_file.hpp"

namespace eha::cli {
namespace {

struct PlaceAndUnits {
  double place_in;
  std::string units;  ///< of the rig
};

/// Returns the rod's position by the sensor; none: the rig moves no machine, or its file has [following].
std::optional<PlaceAndUnits> place_without_following(const DriveOptions& command) {
  if (command.local) {
    const config::RigConfig config = load_rig_or_default(command.rig_file);
    if (!needs_ruler(config)) return std::nullopt;
    require_local_rig_file(config);
    return PlaceAndUnits{place_of(*open_at_rest(config)), config.units};
  }
  control::Client client(command.socket);
  const nlohmann::ordered_json status = status_with_rod(client);
  if (status.at("rig").at("moves") != true || status.at("rig").value("characterised", true)) return std::nullopt;
  const nlohmann::ordered_json rod = status.value("rod", nlohmann::ordered_json());
  if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
  if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
  return PlaceAndUnits{rod.at("displacement_in").get<double>(), status.at("rig").value("units", "")};
}

std::optional<std::string> asked_ruler() {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) return std::nullopt;
  std::cerr << "The rig file has no [following]. Position of the rod by a ruler, such as 2.95in or 75mm: "
            << std::flush;
  std::string line;
  std::getline(std::cin, line);
  return line;
}

}  // namespace

std::optional<double> agreed_ruler(const DriveOptions& command, const std::optional<std::string>& ruler,
                                   const Console& console) {
  const std::optional<PlaceAndUnits> shown = place_without_following(command);
  if (!shown) return std::nullopt;
  const std::optional<std::string> text = ruler ? ruler : asked_ruler();
  const std::optional<double> ruler_in = text ? inches_of(with_decimal_point(*text)) : std::nullopt;
  if (text && !ruler_in) {
    throw UsageError(fmt::format("\"{}\": expected a length with its unit, such as 2.95in or 75mm", *text));
  }
  const DisplayUnit unit = console.unit(shown->units);
  require_agreement_with_ruler(ruler_in, shown->place_in, unit);
  console.info(
      fmt::format("the sensor shows the rod at {0:.3f} {2}, the ruler at {1:.3f} {2}; a scale that is wrong shows "
                  "only away from here: the first minutes are slow, watch the rod and the ruler",
                  unit.factor("in") * shown->place_in, unit.factor("in") * *ruler_in, unit.of("in")));
  return ruler_in;
}

}  // namespace eha::cli
