// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/comedi_rig.hpp"

#include <comedilib.h>

#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "hal/comedi/comedi_device.hpp"
#include "hal/comedi/safe_snapshot.hpp"

namespace eha::hal {
namespace {

unsigned aref(AnalogReference reference) {
  switch (reference) {
    case AnalogReference::ground:
      return AREF_GROUND;
    case AnalogReference::common:
      return AREF_COMMON;
    case AnalogReference::diff:
      return AREF_DIFF;
    case AnalogReference::other:
      break;
  }
  return AREF_OTHER;
}

unsigned on_level(const DigitalLine& line) { return line.active == ActiveLevel::high ? 1U : 0U; }

bool is_on(const DigitalLine& line, lsampl_t word) { return ((word >> line.channel) & 1U) == on_level(line); }

const ComediOptions& checked(const ComediOptions& options, double safe_V) {
  std::vector<OptionIssue> issues = check(options);
  if (!(safe_V >= options.command.range_min_V && safe_V <= options.command.range_max_V)) {
    std::ostringstream message;
    message << "expected to hold the rig's safe voltage, got " << options.command.range_min_V << ".."
            << options.command.range_max_V << " V and a safe voltage of " << safe_V << " V";
    issues.push_back({"command", message.str()});
  }
  if (!issues.empty()) throw ConfigError(to_lines(issues, std::string(ComediOptions::kName)));
  return options;
}

class CardRig final : public Rig {
 public:
  CardRig(const ComediOptions& options, double safe_V)
      : options_(checked(options, safe_V)),
        device_(options.device),
        card_(device_.describe()),
        match_(match(options, card_)) {
    feedback_range_ = range(options.feedback, match_.feedback_range);
    command_range_ = range(options.command, match_.command_range);
    command_chanspec_ = CR_PACK(options.command.channel, match_.command_range, aref(options.command.reference));
    safe_code_ = comedi_from_phys(safe_V, &command_range_, match_.last_code);
    describe();
    prepare_read();
    prepare_write();
    lock();
    set_directions();
    open_safely();
  }

  // Closing the device releases the locks.
  ~CardRig() override { make_safe(); }

  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override { return capabilities_; }
  [[nodiscard]] std::string safe_snapshot() const override { return to_text(snapshot_); }

  RigStatus read(std::int64_t, RigReading& reading) noexcept override {
    input_bits_ = {0, 0};
    contact_bits_ = {0, 0};
    if (const RigStatus status = run(read_list_); status != RigStatus::ok) return status;
    const double volts = comedi_to_phys(sample_, &feedback_range_, match_.last_code);
    reading.feedback_code = sample_;
    reading.feedback_V = volts;
    reading.displacement_in = options_.offset_in + options_.scale_in_per_V * volts;
    reading.feedback_at_rail = sample_ == 0 || sample_ >= match_.last_code;
    reading.digital_inputs = options_.emergency_stop ? input_bits_[1] : contact_bits_[1];
    reading.emergency_stop = options_.emergency_stop && !is_on(*options_.emergency_stop, input_bits_[1]);
    reading.enable_contact = options_.enable_contact && is_on(options_.enable_contact->line(),
                                                              contact_shares_word_ ? input_bits_[1] : contact_bits_[1]);
    return RigStatus::ok;
  }

  RigStatus command(double command_V, AppliedCommand& applied) noexcept override {
    // comedi_from_phys of a NaN is undefined.
    if (!std::isfinite(command_V)) return RigStatus::not_finite;
    code_ = comedi_from_phys(command_V, &command_range_, match_.last_code);
    if (options_.heartbeat)
      heartbeat_bits_ = {1U << options_.heartbeat->channel, heartbeat_level_ << options_.heartbeat->channel};
    const lsampl_t code = code_;
    if (const RigStatus status = run(write_list_); status != RigStatus::ok) return status;
    heartbeat_level_ ^= 1U;
    applied.code = code;
    applied.applied_V = comedi_to_phys(code, &command_range_, match_.last_code);
    return RigStatus::ok;
  }

  RigStatus set_enable(bool on) noexcept override {
    if (!options_.enable) return RigStatus::ok;
    const unsigned level = on_level(*options_.enable);
    return write_line(device_.get(), options_.enable->subdevice, options_.enable->channel, on ? level : level ^ 1U);
  }

  RigStatus make_safe() noexcept override {
    const RigStatus disabled = set_enable(false);
    const RigStatus written = write_code(device_.get(), options_.command.subdevice, command_chanspec_, safe_code_);
    return disabled != RigStatus::ok ? disabled : written;
  }

