// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "config/measured_check.hpp"
#include "config/rig_config.hpp"
#include "core/free_name.hpp"
#include "core/os/files.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/calibration_readings.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kCalibrateFooter = R"(
Finds scale and offset of the displacement sensor from positions measured with a ruler, and moves nothing: place the rod
yourself, by eha goto or with the hydraulics off. Asks for each position and reads the sensor there for 1 s; an empty line
ends. A position far beyond the travel limits is not taken. Positions with their voltages, as eha read shows them, can also come from --at or a CSV file. Needs at least 3.
A decimal comma is taken, too: 74,989mm=4,921.
Least squares give scale and offset with standard errors. The residual of each position is shown; with one beyond the
tolerance nothing is written, nor where places shift by more than 0.1 in (2.54 mm) on a rig whose [following] was
measured by the old calibration: the ruler was read from another zero, or the sensor was moved (--sensor-moved). Lengths are shown in --units, else in the units of the rig file; so is a number without a
unit read. Writes a new rig file, in which only scale, offset and calibration date differ, and gains of [following] that
were measured with the old scale; comments stay. With units = "mm" in the file the new values are in millimetres. No
file is overwritten.

Examples:
  eha calibrate
  eha calibrate --rig rig.toml --at 0.5in=0.833 --at 2.95in=4.917 --at 5.4in=9.000
  eha calibrate --rig rig.toml --at 10mm=0.656 --at 75mm=4.921 --at 140mm=9.186 --tolerance 0.5mm
  eha calibrate --rig rig.toml --pairs positions.csv -o rig-new.toml)";

struct CalibrateCommand {
  std::vector<std::string> at = {};                  ///< POSITION=VOLTS
  std::optional<std::string> pairs_file = {};        ///< CSV: position_in, voltage_V
  std::optional<std::filesystem::path> socket = {};  ///< none: the default one, or the rig if no service answers
  std::optional<std::string> rig_file = {};          ///< none: the service's, or default_rig_file()
  bool local = false;                                ///< read the rig in this process
  std::string tolerance = "0.02in";                  ///< with a residual beyond it nothing is written
  std::optional<std::filesystem::path> output = {};  ///< none: beside the rig file, with the date in its name
  bool sensor_moved = false;                         ///< places may shift against the limits of a measured rig
};

constexpr int kReadings = 50;
constexpr auto kBetweenReadings = std::chrono::milliseconds(20);

/// Reads the sensor's voltage [V].
using VoltageReader = std::function<double()>;

double mean_voltage(const VoltageReader& read) {
  double sum_V = 0.0;
  for (int i = 0; i < kReadings; ++i) {
    if (i > 0) std::this_thread::sleep_for(kBetweenReadings);
    sum_V += read();
  }
  return sum_V / kReadings;
}

/// Reads the rig of this process, or the service's.
class Sensor {
 public:
  Sensor(const CalibrateCommand& command, const fs::path& socket, bool is_local, const config::RigConfig& config) {
    if (!is_local) {
      socket_ = command.socket.value_or(socket);
      client_ = std::make_unique<control::Client>(socket_);
      return;
    }
    require_local_rig_file(config);
    rig_ = open_at_rest(config);
  }

  /// Before the first question. @throws UsageError  a run is on; DeviceError  the sensor cannot be read
  void require_readable() { static_cast<void>(rig_ ? of_rig() : of_service()); }

  /// By the last reading.
  [[nodiscard]] bool is_armed() const noexcept { return is_armed_; }

  [[nodiscard]] double voltage_V() {
    return mean_voltage([this] { return rig_ ? of_rig() : of_service(); });
  }

 private:
  [[nodiscard]] double of_rig() {
    hal::RigReading reading;
    elapsed_ns_ += std::chrono::nanoseconds(kBetweenReadings).count();
    if (rig_->read(elapsed_ns_, reading) != hal::RigStatus::ok) {
      throw DeviceError("the rig cannot be read; eha doctor says more");
    }
    return reading.feedback_V;
  }
  [[nodiscard]] double of_service() {
    if (!client_) client_ = std::make_unique<control::Client>(socket_);
    Json status;
    try {
      status = client_->call("status");
    } catch (const control::ConnectionLost&) {
      client_.reset();  // the next reading connects anew
      throw;
    }
    if (!status.at("run").is_null()) throw UsageError("a run is on");
    is_armed_ = status.at("state") == "armed";
    const Json rod = status.value("rod", Json());
    if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
    if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
    return rod.at("feedback_V");
  }

