// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/rig_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "config/file_kind.hpp"
#include "config/toml_section.hpp"

namespace eha::config {
namespace {

constexpr auto kBackends =
    std::to_array<std::pair<std::string_view, Backend>>({{"sim", Backend::sim}, {"comedi", Backend::comedi}});
constexpr auto kReferences =
    std::to_array<std::pair<std::string_view, hal::AnalogReference>>({{"ground", hal::AnalogReference::ground},
                                                                      {"common", hal::AnalogReference::common},
                                                                      {"diff", hal::AnalogReference::diff},
                                                                      {"other", hal::AnalogReference::other}});
constexpr auto kLevels = std::to_array<std::pair<std::string_view, hal::ActiveLevel>>(
    {{"high", hal::ActiveLevel::high}, {"low", hal::ActiveLevel::low}});

using Sim = hal::SimOptions;
/// What they may be is hal's to say: check(SimOptions).
constexpr auto kSimNumbers = std::to_array<std::pair<std::string_view, double Sim::*>>({
    {"bore_mm", &Sim::bore_mm},
    {"rod_mm", &Sim::rod_mm},
    {"stroke_mm", &Sim::stroke_mm},
    {"initial_displacement_in", &Sim::initial_displacement_in},
    {"cap_dead_volume_cm3", &Sim::cap_dead_volume_cm3},
    {"rod_dead_volume_cm3", &Sim::rod_dead_volume_cm3},
    {"leakage_cm3_per_s_per_bar", &Sim::leakage_cm3_per_s_per_bar},
    {"moving_mass_kg", &Sim::moving_mass_kg},
    {"end_stop_stiffness_N_per_mm", &Sim::end_stop_stiffness_N_per_mm},
    {"end_stop_damping_N_s_per_mm", &Sim::end_stop_damping_N_s_per_mm},
    {"coulomb_friction_N", &Sim::coulomb_friction_N},
    {"static_friction_N", &Sim::static_friction_N},
    {"viscous_friction_N_s_per_mm", &Sim::viscous_friction_N_s_per_mm},
    {"stribeck_velocity_mm_per_s", &Sim::stribeck_velocity_mm_per_s},
    {"friction_regularisation_mm_per_s", &Sim::friction_regularisation_mm_per_s},
    {"bulk_modulus_bar", &Sim::bulk_modulus_bar},
    {"supply_pressure_bar", &Sim::supply_pressure_bar},
    {"tank_pressure_bar", &Sim::tank_pressure_bar},
    {"valve_full_scale_V", &Sim::valve_full_scale_V},
    {"valve_rated_flow_L_per_min", &Sim::valve_rated_flow_L_per_min},
    {"valve_rated_drop_bar", &Sim::valve_rated_drop_bar},
    {"valve_natural_frequency_Hz", &Sim::valve_natural_frequency_Hz},
    {"valve_damping_ratio", &Sim::valve_damping_ratio},
    {"valve_dead_band_V", &Sim::valve_dead_band_V},
    {"valve_null_offset_V", &Sim::valve_null_offset_V},
    {"command_min_V", &Sim::command_min_V},
    {"command_max_V", &Sim::command_max_V},
    {"feedback_min_V", &Sim::feedback_min_V},
    {"feedback_max_V", &Sim::feedback_max_V},
    {"scale_in_per_V", &Sim::scale_in_per_V},
    {"offset_in", &Sim::offset_in},
    {"sensor_noise_V", &Sim::sensor_noise_V},
    {"sub_step_us", &Sim::sub_step_us},
});
static_assert(sizeof(Sim) == (kSimNumbers.size() + 2) * sizeof(double), "each member of SimOptions needs its key here");

void read_limits(Section& root, RigLimits& limits) {
  auto section = root.section("limits");
  if (!section) return;
  section->number("command_min_V", limits.command_min_V, Range::between(-10.0, 10.0));
  section->number("command_max_V", limits.command_max_V, Range::between(-10.0, 10.0));
  section->number("slew_V_per_s", limits.slew_V_per_s, Range::above(0.0));
  section->number("safe_V", limits.safe_V, Range::between(-10.0, 10.0));
  section->number("travel_min_in", limits.travel_min_in, Range::any());
  section->number("travel_max_in", limits.travel_max_in, Range::any());
  section->number("stopping_deceleration_in_per_s2", limits.stopping_deceleration_in_per_s2, Range::above(0.0));
  section->number("velocity_limit_in_per_s", limits.velocity_limit_in_per_s, Range::above(0.0));
  section->number("frozen_sensor_s", limits.frozen_sensor_s, Range::at_least(0.0));
  section->finish();
}

void read_realtime(Section& root, RealtimeOptions& realtime) {
  auto section = root.section("realtime", Need::optional);
  if (!section) return;
  section->number("sample_period_s", realtime.sample_period_s, Range::between(1e-4, 1.0), Need::optional);
  section->integer("priority", realtime.priority, 1, 99, Need::optional);
  section->integer("cpu", realtime.cpu, 0, 1023);
  section->integer("abort_consecutive_late", realtime.abort_consecutive_late, 1, 1'000'000, Need::optional);
  section->integer("abort_total_late", realtime.abort_total_late, 1, 1'000'000, Need::optional);
  section->finish();
}

void read_sim(Section& root, Sim& sim) {
  auto section = root.section("sim");
  if (!section) return;
  for (const auto& [key, member] : kSimNumbers) section->number(key, sim.*member, Range::any(), Need::optional);
  section->integer("resolution_bits", sim.resolution_bits, 8, 24, Need::optional);
  section->integer("seed", sim.seed, 0, std::numeric_limits<std::int64_t>::max(), Need::optional);
  section->finish();
}

void read_channel(Section& comedi, std::string_view key, hal::AnalogChannel& channel) {
  auto section = comedi.section(key);
  if (!section) return;
  section->integer("subdevice", channel.subdevice, 0, 255);
  section->integer("channel", channel.channel, 0, 255);
  section->choice("reference", channel.reference, kReferences);
  section->number("range_min_V", channel.range_min_V, Range::any());
  section->number("range_max_V", channel.range_max_V, Range::any());
  section->finish();
}

void read_line(Section& comedi, std::string_view key, std::optional<hal::DigitalLine>& line) {
  auto section = comedi.section_or_none(key);
  if (!section) return;
  line.emplace();
  section->integer("subdevice", line->subdevice, 0, 255);
  section->integer("channel", line->channel, 0, 31);
  section->choice("active", line->active, kLevels);
  section->finish();
}

void read_comedi(Section& root, hal::ComediOptions& comedi) {
  auto section = root.section("comedi");
  if (!section) return;
  section->text("device", comedi.device);
  section->text("board", comedi.board);
  section->text("driver", comedi.driver);
  section->integer("resolution_bits", comedi.resolution_bits, 1, 31);
  read_channel(*section, "feedback", comedi.feedback);
  section->number("feedback_settling_us", comedi.feedback_settling_us, Range::any(), Need::optional);
  read_channel(*section, "command", comedi.command);
  read_line(*section, "emergency_stop", comedi.emergency_stop);
  read_line(*section, "enable", comedi.enable);
  read_line(*section, "heartbeat", comedi.heartbeat);
  section->number("scale_in_per_V", comedi.scale_in_per_V, Range::any());
  section->number("offset_in", comedi.offset_in, Range::any());
  section->text("calibration_date", comedi.calibration_date);
  section->finish();
}

/// The voltages and displacements that the backend's converters can express.
struct ConverterRanges {
  double command_min_V = 0.0;
  double command_max_V = 0.0;
  double feedback_min_V = 0.0;
  double feedback_max_V = 0.0;
  double scale_in_per_V = 0.0;
  double offset_in = 0.0;
};

ConverterRanges ranges_of(const RigConfig& rig) {
  if (rig.backend == Backend::sim) {
    return {rig.sim.command_min_V,  rig.sim.command_max_V,  rig.sim.feedback_min_V,
            rig.sim.feedback_max_V, rig.sim.scale_in_per_V, rig.sim.offset_in};
  }
  return {rig.comedi.command.range_min_V,  rig.comedi.command.range_max_V, rig.comedi.feedback.range_min_V,
          rig.comedi.feedback.range_max_V, rig.comedi.scale_in_per_V,      rig.comedi.offset_in};
}

/// What single keys cannot show. Pairs with a fault of their own are left alone.
class LimitChecks {
 public:
  LimitChecks(const RigConfig& rig, Document& document) : rig_(rig), document_(document) {}

