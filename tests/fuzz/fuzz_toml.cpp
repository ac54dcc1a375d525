// SPDX-License-Identifier: GPL-3.0-or-later
// The readers of rig, experiment and controller files either refuse with ConfigError or return a configuration whose
// limits hold and that a run's manifest can store.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "config/controller_config.hpp"
#include "config/file_kind.hpp"
#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/record/config_json.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using eha::ConfigError;
using eha::config::ExperimentConfig;
using eha::config::FileKind;
using eha::config::RigConfig;
using eha::fuzz::require;

constexpr const char* kFile = "f.toml";
/// A longer table only takes more time.
constexpr double kMostTicks = 20'000.0;

void require_good_refusal(const ConfigError& error) {
  require(!error.lines().empty(), "a refusal has lines");
  for (const std::string& line : error.lines()) {
    eha::fuzz::require_good_message(line, kFile);
    require(line.find('\n') == std::string::npos, "a fault is one line");
    require(line.size() < 2000, "a message is short");
  }
}

template <class Parse>
auto accepted(Parse&& parse, std::string_view text) -> std::optional<decltype(parse(text, kFile))> {
  try {
    return parse(text, kFile);
  } catch (const ConfigError& error) {
    require_good_refusal(error);
    return std::nullopt;
  }
}

template <class Config>
void require_places(const Config& config, std::string_view text) {
  require(config.text == text, "a configuration keeps its text");
  std::uint32_t lines = 1;
  for (const char c : text) lines += c == '\n' ? 1 : 0;
  for (const auto& [key, position] : config.positions) {
    require(position.line >= 1 && position.line <= lines && position.column >= 1, "a key's place is in the file");
  }
}

void check_rig(const RigConfig& rig) {
  const eha::config::RigLimits& limits = rig.limits;
  require(limits.command_min_V < limits.command_max_V, "the command has a range");
  require(limits.safe_V >= limits.command_min_V && limits.safe_V <= limits.command_max_V, "safe is within the range");
  require(limits.travel_min_in < limits.travel_max_in, "the travel has a range");
  require(limits.slew_V_per_s > 0.0 && std::isfinite(limits.slew_V_per_s), "the slew limit is positive");
  require(limits.velocity_limit_in_per_s > 0.0 && std::isfinite(limits.velocity_limit_in_per_s),
          "the velocity limit is positive");
  require(limits.stopping_deceleration_in_per_s2 > 0.0, "the stopping deceleration is positive");
  require(limits.frozen_sensor_s >= 0.0, "the frozen-sensor time is a time");
  require(rig.realtime.sample_period_s >= 1e-4 && rig.realtime.sample_period_s <= 1.0, "the tick has a sane period");
}

void check_experiment(const ExperimentConfig& experiment, const RigConfig& rig) {
  require(experiment.duration_s > 0.0 && std::isfinite(experiment.duration_s), "an experiment lasts");
  require(experiment.fit.discard_s >= 0.0 && experiment.fit.discard_s < experiment.duration_s,
          "something is left after the discarded time");
  require(experiment.fit.decimation >= 1 && experiment.fit.split > 0.0 && experiment.fit.split <= 1.0,
          "the record is divided sanely");
  require(experiment.repetitions >= 1, "an experiment has repetitions");
  if (experiment.duration_s / rig.realtime.sample_period_s > kMostTicks) return;
  Eigen::VectorXd table_V;
  try {
    table_V = eha::config::prepare(experiment, rig).table_V;
  } catch (const ConfigError& error) {
    require_good_refusal(error);
    return;
  }
  const std::size_t samples = eha::config::samples_per_repetition(experiment, rig);
  require(samples >= 1 && static_cast<std::size_t>(table_V.size()) == samples, "each tick has its voltage");
  require(table_V.allFinite(), "every voltage is finite");
  require(
      table_V.maxCoeff() <= rig.limits.command_max_V + 1e-6 && table_V.minCoeff() >= rig.limits.command_min_V - 1e-6,
      "no experiment widens the rig's limits");
}

/// A controller that is written reads back as the same file.
void check_controller(const eha::config::ControllerConfig& controller) {
  const std::string text = eha::config::controller_text(controller);
  const auto again = accepted([](auto... of) { return eha::config::parse_controller(of...); }, text);
  require(again.has_value(), "a written controller can be read:\n" + text);
  require(eha::config::controller_text(*again) == text, "a written controller reads back as itself");
}

const RigConfig& shipped_rig() {
  static const RigConfig rig = eha::config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  return rig;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto kind = accepted([](auto... of) { return eha::config::kind_of(of...); }, text);
  const auto rig = accepted([](auto... of) { return eha::config::parse_rig(of...); }, text);
  const auto experiment = accepted([](auto... of) { return eha::config::parse_experiment(of...); }, text);
  const auto controller = accepted([](auto... of) { return eha::config::parse_controller(of...); }, text);
  if (controller) check_controller(*controller);
  if (rig) {
    require(kind == FileKind::rig, "an accepted rig is known for one");
    require_places(*rig, text);
    check_rig(*rig);
    require(!eha::record::to_json(*rig).dump().empty(), "a manifest holds the rig");
  }
  if (experiment) {
    require(kind == FileKind::experiment, "an accepted experiment is known for one");
    require_places(*experiment, text);
    check_experiment(*experiment, shipped_rig());
    require(!eha::record::to_json(*experiment).dump().empty(), "a manifest holds the experiment");
  }
  return 0;
}