  fs::path socket_;
  std::unique_ptr<control::Client> client_;
  std::unique_ptr<hal::Rig> rig_;
  std::int64_t elapsed_ns_ = 0;
  bool is_armed_ = false;
};

constexpr const char* kArmed =
    "the rig is armed, and its holder may move the rod at any moment: `eha disarm` before you hold a ruler to it";

/// Says of a position where no rod of this rig can be that it is one; empty for others. Millimetres taken for inches
/// make a scale that is 25 times wrong.
std::string beyond_the_rig(double position_in, const config::RigConfig& rig, const DisplayUnit& unit) {
  constexpr double kBeyond = 0.2;  // of the travel: a rod at its end stop, with limits and offset that are still rough
  const config::RigLimits& limits = rig.limits;
  const double margin_in = kBeyond * (limits.travel_max_in - limits.travel_min_in);
  if (position_in > limits.travel_min_in - margin_in && position_in < limits.travel_max_in + margin_in) return {};
  const double factor = unit.factor("in");
  return fmt::format(
      "the position {0:.4g} {1} lies far beyond the travel limits of {2}, {3:.4g} to {4:.4g} {1}; write the unit of "
      "the ruler (75mm, 2.95in), or correct the limits there first",
      factor * position_in, unit.of("in"), rig.file_name, factor * limits.travel_min_in, factor * limits.travel_max_in);
}

/// Adds the typed positions until an empty line.
void ask_points(std::vector<CalibrationPoint>& points, Sensor& sensor, const config::RigConfig& rig,
                const DisplayUnit& unit, Console& console) {
  for (std::string line;;) {
    std::cerr << fmt::format("position {} [{}]: ", points.size() + 1, unit.of("in")) << std::flush;
    if (!std::getline(std::cin, line) || line.empty()) break;
    const std::optional<double> position_in = inches_of(with_decimal_point(line), unit);
    if (!position_in) {
      console.warning(fmt::format("\"{}\": expected a length, such as 75mm or 2.95in", line));
      continue;
    }
    if (const std::string beyond = beyond_the_rig(*position_in, rig, unit); !beyond.empty()) {
      console.warning("not taken: " + beyond);
      continue;
    }
    try {
      points.push_back({*position_in, sensor.voltage_V()});
    } catch (const Error& error) {
      console.warning(fmt::format("not taken: {}; {} kept, type this position again when that is over", error.what(),
                                  points.size() == 1 ? "the reading before it is"
                                                     : fmt::format("the {} readings before it are", points.size())));
      continue;
    }
    console.info(
        fmt::format("{:.3f} {} at {:.4f} V", unit.factor("in") * *position_in, unit.of("in"), points.back().voltage_V));
  }
}

/// Reads positions of the ruler with the sensor's voltages, until they fit a line. If they do not suffice, keeps them
/// and asks for more.
std::vector<CalibrationPoint> asked_points(Sensor& sensor, const config::RigConfig& rig, const DisplayUnit& unit,
                                           Console& console) {
  console.info(
      fmt::format("nothing is moved here: place the rod, read the ruler, type the position (75mm, 2.95in; a number "
                  "alone is in {}); an empty line ends",
                  unit.of("in")));
  std::vector<CalibrationPoint> points;
  for (;;) {
    const std::size_t before = points.size();
    ask_points(points, sensor, rig, unit, console);
    if (points.size() == before) return points;
    try {
      static_cast<void>(calibrated(points, unit));
      return points;
    } catch (const DataError& error) {
      console.warning(fmt::format("{}; the {} readings are kept: type further ones, or an empty line to end",
                                  error.what(), points.size()));
    }
  }
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(now));
}

/// Writes a file that must not exist yet.
void write_new(const fs::path& path, const std::string& text) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) {
    throw UsageError(
        fmt::format("{}: exists already, and no rig file is overwritten; name another one with -o", path.string()));
  }
  os::write_file_atomically(path, text);
}

