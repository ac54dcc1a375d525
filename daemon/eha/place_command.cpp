// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/rod_status.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backend.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

/// The longest way is some inches at 0.3 in/s or slower; see place::placing_time_s for what a way should take.
constexpr double kTimeOut_s = 120.0;

/// Where the rod is, and the unit that the rig file asks for.
struct PlaceNow {
  double place_in = 0.0;
  std::string units = {};
};

PlaceNow place_now_of_service(const PlaceCommand& command) {
  control::Client client(command.socket);
  const Json status = status_with_rod(client);
  if (!status.at("run").is_null()) throw UsageError("a run is on; eha jog moves from where the rod stands after it");
  const Json rod = status.value("rod", Json());
  if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
  if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
  return {rod.at("displacement_in"), status.at("rig").value("units", "")};
}

PlaceNow place_now_of_rig(const PlaceCommand& command) {
  const config::RigConfig config = load_rig_or_default(command.rig_file);
  require_trusted_rig_file(config);
  const std::unique_ptr<hal::Rig> rig = hal::open(config.backend, config.limits.safe_V);
  hal::RigReading reading;
  if (rig->read(0, reading) != hal::RigStatus::ok) throw DeviceError("the rig cannot be read; eha doctor says more");
  return {reading.displacement_in, config.units};
}

}  // namespace

ExitCode execute(const PlaceCommand& command, Console& console) {
  const std::optional<double> length_in = inches_of(command.where);
  if (!length_in) {
    throw UsageError(fmt::format("\"{}\": expected a length with its unit, such as {}", command.where,
                                 command.is_relative ? "+0.2in or -5mm" : "2.95in or 75mm"));
  }
  double target_in = *length_in;
  if (command.is_relative) {
    const PlaceNow now = command.local ? place_now_of_rig(command) : place_now_of_service(command);
    target_in += now.place_in;
    const DisplayUnit unit = console.unit(now.units);
    console.info(fmt::format("from {:.3f} to {:.3f} {}", unit.factor("in") * now.place_in,
                             unit.factor("in") * target_in, unit.of("in")));
  }
  const char* name = command.is_relative ? "jog" : "goto";
  RunCommand run{command};
  run.experiment_file = fmt::format("{} {}", name, command.where);
  run.text = fmt::format("schema = 1\nname = \"{}\"\nduration_s = {:g}\n\n[place]\ndisplacement_in = {:.4f}\n", name,
                         kTimeOut_s, target_in);
  return execute(run, console);
}

}  // namespace eha::cli
