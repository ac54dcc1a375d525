// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/card_description.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <sstream>

#include "core/error.hpp"

namespace eha::hal {
namespace {

/// Ranges are whole microvolts in the kernel.
constexpr double kRangeTolerance_V = 1e-6;

const char* name(SubdeviceKind kind) {
  switch (kind) {
    case SubdeviceKind::analog_input:
      return "analog input";
    case SubdeviceKind::analog_output:
      return "analog output";
    case SubdeviceKind::digital_input:
      return "digital input";
    case SubdeviceKind::digital_output:
      return "digital output";
    case SubdeviceKind::digital_io:
      return "digital input/output";
    case SubdeviceKind::other:
      break;
  }
  return "of another kind";
}

std::string in_words(const std::vector<VoltageRange>& ranges) {
  std::ostringstream text;
  for (const VoltageRange& range : ranges) {
    text << (&range == &ranges.front() ? "" : ", ") << range.min_V << ".." << range.max_V;
  }
  text << (ranges.empty() ? "no range in volts" : " V");
  return text.str();
}

std::string in_words(const std::vector<AnalogReference>& references) {
  std::string text;
  for (const AnalogReference reference : references) text += (text.empty() ? "" : ", ") + std::string(name(reference));
  return text.empty() ? "none" : text;
}

std::string bits(unsigned last_code) {
  // A converter whose codes do not fill a power of two has no whole number of bits.
  if (!std::has_single_bit(last_code + 1U)) return "codes to " + std::to_string(last_code);
  return std::to_string(std::bit_width(last_code)) + " bit";
}

std::string in_words(const SubdeviceDescription& subdevice) {
  std::string text = std::string(name(subdevice.kind)) + ", " + std::to_string(subdevice.channels) + " channels";
  if (subdevice.kind == SubdeviceKind::analog_input || subdevice.kind == SubdeviceKind::analog_output) {
    text += ", " + bits(subdevice.last_code) + ", " + in_words(subdevice.ranges);
  }
  return text;
}

/// Collects the differences between the options and one card.
class Matcher {
 public:
  Matcher(const ComediOptions& options, const CardDescription& card) : options_(options), card_(card) {}

  void differ(const std::string& key, const std::string& expected, const std::string& offered) {
    differences_ += "\n" + options_.device + ": comedi." + key + ": expected " + expected + ", the card has " + offered;
  }

  [[nodiscard]] const SubdeviceDescription* subdevice(const std::string& key, unsigned index, unsigned channel,
                                                      std::initializer_list<SubdeviceKind> kinds) {
    const std::string expected = name(*kinds.begin());
    if (index >= card_.subdevices.size()) {
      differ(key + ".subdevice", expected + " at " + std::to_string(index),
             std::to_string(card_.subdevices.size()) + " subdevices");
      return nullptr;
    }
    const SubdeviceDescription& found = card_.subdevices[index];
    if (std::find(kinds.begin(), kinds.end(), found.kind) == kinds.end()) {
      differ(key + ".subdevice", expected + " at " + std::to_string(index), in_words(found));
      return nullptr;
    }
    if (channel >= found.channels) {
      differ(key + ".channel", std::to_string(channel),
             "channels 0 to " + std::to_string(static_cast<int>(found.channels) - 1) + " on subdevice " +
                 std::to_string(index));
      return nullptr;
    }
    return &found;
  }

  unsigned analog(const std::string& key, const AnalogChannel& wanted, SubdeviceKind kind) {
    const SubdeviceDescription* found = subdevice(key, wanted.subdevice, wanted.channel, {kind});
    if (!found) return 0;
    const unsigned last_code = (1U << options_.resolution_bits) - 1U;
    if (found->last_code != last_code)
      differ("resolution_bits", bits(last_code) + " for " + key, bits(found->last_code));
    if (std::find(found->references.begin(), found->references.end(), wanted.reference) == found->references.end()) {
      differ(key + ".reference", std::string("\"") + eha::hal::name(wanted.reference) + "\"",
             in_words(found->references));
    }
    const auto range = std::find_if(found->ranges.begin(), found->ranges.end(), [&](const VoltageRange& offered) {
      return std::abs(offered.min_V - wanted.range_min_V) < kRangeTolerance_V &&
             std::abs(offered.max_V - wanted.range_max_V) < kRangeTolerance_V;
    });
    if (range == found->ranges.end()) {
      std::ostringstream expected;
      expected << "the range " << wanted.range_min_V << ".." << wanted.range_max_V << " V";
      differ(key, expected.str(), in_words(found->ranges));
      return 0;
    }
    return range->index;
  }

  /// @returns whether the line is of a subdevice that goes both ways
  bool digital(const std::string& key, const std::optional<DigitalLine>& wanted, SubdeviceKind kind) {
    if (!wanted) return false;
    const SubdeviceDescription* found =
        subdevice(key, wanted->subdevice, wanted->channel, {kind, SubdeviceKind::digital_io});
    return found && found->kind == SubdeviceKind::digital_io;
  }

  void finish() const {
    if (!differences_.empty()) {
      throw DeviceError(options_.device + ": the card differs from the rig file; correct the file or the wiring" +
                        differences_);
    }
  }

 private:
  const ComediOptions& options_;
  const CardDescription& card_;
  std::string differences_;
};

}  // namespace

const char* name(AnalogReference reference) noexcept {
  switch (reference) {
    case AnalogReference::ground:
      return "ground";
    case AnalogReference::common:
      return "common";
    case AnalogReference::diff:
      return "diff";
    case AnalogReference::other:
      break;
  }
  return "other";
}

CardMatch match(const ComediOptions& options, const CardDescription& card) {
  Matcher matcher(options, card);
  // On the wrong board further differences have no meaning.
  if (card.board != options.board) matcher.differ("board", '"' + options.board + '"', '"' + card.board + '"');
  if (card.driver != options.driver) matcher.differ("driver", '"' + options.driver + '"', '"' + card.driver + '"');
  matcher.finish();

  CardMatch found;
  found.feedback_range = matcher.analog("feedback", options.feedback, SubdeviceKind::analog_input);
  found.command_range = matcher.analog("command", options.command, SubdeviceKind::analog_output);
  found.last_code = (1U << options.resolution_bits) - 1U;
  found.emergency_stop_is_bidirectional =
      matcher.digital("emergency_stop", options.emergency_stop, SubdeviceKind::digital_input);
  found.enable_is_bidirectional = matcher.digital("enable", options.enable, SubdeviceKind::digital_output);
  found.heartbeat_is_bidirectional = matcher.digital("heartbeat", options.heartbeat, SubdeviceKind::digital_output);
  if (options.enable_contact) {
    found.enable_contact_is_bidirectional =
        matcher.digital("enable_contact", options.enable_contact->line(), SubdeviceKind::digital_input);
  }
  matcher.finish();
  return found;
}

std::string to_lines(const CardDescription& card) {
  std::string lines;
  for (std::size_t i = 0; i < card.subdevices.size(); ++i) {
    lines += (i == 0 ? "" : "\n") + ("subdevice " + std::to_string(i)) + ": " + in_words(card.subdevices[i]);
  }
  return lines;
}

}  // namespace eha::hal