/// @throws DataError  a position is off the line by more than the tolerance
/// @param range_V  of the input converter
void report(const std::vector<CalibrationPoint>& points, const Calibration& found, double tolerance_in, double range_V,
            const DisplayUnit& unit, const Console& console) {
  const std::string in = unit.of("in");
  const double factor = unit.factor("in");
  const double least_in = rounding_in(found, range_V);
  const bool is_exact = found.residual_std < least_in;
  const auto half_width = [&](double std, double least) {
    return factor * found.interval_factor * std::max(std, least);
  };
  const double least_scale = least_in / std::sqrt(found.voltage_squares_V2);
  const double least_offset = least_in * std::sqrt(1.0 / static_cast<double>(points.size()) +
                                                   found.mean_V * found.mean_V / found.voltage_squares_V2);
  std::string text = fmt::format(
      "displacement in {0} = {1:.6g} + {2:.6g} V   (scale +- {5}{3:.2g} {0}/V, offset +- {5}{4:.2g} {0}; +- is half a "
      "95 % interval)\n",
      in, factor * found.offset_in, factor * found.scale_in_per_V, half_width(found.scale_std, least_scale),
      half_width(found.offset_std, least_offset), is_exact ? "at least " : "");
  if (is_exact) {
    text +=
        "The readings lie on one line: the intervals are of the sensor's resolution, the ruler's error is not in "
        "them.\n";
  }
  text += fmt::format("  {:>12}  {:>10}  {:>12}\n", "position " + in, "sensor V", "residual " + in);
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += fmt::format("  {:>12.4f}  {:>10.4f}  {:>+12.4f}\n", factor * points[i].position_in, points[i].voltage_V,
                        factor * found.residuals_in[i]);
  }
  console.print(text);
  const auto is_off = [&](double residual_in) { return std::abs(residual_in) > tolerance_in; };
  if (std::none_of(found.residuals_in.begin(), found.residuals_in.end(), is_off)) return;
  if (const auto lone = lone_point(points, tolerance_in)) {
    throw DataError(fmt::format(
        "nothing is written: {0:.4g} {1} is {2:.2g} {1} off the line through the others; without it the others are "
        "within {3:.4f} {1} of theirs, {4:.3g} {1} are allowed: measure that position again, or leave it out",
        factor * points[lone->index].position_in, in, factor * std::abs(lone->off_in), factor * lone->others_in,
        factor * tolerance_in));
  }
  double worst_in = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off_in = std::abs(found.residuals_in[i]);
    if (off_in <= tolerance_in) continue;
    worst_in = std::max(worst_in, off_in);
    console.warning(fmt::format("{:.4f} {}: {:.4f} {} off the line, tolerance {:.4g} {}; measure it again",
                                factor * points[i].position_in, in, factor * found.residuals_in[i], in,
                                factor * tolerance_in, in));
  }
  throw DataError(fmt::format(
      "nothing is written: positions and voltages are up to {:.3g} {} off a line, {:.3g} {} are allowed; measure the "
      "positions again that are named above, or allow more with --tolerance",
      factor * worst_in, in, factor * tolerance_in, in));
}

/// The same calibration of a sensor that was moved, by the readings that were taken.
std::string as_moved(const CalibrateCommand& command, std::span<const CalibrationPoint> points,
                     const config::RigConfig& rig, const DisplayUnit& unit) {
  std::string line = "eha calibrate";
  if (!rig.file_name.empty()) line += " --rig " + shell_word(rig.file_name);
  for (const CalibrationPoint& point : points) {
    line += fmt::format(" --at {:.6g}{}={:.6g}", unit.factor("in") * point.position_in, unit.of("in"), point.voltage_V);
  }
  if (command.tolerance != CalibrateCommand{}.tolerance) line += " --tolerance " + shell_word(command.tolerance);
  if (command.output) line += " -o " + shell_word(command.output->string());
  return line + " --sensor-moved";
}

/// Another calibration, with readings of its own.
/// @param written  by this one
std::string anew(const CalibrateCommand& command, const config::RigConfig& rig, const fs::path& written) {
  std::string line = "eha calibrate";
  if (command.rig_file && !rig.file_name.empty()) line += " --rig " + shell_word(rig.file_name);
  if (command.local) line += " --local";
  if (command.tolerance != CalibrateCommand{}.tolerance) line += " --tolerance " + shell_word(command.tolerance);
  if (command.sensor_moved) line += " --sensor-moved";
  line += " -o " + shell_word(next_free_name(written.string()));
  return command.socket ? through(*command.socket, std::move(line)) : line;
}

