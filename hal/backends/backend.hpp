// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/option_issue.hpp"
#include "hal/backends/backend_list.hpp"
#include "hal/conversion.hpp"
#include "hal/rig.hpp"
#include "hal/safe_action.hpp"

// A backend is a struct of options with these members:
//
//   static constexpr std::string_view kName;  value of the rig file's key `backend`, and name of its table
//   static constexpr bool kMovesMachine;      the rig file's owner is checked, the user confirms, a guard watches
//   static constexpr bool kHasVirtualClock;   its runs may go faster than real time
//   static void visit_keys(auto& self, auto& keys);   its keys, see core/keys.hpp
//   std::string describe() const;             for messages, "/dev/comedi0 (pci1716)"
//   Conversion conversion() const;
//   static SafeAction safe_action(std::string_view snapshot, std::string_view file_name);   if it moves a machine
//
// and two functions beside it:
//
//   std::vector<OptionIssue> check(const Options&);
//   std::unique_ptr<Rig> open_rig(const Options&, double safe_V);
//
// Members `seed`, `initial_displacement_in`, `enable` (optional: switches the hydraulics) and `wiring()` are optional,
// `powers_when_off()`, too.
// Add it to backend_list.hpp; no other code depends on a backend's name.

namespace eha::hal {

/// Value of the rig file's key `backend`.
[[nodiscard]] std::string_view name_of(const Backend& backend);

/// Whether a run on this rig moves a real machine.
[[nodiscard]] bool moves_machine(const Backend& backend);

/// Whether a run may take the virtual clock, faster than real time.
[[nodiscard]] bool has_virtual_clock(const Backend& backend);

/// Whether the hydraulics are off while nothing is driven: a machine without an enable line follows the safe voltage.
[[nodiscard]] bool switches_hydraulics(const Backend& backend);

/// Whether the hydraulics are on while the computer is off or boots, as outputs are low then, and no contact shows it.
[[nodiscard]] bool powers_when_off(const Backend& backend);

/// Returns card and channels of sensor and valve as the rig file has them, or the description of a backend without.
[[nodiscard]] std::string wiring_of(const Backend& backend);

/// Returns a description for messages: "simulated", "/dev/comedi0 (pci1716)".
[[nodiscard]] std::string describe(const Backend& backend);

[[nodiscard]] Conversion conversion_of(const Backend& backend);

/// Returns the seed of the backend's random numbers, if it has any.
[[nodiscard]] std::optional<std::uint64_t> seed_of(const Backend& backend);

/// Returns the rod's position when the rig is opened [in], if the backend has that option.
[[nodiscard]] std::optional<double> initial_displacement_in(const Backend& backend);

/// Sets the rod's position of rigs opened from now on, if the backend has that option; does nothing otherwise.
void begin_at(Backend& backend, double displacement_in);

/// Returns every option that contradicts itself or another one, as far as can be checked without the rig.
[[nodiscard]] std::vector<OptionIssue> issues_of(const Backend& backend);

/// Opens the rig and leaves it safe.
/// @param safe_V  voltage that make_safe() writes [V]
/// @throws DeviceError, PermissionError, ConfigError  as the backend's own open_rig
[[nodiscard]] std::unique_ptr<Rig> open(const Backend& backend, double safe_V);

/// Returns the action that makes a rig safe after its process has died, from Rig::safe_snapshot().
/// @param file_name  for messages
/// @throws ConfigError  not a snapshot, or one of a backend that moves nothing
[[nodiscard]] SafeAction safe_action(std::string_view snapshot, std::string_view file_name);

/// Each backend with its default options.
[[nodiscard]] inline std::array<Backend, std::variant_size_v<Backend>> all_backends() {
  return []<std::size_t... index>(std::index_sequence<index...>) {
    return std::array<Backend, sizeof...(index)>{std::variant_alternative_t<index, Backend>{}...};
  }
  (std::make_index_sequence<std::variant_size_v<Backend>>{});
}

}  // namespace eha::hal
