// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace eha::hal {

/// Result of a call on the rig. Everything but `ok` leaves the outputs of the call untouched.
enum class RigStatus : std::uint8_t {
  ok,
  timed_out,   ///< the converter did not finish in time; a single one may be tolerated
  io_error,    ///< the driver refused for another reason
  busy,        ///< the subdevice runs a command of another file or process
  locked,      ///< another process holds the subdevice
  removed,     ///< the device is gone
  not_finite,  ///< the voltage to write is NaN or infinite
};

/// One sample of the rig's inputs.
struct RigReading {
  double displacement_in = 0.0;      ///< calibrated rod position [in]
  double feedback_V = 0.0;           ///< the sensor's voltage [V]
  std::uint32_t feedback_code = 0;   ///< raw converter code
  std::uint32_t digital_inputs = 0;  ///< raw digital input word
  bool feedback_at_rail = false;     ///< code 0 or full scale
  bool emergency_stop = false;       ///< the (normally closed) emergency-stop circuit is open
  bool enable_contact = false;       ///< the contactor's auxiliary contact is closed; false when the rig has none
};

/// A command as written to the output.
struct AppliedCommand {
  double applied_V = 0.0;  ///< the voltage of the code written [V]
  std::uint32_t code = 0;  ///< raw converter code
};

/// Properties of a rig; fixed while it is open.
struct RigCapabilities {
  std::string backend;         ///< "sim", "comedi"
  std::string device;          ///< "/dev/comedi0"; empty for sim
  std::string board;           ///< "pci1716"
  std::string driver;          ///< "adv_pci1710"
  double command_min_V = 0.0;  ///< range of the output converter [V]
  double command_max_V = 0.0;
  double command_lsb_V = 0.0;
  double feedback_min_V = 0.0;  ///< range of the input converter [V]
  double feedback_max_V = 0.0;
  double feedback_lsb_V = 0.0;
  bool has_emergency_stop = false;
  bool has_enable = false;
  bool has_heartbeat = false;
  bool has_enable_contact = false;
  double enable_contact_time_s = 0.0;  ///< time that the contact may take to follow the enable line [s]
  bool moves_machine = true;           ///< a run moves a real machine
  bool has_virtual_clock = false;      ///< may run faster than real time
};

/// One rig: a valve command as output, a displacement as input, and the lines that make it safe. Each backend's
/// factory opens it and throws DeviceError or PermissionError; afterwards nothing throws.
/// Real-time safe: every member below is noexcept and neither allocates, locks nor logs. Not thread-safe, except
/// make_safe().
class Rig {
 public:
  Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  virtual ~Rig() = default;

  [[nodiscard]] virtual const RigCapabilities& capabilities() const noexcept = 0;

  /// Samples the inputs at the start of a tick. A simulated plant advances to elapsed_ns under the command held since
  /// the last call.
  /// @param elapsed_ns  time since the run's start [ns], never decreasing within a run
  virtual RigStatus read(std::int64_t elapsed_ns, RigReading& reading) noexcept = 0;

  /// Writes the valve command [V], held until the next one, and toggles the heartbeat line.
  virtual RigStatus command(double command_V, AppliedCommand& applied) noexcept = 0;

  /// Switches the hydraulic enable line; returns `ok` without effect if the rig has none. A rig opens with the line off
  /// and the safe voltage written, so that the first write to the output never meets live hydraulics.
  virtual RigStatus set_enable(bool on) noexcept = 0;

  /// Switches the enable line off, then writes the rig's safe voltage; in this order an output that times out does not
  /// keep the hydraulics on. May be called at any time and repeatedly, also from a signal handler while another thread
  /// is inside a call (that thread must not write afterwards). Tries the second step even if the first fails, and
  /// returns the first failure.
  virtual RigStatus make_safe() noexcept = 0;

  /// Returns JSON with which another process can make the rig safe (hal::safe_action); empty if no machine moves. Write
  /// it to a file and start the guard on it before the enable line is switched on. Not real-time safe: allocates.
  [[nodiscard]] virtual std::string safe_snapshot() const { return {}; }
};

}  // namespace eha::hal