bool is_writable(const fs::path& folder) { return ::access((folder.empty() ? "." : folder).c_str(), W_OK) == 0; }

/// Where a new rig file goes: beside the old one or, as of the service's, which is root's, into the working folder.
fs::path folder_for(const fs::path& old_rig_file) {
  const fs::path beside = old_rig_file.parent_path();
  return is_writable(beside) ? beside : fs::path();
}

/// Before anybody takes readings that could not be kept. @throws PermissionError
void require_writable_folder(const fs::path& file) {
  const fs::path folder = file.parent_path();
  if (is_writable(folder)) return;
  throw PermissionError(fmt::format("{}: nothing can be written into {}; -o names a file elsewhere", file.string(),
                                    folder.empty() ? "the working folder" : folder.string()));
}

ExitCode execute(const CalibrateCommand& command, Console& console) {
  std::error_code ignored;
  const fs::path socket = command.socket.value_or(control::default_socket());
  const bool is_local = command.local || (!command.socket && !fs::exists(socket, ignored));
  const bool asks = command.at.empty() && !command.pairs_file;
  std::optional<std::string> of_service;
  if (!is_local) {
    try {
      of_service = control::Client(socket).call("status").at("rig").at("file").get<std::string>();
    } catch (const DeviceError&) {
      if (!command.rig_file) throw;
    }
  }
  const config::RigConfig rig = load_rig_or_default(command.rig_file ? command.rig_file : of_service);
  const std::string date = today();
  const fs::path old(rig.file_name);
  const fs::path path = command.output.value_or(folder_for(old) / fmt::format("{}-{}.toml", old.stem().string(), date));
  if (asks) require_writable_folder(path);
  if (const std::string typed = typed_unit(command.at); !typed.empty()) console.take_typed_unit(typed);
  const DisplayUnit unit = console.unit(rig.units);
  const std::optional<double> tolerance_in = inches_of(command.tolerance, unit);
  if (!tolerance_in || !(*tolerance_in > 0.0)) {
    throw UsageError(
        fmt::format("--tolerance {}: expected a length above 0, such as 0.5mm or 0.02in", command.tolerance));
  }
  std::vector<CalibrationPoint> points;
  if (asks) {
    Sensor sensor(command, socket, is_local, rig);
    try {
      sensor.require_readable();
      if (sensor.is_armed()) console.warning(kArmed);
    } catch (const Error& error) {  // each reading is tried anew
      console.warning(
          fmt::format("{}: until that is over, which `eha status` shows, no reading is taken", error.what()));
    }
    points = asked_points(sensor, rig, unit, console);
  } else if (command.pairs_file) {
    points = points_of_file(*command.pairs_file);
  } else {
    for (const std::string& pair : command.at) points.push_back(point_of(pair, unit));
  }
  for (const CalibrationPoint& point : points) {
    const std::string beyond = beyond_the_rig(point.position_in, rig, unit);
    if (!beyond.empty()) throw DataError("nothing is written: " + beyond);
  }
  const Calibration found = calibrated(points, unit);
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  report(points, found, *tolerance_in, conversion.feedback_max_V - conversion.feedback_min_V, unit, console);
  if (hal::conversion_of(rig.backend).scale_in_per_V * found.scale_in_per_V < 0.0) {
    throw DataError(fmt::format(
        "nothing is written: the scale has the opposite sign of that in {}: was the ruler read from the other end? If "
        "the sensor was really turned round, change the sign of its scale there first",
        rig.file_name));
  }
  const bool is_of_service = of_service && fs::equivalent(rig.file_name, *of_service, ignored);
  const auto set_rig = [&](const std::string& file) {
    console.set_rig(is_of_service                     ? access_of(DriveOptions{.socket = socket})
                    : hal::moves_machine(rig.backend) ? access_of(DriveOptions{.rig_file = file, .local = true})
                                                      : simulated_access(file));
  };
  set_rig(rig.file_name);
  const std::string shift = shift_text(rig, found, unit);
  if (!shift.empty() && config::is_as_measured(rig) && !command.sensor_moved) {
    throw DataError(fmt::format(
        "nothing is written, because the rig has been driven by the old calibration: {}. Only if the sensor was "
        "exchanged or moved: {}",
        shift, as_moved(command, points, rig, unit)));
  }
  const std::string text = calibrated_rig_text(rig, found, date);
  write_new(path, text);
  set_rig(path.string());  // what is said below is for the new file, once it is in force
  if (config::is_as_measured(rig) && !config::is_as_measured(config::parse_rig(text, path.string()))) {
    console.warning(
        "the scale differs so much from that in the rig file that [following] no longer counts as measured, and the "
        "rig is not armed with it: see that all positions are in one unit; once the new file is in force, "
        "`eha characterise --without-following -o rig-bare.toml` and its Next measure it anew");
  }
  const std::string doubt = doubt_about(points, found, unit);
  if (!doubt.empty()) console.warning(doubt);
  const PlaceShift moved = greatest_shift(rig, found);
  if (!shift.empty()) {
    console.warning(shift);
  } else {
    console.info(fmt::format("against {} the places shift by {:+.2g} {} at most, at {:.4g} {}", rig.file_name,
                             unit.factor("in") * moved.by_in, unit.of("in"), unit.factor("in") * moved.at_in,
                             unit.of("in")));
  }
  Json list = Json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    list.push_back({{"position_in", points[i].position_in},
                    {"voltage_V", points[i].voltage_V},
                    {"residual_in", found.residuals_in[i]}});
  }
  console.print_json({{"schema", "eha-calibration/1"},
                      {"rig", rig.file_name},
                      {"file", path.string()},
                      {"date", date},
                      {"scale_in_per_V", found.scale_in_per_V},
                      {"scale_std", found.scale_std},
                      {"offset_in", found.offset_in},
                      {"offset_std", found.offset_std},
                      {"residual_std_in", found.residual_std},
                      {"points", std::move(list)}});
  console.info(fmt::format("written: {}; {} stays as it is", path.string(), rig.file_name));
  const std::string made = shell_word(path.string());
  if (of_service && !is_of_service) {
    console.info(fmt::format("ehad uses {}, which these numbers do not replace", *of_service));
  }
  if (!doubt.empty()) {  // before it is put in force
    console.next_step(anew(command, rig, path));
    return ExitCode::ok;
  }
  // Places that shift are compared with the ruler before the rig is armed.
  const InForce then = shift.empty() ? InForce::arm : InForce::read;
  console.next_step("eha check " + made +
                    (is_of_service ? " && " + put_in_force(path, *of_service, socket, then) : ""));
  return ExitCode::ok;
}

}  // namespace

