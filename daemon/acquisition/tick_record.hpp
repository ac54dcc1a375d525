// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "hal/rig.hpp"

namespace eha::acquisition {

inline constexpr double kSecondsPerNanosecond = 1e-9;

/// State of a rig's latched state machine; see state_machine.hpp.
enum class State : std::uint8_t { faulted, idle, armed, ramp_in, running, ramp_out, safe_stop };

/// Reason for which the rig was brought to its safe state.
enum class Fault : std::uint8_t {
  none,
  emergency_stop,       ///< the emergency-stop circuit is open
  travel_limit,         ///< the rod is outside the allowed travel, or cannot be stopped inside it
  velocity_limit,       ///< the rod is too fast
  feedback_rail,        ///< the sensor reads 0 or full scale
  frozen_sensor,        ///< the sensor's code does not change although the valve is driven
  feedback_not_finite,  ///< the displacement is NaN or infinite
  command_not_finite,   ///< the voltage to write is NaN or infinite
  repeated_timeouts,    ///< three time-outs in a row
  call_overran,         ///< a failed call took longer than a tick
  read_failed,          ///< the driver refused a read
  command_failed,       ///< the driver refused a write
  device_removed,       ///< the device is gone
  consecutive_late,     ///< too many late or skipped ticks in a row
  total_late,           ///< too many late or skipped ticks over time
  second_stop,          ///< a second stop while ramping out
  safe_write_failed,    ///< the device did not confirm the safe state at the normal end
  // Journals store the numbers: append new ones.
  not_following,       ///< the sensor shows less motion than the command must have made
  unexplained_motion,  ///< the sensor shows more motion than the command can cause, or the wrong direction
  feedback_band,       ///< the sensor's voltage is outside its valid band
  loop_stalled,        ///< the loop stalled, and the guard switched the hydraulics off
  enable_contact,      ///< the contactor's auxiliary contact does not follow the enable line
  no_motion,           ///< a closed loop drives the rod, and it hardly moves
  not_in_place,        ///< a placing's time has passed, and the rod is not at rest in its place
  loop_speed,          ///< a closed loop moves the rod much faster than intended
  wrong_speed,         ///< in a closed loop the measured speed does not match the volts
  following_error,     ///< a controller follows its reference worse than its file allows
  oscillation,         ///< a controller's command swings more often than in any of its trials
  suspended,           ///< the machine was suspended, and the output held its voltage meanwhile
  sensor_slip,         ///< the readings jumped away from the rod's place, as no rod moves
  wrong_place,         ///< by a controller's volts the rod may be at its travel limit, unlike its sensor shows
};

/// Whether a fault says that sensor, valve or rod do not do what the volts ask for.
[[nodiscard]] constexpr bool names_motion(Fault fault) noexcept {
  switch (fault) {
    case Fault::feedback_rail:
    case Fault::frozen_sensor:
    case Fault::feedback_not_finite:
    case Fault::feedback_band:
    case Fault::not_following:
    case Fault::unexplained_motion:
    case Fault::no_motion:
    case Fault::wrong_speed:
    case Fault::sensor_slip:
    case Fault::wrong_place:
      return true;
    default:
      return false;
  }
}

/// Share of a limit above which a reading is flagged, reported and shown without tripping.
inline constexpr double kWarningShare = 0.8;

/// Bits of TickRecord::flags.
enum TickFlag : std::uint16_t {
  kLate = 1u << 0,           ///< started more than half a period after its time
  kSkipped = 1u << 1,        ///< never ran: nothing sampled (displacement NaN), command held
  kClamped = 1u << 2,        ///< the request was outside the rig's command limits
  kSlewLimited = 1u << 3,    ///< the request exceeded the rig's slew limit
  kFeedbackHeld = 1u << 4,   ///< the read timed out; displacement and code are the last good ones
  kCommandHeld = 1u << 5,    ///< the write did not happen; the output holds its last voltage
  kFeedbackRail = 1u << 6,   ///< the code was 0 or full scale
  kEmergencyStop = 1u << 7,  ///< the emergency-stop circuit was open
  kLost = 1u << 8,  ///< the tick ran, but its row was lost by damage to the journal; volts and displacement are NaN
  kNearTravel = 1u << 9,     ///< over 80 % of the way to a travel limit (kWarningShare)
  kNearVelocity = 1u << 10,  ///< over 80 % of the velocity limit
};

/// One tick as recorded: the displacement was sampled, then the command was applied and held to the next tick.
/// 64 bytes, little-endian, no padding: the journal's unit. Rows whose state is `running` are the experiment.
struct TickRecord {
  std::int64_t scheduled_ns;     ///< when the tick was due, from the run's first tick [ns]; sequence times period
  std::uint32_t sequence;        ///< tick number on the grid; a gap means that ticks beyond the flagged ones were lost
  std::int32_t lateness_ns;      ///< wake-up after the scheduled time, saturated; 0 in virtual time
  std::uint32_t execution_ns;    ///< from wake-up to the end of the tick, saturated; 0 in virtual time
  std::uint32_t feedback_code;   ///< raw code of the displacement converter
  std::uint32_t command_code;    ///< raw code on the output
  std::uint32_t digital_inputs;  ///< raw digital input word
  std::uint16_t flags;           ///< TickFlag bits
  State state;
  Fault fault;               ///< first fault of the run; none until it happens
  std::uint16_t repetition;  ///< 1-based while running, otherwise 0
  hal::RigStatus read_status;
  hal::RigStatus command_status;
  double requested_V;      ///< voltage that the command source or the ramp requested [V]
  double applied_V;        ///< voltage of the code on the output [V]
  double displacement_in;  ///< calibrated rod position [in]
};
static_assert(sizeof(TickRecord) == 64 && std::is_trivially_copyable_v<TickRecord>);
static_assert(offsetof(TickRecord, sequence) == 8 && offsetof(TickRecord, flags) == 32 &&
              offsetof(TickRecord, repetition) == 36 && offsetof(TickRecord, requested_V) == 40);
static_assert(std::endian::native == std::endian::little, "TickRecord is written to disk as it is in memory");

/// Names as used in files and messages: "ramp_in", "travel_limit", ... Real-time safe.
[[nodiscard]] std::string_view to_text(State state) noexcept;
[[nodiscard]] std::string_view to_text(Fault fault) noexcept;
/// None of a text that names no fault.
[[nodiscard]] std::optional<Fault> fault_named(std::string_view text) noexcept;
[[nodiscard]] std::string_view to_text(hal::RigStatus status) noexcept;

}  // namespace eha::acquisition
