// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/backends/backend.hpp"

#include <nlohmann/json.hpp>
#include <type_traits>

#include "core/error.hpp"

namespace eha::hal {
namespace {

/// Snapshots written before they named their backend are those of a card.
constexpr const char* kUnnamed = "comedi";

template <class Options>
SafeAction safe_action_of(std::string_view snapshot, std::string_view file_name) {
  if constexpr (Options::kMovesMachine) {
    return Options::safe_action(snapshot, file_name);
  } else {
    throw ConfigError(std::string(file_name) + ": not a snapshot of a rig: backend " + std::string(Options::kName) +
                      " moves nothing");
  }
}

}  // namespace

std::string_view name_of(const Backend& backend) {
  return std::visit([](const auto& options) { return std::string_view(options.kName); }, backend);
}

bool moves_machine(const Backend& backend) {
  return std::visit([](const auto& options) { return options.kMovesMachine; }, backend);
}

bool has_virtual_clock(const Backend& backend) {
  return std::visit([](const auto& options) { return options.kHasVirtualClock; }, backend);
}

bool switches_hydraulics(const Backend& backend) {
  return std::visit(
      [](const auto& options) {
        if constexpr (requires { options.enable.has_value(); }) return options.enable.has_value();
        return false;
      },
      backend);
}

bool powers_when_off(const Backend& backend) {
  return std::visit(
      [](const auto& options) {
        if constexpr (requires { options.powers_when_off(); }) return options.powers_when_off();
        return false;
      },
      backend);
}

std::string wiring_of(const Backend& backend) {
  return std::visit(
      [](const auto& options) {
        if constexpr (requires { options.wiring(); }) return options.wiring();
        return options.describe();
      },
      backend);
}

std::string describe(const Backend& backend) {
  return std::visit([](const auto& options) { return options.describe(); }, backend);
}

Conversion conversion_of(const Backend& backend) {
  return std::visit([](const auto& options) { return options.conversion(); }, backend);
}

std::optional<std::uint64_t> seed_of(const Backend& backend) {
  return std::visit(
      [](const auto& options) -> std::optional<std::uint64_t> {
        if constexpr (requires { options.seed; }) return options.seed;
        return std::nullopt;
      },
      backend);
}

std::optional<double> initial_displacement_in(const Backend& backend) {
  return std::visit(
      [](const auto& options) -> std::optional<double> {
        if constexpr (requires { options.initial_displacement_in; }) return options.initial_displacement_in;
        return std::nullopt;
      },
      backend);
}

void begin_at(Backend& backend, double displacement_in) {
  std::visit(
      [&](auto& options) {
        if constexpr (requires { options.initial_displacement_in; }) options.initial_displacement_in = displacement_in;
      },
      backend);
}

std::vector<OptionIssue> issues_of(const Backend& backend) {
  return std::visit([](const auto& options) { return check(options); }, backend);
}

std::unique_ptr<Rig> open(const Backend& backend, double safe_V) {
  return std::visit([&](const auto& options) { return open_rig(options, safe_V); }, backend);
}

SafeAction safe_action(std::string_view snapshot, std::string_view file_name) {
  const nlohmann::json json = nlohmann::json::parse(snapshot, nullptr, false);
  if (!json.is_object()) throw ConfigError(std::string(file_name) + ": not a snapshot of a rig: not a JSON object");
  const auto found = json.find("backend");
  const std::string name = found != json.end() && found->is_string() ? found->get<std::string>() : kUnnamed;
  for (const Backend& backend : all_backends()) {
    if (name_of(backend) != name) continue;
    return std::visit(
        [&](const auto& options) {
          return safe_action_of<std::remove_cvref_t<decltype(options)>>(snapshot, file_name);
        },
        backend);
  }
  throw ConfigError(std::string(file_name) + ": not a snapshot of a rig: no backend \"" + name + "\"");
}

}  // namespace eha::hal