void add_calibrate(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("calibrate", "Calibrate the displacement sensor with a ruler");
  sub->footer(kCalibrateFooter);
  auto& calibrate = options_of<CalibrateCommand>(*sub, line);
  CLI::Option* at = sub->add_option("--at", calibrate.at,
                                    "A position and the sensor's voltage there, such as 75mm=4.921 or 2.95in=4.917")
                        ->type_name("POSITION=VOLTS");
  CLI::Option* pairs =
      sub->add_option("--pairs", calibrate.pairs_file, "CSV file with position_mm or position_in, and voltage_V")
          ->type_name("FILE")
          ->excludes(at);
  CLI::Option* local = sub->add_flag("--local", calibrate.local, "Read the rig in this process, not through ehad");
  local->excludes(at)->excludes(pairs);
  add_socket_option(*sub, calibrate.socket)->excludes(local);
  sub->add_option("--rig", calibrate.rig_file,
                  "Rig file (TOML) to start from (default: the service's, or the default one)")
      ->type_name("RIG");
  sub->add_option("--tolerance", calibrate.tolerance,
                  "With a residual beyond it nothing is written, such as 0.5mm (default 0.508mm, 0.02in)")
      ->type_name("LENGTH");
  sub->add_flag(
      "--sensor-moved", calibrate.sensor_moved,
      "The sensor was exchanged or moved: places may shift by more than 2.54 mm (0.1 in) although [following] was "
      "measured by the old calibration");
  sub->add_option(
         "-o,--output", calibrate.output,
         "The new rig file (default NAME-DATE.toml beside the old one, or here where that folder cannot be written)")
      ->type_name("FILE");
}

}  // namespace eha::cli