 private:
  comedi_range range(const AnalogChannel& channel, unsigned index) {
    const comedi_range* found = comedi_get_range(device_.get(), channel.subdevice, channel.channel, index);
    if (!found) throw DeviceError(options_.device + ": the card does not give its ranges: " + last_comedi_error());
    return *found;
  }

  void describe() {
    capabilities_.backend = ComediOptions::kName;
    capabilities_.moves_machine = ComediOptions::kMovesMachine;
    capabilities_.has_virtual_clock = ComediOptions::kHasVirtualClock;
    capabilities_.device = options_.device;
    capabilities_.board = card_.board;
    capabilities_.driver = card_.driver;
    capabilities_.command_min_V = command_range_.min;
    capabilities_.command_max_V = command_range_.max;
    capabilities_.command_lsb_V = (command_range_.max - command_range_.min) / match_.last_code;
    capabilities_.feedback_min_V = feedback_range_.min;
    capabilities_.feedback_max_V = feedback_range_.max;
    capabilities_.feedback_lsb_V = (feedback_range_.max - feedback_range_.min) / match_.last_code;
    capabilities_.has_emergency_stop = options_.emergency_stop.has_value();
    capabilities_.has_enable = options_.enable.has_value();
    capabilities_.has_heartbeat = options_.heartbeat.has_value();
    capabilities_.has_enable_contact = options_.enable_contact.has_value();
    if (options_.enable_contact) capabilities_.enable_contact_time_s = options_.enable_contact->follows_within_s;
    snapshot_.device = options_.device;
    snapshot_.board = card_.board;
    snapshot_.subdevice = options_.command.subdevice;
    snapshot_.channel = options_.command.channel;
    snapshot_.range = match_.command_range;
    snapshot_.reference = aref(options_.command.reference);
    snapshot_.safe_code = safe_code_;
    snapshot_.safe_V = comedi_to_phys(safe_code_, &command_range_, match_.last_code);
    if (options_.enable) {
      snapshot_.enable = SafeSnapshot::Line{.subdevice = options_.enable->subdevice,
                                            .channel = options_.enable->channel,
                                            .off_level = on_level(*options_.enable) ^ 1U,
                                            .is_bidirectional = match_.enable_is_bidirectional};
    }
  }

  void prepare_read() {
    const unsigned subdevice = options_.feedback.subdevice;
    const unsigned chanspec =
        CR_PACK(options_.feedback.channel, match_.feedback_range, aref(options_.feedback.reference));
    settling_ns_ = static_cast<lsampl_t>(options_.feedback_settling_us * 1e3);
    unsigned count = 0;
    if (settling_ns_ > 0) {
      // A read of no samples only switches the multiplexer, as comedi_data_read_delayed() does.
      read_instructions_[count++] = instruction(INSN_READ, 0, &sample_, subdevice, chanspec);
      read_instructions_[count++] = instruction(INSN_WAIT, 1, &settling_ns_, subdevice, chanspec);
    }
    read_instructions_[count++] = instruction(INSN_READ, 1, &sample_, subdevice, chanspec);
    if (options_.emergency_stop) {
      read_instructions_[count++] =
          instruction(INSN_BITS, 2, input_bits_.data(), options_.emergency_stop->subdevice, 0);
    }
    contact_shares_word_ = options_.enable_contact && options_.emergency_stop &&
                           options_.enable_contact->subdevice == options_.emergency_stop->subdevice;
    if (options_.enable_contact && !contact_shares_word_) {
      read_instructions_[count++] =
          instruction(INSN_BITS, 2, contact_bits_.data(), options_.enable_contact->subdevice, 0);
    }
    read_list_ = {.n_insns = count, .insns = read_instructions_.data()};
  }

  void prepare_write() {
    unsigned count = 0;
    write_instructions_[count++] = instruction(INSN_WRITE, 1, &code_, options_.command.subdevice, command_chanspec_);
    if (options_.heartbeat) {
      heartbeat_level_ = on_level(*options_.heartbeat);
      write_instructions_[count++] =
          instruction(INSN_BITS, 2, heartbeat_bits_.data(), options_.heartbeat->subdevice, 0);
    }
    write_list_ = {.n_insns = count, .insns = write_instructions_.data()};
  }

  static comedi_insn instruction(unsigned what, unsigned n, lsampl_t* data, unsigned subdevice, unsigned chanspec) {
    return {.insn = what, .n = n, .data = data, .subdev = subdevice, .chanspec = chanspec, .unused = {}};
  }

  RigStatus run(comedi_insnlist& list) noexcept {
    const int done = comedi_do_insnlist(device_.get(), &list);
    if (done == static_cast<int>(list.n_insns)) return RigStatus::ok;
    return done < 0 ? last_comedi_status() : RigStatus::io_error;
  }