  void run() {
    const RigLimits& limits = rig_.limits;
    const bool command_is_read = read("command_min_V") && read("command_max_V");
    const bool travel_is_read = read("travel_min_in") && read("travel_max_in");
    if (command_is_read && !(limits.command_min_V < limits.command_max_V)) {
      fault("command_max_V", fmt::format("more than command_min_V = {}", limits.command_min_V), limits.command_max_V);
    } else if (command_is_read && read("safe_V") &&
               !Range::between(limits.command_min_V, limits.command_max_V).contains(limits.safe_V)) {
      fault("safe_V",
            fmt::format("a voltage within command_min_V..command_max_V, {}..{}", limits.command_min_V,
                        limits.command_max_V),
            limits.safe_V);
    }
    if (travel_is_read && !(limits.travel_min_in < limits.travel_max_in)) {
      fault("travel_max_in", fmt::format("more than travel_min_in = {}", limits.travel_min_in), limits.travel_max_in);
    }
    if (!document_.faults.clean(rig_.backend == Backend::sim ? "sim" : "comedi")) return;
    if (command_is_read) check_command_range();
    if (travel_is_read) check_travel_range();
  }

 private:
  [[nodiscard]] bool read(std::string_view key) const {
    const std::string path = fmt::format("limits.{}", key);
    return document_.positions.contains(path) && document_.faults.clean(path);
  }
  void fault(std::string_view key, const std::string& expected, double got) {
    const std::string path = fmt::format("limits.{}", key);
    document_.faults.add(position_of(document_.positions, path), path, expected, fmt::format("{}", got));
  }

