// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/rod_status.hpp"
#include "daemon/eha/rod_text.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/place/place_controller.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/rod_view.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kGotoFooter = R"(
Moves the rod slowly (at most 7.6 mm/s, 0.3 in/s) to a place within the travel limits, and ends once it has been within
0.5 mm (0.02 in) of it for 0.5 s; then the rig is safe, with the hydraulics off. It is a run like any other: you must have
armed the rig, a real actuator is moved only after your confirmation, every limit of the rig file holds, Ctrl-C ramps out,
and the way there is recorded. While another experiment is played it waits for that one's end. Null and dead band of the valve are compensated; [following] of the rig file makes it quicker.
Code 11 when a limit or the time-out (120 s) ends it; the message gives the cause.
A rod that stands beyond a travel limit is brought inward, and no further out, after two questions: whether you see it stand
there, and whether to move it. Without a terminal --way-back and --yes answer them. Refused (78) where the rig file cannot show
that the sensor is right: [following] and an open_circuit_V outside the valid band are needed.

Examples:
  eha arm && eha goto 75mm
  eha goto 2.95in --local --fast)";

constexpr const char* kJogFooter = R"(
As eha goto, to a place a little above (+) or below (-) the present one. Moves between runs only.

Examples:
  eha jog +0.2in
  eha jog -5mm)";

/// `eha goto` and `eha jog`: a run whose experiment only moves the rod to a place.
struct PlaceCommand : DriveOptions {
  std::vector<std::string> words = {};  ///< a length with its unit, in one word or two
  bool is_relative = false;             ///< relative to the rod's position
  bool way_back = false;                ///< the user has confirmed that a rod beyond a limit is really there
};

/// The longest move is some inches at 0.3 in/s or slower; place::placing_time_s gives the expected time of a move.
constexpr double kTimeOut_s = 120.0;

/// Position of the rod, its limits, and the unit of the rig file.
struct PlaceNow {
  double place_in = 0.0;
  double lowest_in = 0.0;
  double highest_in = 0.0;
  std::string units = {};
};

PlaceNow place_now_of_service(const PlaceCommand& command) {
  control::Client client(command.socket);
  const Json status = status_with_rod(client);
  if (!status.at("run").is_null()) throw UsageError("a run is on; eha jog moves from where the rod stands after it");
  const Json rod = status.value("rod", Json());
  if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
  if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
  const Json& rig = status.at("rig");
  const Json limits = rig.value("limits", Json());
  if (!limits.is_object()) throw DeviceError("the service has no rig; eha status says more");
  return {rod.at("displacement_in"), limits.at("travel_min_in"), limits.at("travel_max_in"), rig.value("units", "")};
}

PlaceNow place_now_of_rig(const PlaceCommand& command) {
  const config::RigConfig config = load_rig_or_default(command.rig_file);
  require_local_rig_file(config);
  return {place_of(*open_at_rest(config)), config.limits.travel_min_in, config.limits.travel_max_in, config.units};
}

/// Returns the rod before a placing; none during a run, which leaves it elsewhere.
std::optional<PlaceNow> place_before(const PlaceCommand& command) {
  if (command.local) return place_now_of_rig(command);
  control::Client client(command.socket);
  if (!client.call("status").at("run").is_null()) return std::nullopt;
  return place_now_of_service(command);
}

enum class WayBack { not_needed, confirmed, refused };

/// Asks twice before a rod beyond a limit is moved.
WayBack way_back_of(const PlaceCommand& command, const PlaceNow& now, const std::string& place, const DisplayUnit& unit,
                    const Console& console) {
  const std::string beyond = beyond_limit(now.place_in, {now.lowest_in, now.highest_in}, unit);
  if (beyond.empty()) return WayBack::not_needed;
  const std::string stands =
      fmt::format("the sensor says {:.3f} {}, {}", unit.factor("in") * now.place_in, unit.of("in"), beyond);
  const bool can_ask = isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1;
  if (!can_ask && !(command.way_back && command.yes)) {
    throw UsageError(fmt::format(
        "{}; nothing was moved. Look at the rod. If it stands there: the same with --way-back --yes brings it "
        "inward. If not, the sensor is wrong: `eha read`, `eha calibrate`",
        stands));
  }
  if (!command.way_back && !console.confirm(fmt::format("Look at the rod: {}. Does it stand there?", stands))) {
    return WayBack::refused;
  }
  if (!command.yes &&
      !console.confirm(fmt::format("Switch the hydraulics on and bring it inward, slowly, to {}?", place))) {
    return WayBack::refused;
  }
  return WayBack::confirmed;
}

/// Travel limits, and the distance from them that a placing keeps.
struct PlaceLimits {
  Travel travel;
  double margin_in = 0.0;
};