  void lock() {
    // Locks no subdevice of an output line: another process must be able to switch the hydraulics off while this one
    // has stalled, and a write to one line does not change the others.
    std::set<unsigned> used = {options_.feedback.subdevice, options_.command.subdevice};
    if (options_.emergency_stop) used.insert(options_.emergency_stop->subdevice);
    for (const auto* line : {&options_.enable, &options_.heartbeat}) {
      if (*line) used.erase((*line)->subdevice);
    }
    if (options_.enable_contact) used.insert(options_.enable_contact->subdevice);
    for (const unsigned subdevice : used) {
      if (comedi_lock(device_.get(), subdevice) != 0) {
        throw DeviceError(options_.device + ": subdevice " + std::to_string(subdevice) +
                          ": another process holds or uses it (" + last_comedi_error() +
                          "); end that process, or wait for it");
      }
    }
  }

  /// Lines of some cards change their direction in groups only. The inputs are set last: a card that is refused keeps
  /// no output against the contact of an emergency stop.
  /// @throws DeviceError  a line does not keep its direction
  void set_directions() {
    struct Wanted {
      const char* key;
      DigitalLine line;
      unsigned direction;
    };
    std::vector<Wanted> all;
    const auto want = [&](const char* key, const std::optional<DigitalLine>& line, bool bidirectional, unsigned to) {
      if (line && bidirectional) all.push_back({key, *line, to});
    };
    want("enable", options_.enable, match_.enable_is_bidirectional, COMEDI_OUTPUT);
    want("heartbeat", options_.heartbeat, match_.heartbeat_is_bidirectional, COMEDI_OUTPUT);
    want("emergency_stop", options_.emergency_stop, match_.emergency_stop_is_bidirectional, COMEDI_INPUT);
    if (options_.enable_contact) {
      want("enable_contact", options_.enable_contact->line(), match_.enable_contact_is_bidirectional, COMEDI_INPUT);
    }
    const auto refuse = [&](const Wanted& one, const std::string& why) {
      throw DeviceError(options_.device + ": comedi." + one.key + ": subdevice " + std::to_string(one.line.subdevice) +
                        " line " + std::to_string(one.line.channel) + " " + why);
    };
    // Writes the level first, so that the line is not on when it becomes an output.
    if (match_.enable_is_bidirectional) require(set_enable(false), "switch the enable line off");
    for (const Wanted& one : all) {
      if (comedi_dio_config(device_.get(), one.line.subdevice, one.line.channel, one.direction) < 0) {
        refuse(one, "cannot be given its direction: " + last_comedi_error());
      }
    }
    for (const Wanted& one : all) {
      unsigned direction = one.direction;
      if (comedi_dio_get_config(device_.get(), one.line.subdevice, one.line.channel, &direction) < 0) {
        refuse(one, "does not tell its direction: " + last_comedi_error());
      }
      if (direction != one.direction) {
        refuse(one,
               "became an input with another line: this card's lines change direction in groups; wire inputs and "
               "outputs to different groups (ports)");
      }
    }
  }

  void open_safely() {
    require(set_enable(false), "switch the enable line off");
    require(make_safe(), "write the safe voltage");  // the enable line again, which has just succeeded
  }

  void require(RigStatus status, const char* doing) {
    if (status != RigStatus::ok) {
      throw DeviceError(options_.device + ": cannot " + doing + ": " + last_comedi_error());
    }
  }

  ComediOptions options_;
  ComediDevice device_;
  CardDescription card_;
  CardMatch match_;
  RigCapabilities capabilities_;
  SafeSnapshot snapshot_;
  comedi_range feedback_range_{};
  comedi_range command_range_{};
  unsigned command_chanspec_ = 0;
  lsampl_t safe_code_ = 0;
  // Buffers of the prebuilt instruction lists, which point at them; the object never moves.
  lsampl_t sample_ = 0;
  lsampl_t settling_ns_ = 0;
  lsampl_t code_ = 0;
  unsigned heartbeat_level_ = 0;
  std::array<lsampl_t, 2> input_bits_{};
  std::array<lsampl_t, 2> contact_bits_{};
  bool contact_shares_word_ = false;  ///< with the emergency stop
  std::array<lsampl_t, 2> heartbeat_bits_{};
  std::array<comedi_insn, 5> read_instructions_{};
  std::array<comedi_insn, 2> write_instructions_{};
  comedi_insnlist read_list_{};
  comedi_insnlist write_list_{};
};

}  // namespace

std::unique_ptr<Rig> open_rig(const ComediOptions& options, double safe_V) {
  return std::make_unique<CardRig>(options, safe_V);
}

}  // namespace eha::hal