  void check_command_range() {
    const ConverterRanges ranges = ranges_of(rig_);
    const Range range = Range::between(ranges.command_min_V, ranges.command_max_V);
    const std::string expected = fmt::format("a voltage within the output converter's {}..{}", range.low, range.high);
    if (!range.contains(rig_.limits.command_min_V)) fault("command_min_V", expected, rig_.limits.command_min_V);
    if (!range.contains(rig_.limits.command_max_V)) fault("command_max_V", expected, rig_.limits.command_max_V);
  }

  void check_travel_range() {
    const ConverterRanges ranges = ranges_of(rig_);
    const double at_min = ranges.offset_in + ranges.scale_in_per_V * ranges.feedback_min_V;
    const double at_max = ranges.offset_in + ranges.scale_in_per_V * ranges.feedback_max_V;
    const Range range = Range::between(std::min(at_min, at_max), std::max(at_min, at_max));
    const std::string expected =
        fmt::format("a displacement that the sensor can show, {:.6g}..{:.6g}", range.low, range.high);
    if (!range.contains(rig_.limits.travel_min_in)) fault("travel_min_in", expected, rig_.limits.travel_min_in);
    if (!range.contains(rig_.limits.travel_max_in)) fault("travel_max_in", expected, rig_.limits.travel_max_in);
    if (rig_.backend != Backend::sim) return;
    const Range travel = Range::between(rig_.limits.travel_min_in, rig_.limits.travel_max_in);
    if (travel.low < travel.high && !travel.contains(rig_.sim.initial_displacement_in)) {
      const std::string key = "sim.initial_displacement_in";
      document_.faults.add(position_of(document_.positions, key), key,
                           fmt::format("a displacement within the limits' travel, {}..{}", travel.low, travel.high),
                           fmt::format("{}", rig_.sim.initial_displacement_in));
    }
  }

  const RigConfig& rig_;
  Document& document_;
};

/// Faults that the backend finds in its options, except where a value could not even be read.
void add_backend_faults(const std::vector<hal::OptionFault>& faults, const std::string& section, Document& document) {
  for (const hal::OptionFault& fault : faults) {
    const std::string path = fmt::format("{}.{}", section, fault.key);
    if (!document.faults.clean(path)) continue;
    document.faults.add_text(position_of(document.positions, path), path, fault.message);
  }
}

}  // namespace

RigConfig parse_rig(std::string_view text, const std::string& file_name) {
  Document document = parse_document(text, file_name);
  RigConfig rig;
  rig.file_name = file_name;
  rig.text = std::string(text);
  Section root = Section::root(document);
  int schema = 0;
  root.integer("schema", schema, 1, 1);
  root.text("name", rig.name);
  root.choice("backend", rig.backend, kBackends);
  read_limits(root, rig.limits);
  read_realtime(root, rig.realtime);
  const bool backend_is_known = document.positions.contains("backend") && document.faults.clean("backend");
  if (!backend_is_known) {
    // Without a backend nothing can be said about its table.
    root.ignore("sim");
    root.ignore("comedi");
  } else if (rig.backend == Backend::sim) {
    read_sim(root, rig.sim);
    root.forbid("comedi", "backend = \"sim\"");
    if (document.root.contains("sim")) add_backend_faults(hal::check(rig.sim), "sim", document);
  } else {
    read_comedi(root, rig.comedi);
    root.forbid("sim", "backend = \"comedi\"");
    if (document.root.contains("comedi")) add_backend_faults(hal::check(rig.comedi), "comedi", document);
  }
  root.finish();
  if (backend_is_known) LimitChecks(rig, document).run();
  document.faults.throw_if_any();
  rig.positions = std::move(document.positions);
  return rig;
}

RigConfig load_rig(const std::string& path) { return parse_rig(read_config_file(path), path); }

}  // namespace eha::config