/// Refuses a place that is beyond the travel limits or too near to one, in the unit that the user reads.
void require_within(double target_in, const PlaceLimits& limits, const std::string& where, const DisplayUnit& unit) {
  constexpr double kRounding_in = 1e-9;  // a limit that is typed in another unit
  const double lowest_in = limits.travel.lowest_in - kRounding_in;
  const double highest_in = limits.travel.highest_in + kRounding_in;
  if (target_in >= lowest_in + limits.margin_in && target_in <= highest_in - limits.margin_in) return;
  const double factor = unit.factor("in");
  const std::string length = unit.of("in");
  if (target_in < lowest_in || target_in > highest_in) {
    throw ConfigError(
        fmt::format("{}: {:.6g} {} is beyond the travel limits of the rig, {:.6g} to {:.6g} {}; nothing "
                    "was moved",
                    where, factor * target_in, length, factor * lowest_in, factor * highest_in, length));
  }
  const bool is_low = target_in < lowest_in + limits.margin_in;
  throw ConfigError(fmt::format(
      "{0}: {1:.6g} {4} is too near to the travel limit of {2:.6g} {4}: a place keeps {3:.2g} {4} from it, in "
      "which the rod comes to rest; nothing was moved",
      where, factor * target_in, factor * (is_low ? lowest_in : highest_in), factor * limits.margin_in, length));
}

void require_within_limits(const PlaceCommand& command, double target_in, const std::string& where,
                           const Console& console) {
  if (command.local) {
    const config::RigConfig rig = load_rig_or_default(command.rig_file);
    require_within(target_in, {{rig.limits.travel_min_in, rig.limits.travel_max_in}, config::placing_margin_in(rig)},
                   where, console.unit(rig.units));
    return;
  }
  control::Client client(command.socket);
  const Json rig = client.call("status").at("rig");
  const Json limits = rig.value("limits", Json());
  if (!limits.is_object()) return;
  require_within(target_in,
                 {{limits.at("travel_min_in"), limits.at("travel_max_in")}, limits.value("placing_margin_in", 0.0)},
                 where, console.unit(rig.value("units", "")));
}

ExitCode execute(const PlaceCommand& command, Console& console) {
  console.set_rig(access_of(command));
  const std::string where = fmt::format("{}", fmt::join(command.words, " "));
  const std::optional<double> length_in = inches_of(where);
  if (!length_in) {
    std::string with_point = where;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    if (inches_of(with_point)) {
      throw UsageError(fmt::format("\"{}\": the decimal sign is a point; write {}", where, with_point));
    }
    if (inches_of(where + "in")) {
      throw UsageError(fmt::format("\"{0}\": a length needs its unit; write {0}mm or {0}in", where));
    }
    throw UsageError(fmt::format("\"{}\": expected a length with its unit, such as {}", where,
                                 command.is_relative ? "+0.2in or -5mm" : "2.95in or 75mm"));
  }
  if (!command.is_relative && where.starts_with('+')) {
    throw UsageError(
        fmt::format("\"{0}\": goto takes a place; write {1}, or for a way from where the rod is `eha jog {0}`", where,
                    where.substr(1)));
  }
  console.take_typed_unit(unit_of_length(where));
  double target_in = *length_in;
  std::optional<PlaceNow> now;
  if (command.is_relative) {
    now = command.local ? place_now_of_rig(command) : place_now_of_service(command);
    target_in += now->place_in;
    const DisplayUnit unit = console.unit(now->units);
    console.info(fmt::format("from {:.4g} to {:.4g} {}", unit.factor("in") * now->place_in,
                             unit.factor("in") * target_in, unit.of("in")));
  }
  const char* name = command.is_relative ? "jog" : "goto";
  require_within_limits(command, target_in, fmt::format("{} {}", name, where), console);
  if (!now) now = place_before(command);
  if (now && std::abs(target_in - now->place_in) < place::kTolerance_in) {
    const DisplayUnit unit = console.unit(now->units);
    console.warning(
        fmt::format("{} {}: the rod is within {:.2g} {} of that place, where a placing ends: it may not move", name,
                    where, unit.factor("in") * place::kTolerance_in, unit.of("in")));
  }
  const WayBack way_back =
      now ? way_back_of(command, *now, where, console.unit(now->units), console) : WayBack::not_needed;
  if (way_back == WayBack::refused) {
    console.info("not confirmed; nothing was moved");
    return ExitCode::interrupted;
  }
  RunCommand run{command};
  if (way_back == WayBack::confirmed) run.yes = true;
  run.experiment_file = fmt::format("{} {}", name, where);
  run.text =
      fmt::format("schema = 1\nname = \"{}\"\nduration_s = {:g}\n\n[place]\ndisplacement_in = {:.4f}\n{}{}", name,
                  kTimeOut_s, target_in, command.is_relative ? fmt::format("from_in = {:.4f}\n", now->place_in) : "",
                  way_back == WayBack::confirmed ? "way_back = true\n" : "");
  return execute(run, console);
}

void add_placing(CLI::App& app, const char* name, const char* help, const char* footer, const char* what,
                 ParsedLine& line, PlaceCommand defaults) {
  CLI::App* sub = app.add_subcommand(name, help);
  sub->footer(footer);
  auto& place = options_of(*sub, line, std::move(defaults));
  sub->add_option("where", place.words, what)->required()->expected(1, 2)->type_name("LENGTH");
  sub->add_flag("--way-back", place.way_back, "You see the rod stand beyond a travel limit, where the sensor says");
  add_drive_options(*sub, place);
}

}  // namespace

void add_place_commands(CLI::App& app, ParsedLine& line) {
  add_placing(app, "goto", "Move the rod slowly to a place", kGotoFooter, "The place, such as 2.95in or 75mm", line,
              {});
  PlaceCommand relative;
  relative.is_relative = true;
  add_placing(app, "jog", "Move the rod a little", kJogFooter, "How far, such as +0.2in or -5mm", line, relative);
}

}  // namespace eha::cli
