// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/comedi_options.hpp"

#include <cmath>
#include <optional>
#include <sstream>

namespace eha::hal {
namespace {

constexpr unsigned kLinesOfOneInstruction = 32;
/// The kernel refuses to wait for 100 us or longer inside an instruction list.
constexpr double kSettlingLimit_us = 100.0;
/// comedi packs a channel into 16 bits.
constexpr unsigned kChannelLimit = 65536;

template <class Value>
OptionIssue issue(std::string key, const std::string& expected, const Value& got) {
  std::ostringstream text;
  text << "expected " << expected << ", got " << got;
  return {std::move(key), text.str()};
}

bool is_date(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  for (const std::size_t i : {0U, 1U, 2U, 3U, 5U, 6U, 8U, 9U}) {
    if (text[i] < '0' || text[i] > '9') return false;
  }
  const int month = std::stoi(text.substr(5, 2));
  const int day = std::stoi(text.substr(8, 2));
  return month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

bool same_line(const std::optional<DigitalLine>& a, const std::optional<DigitalLine>& b) {
  return a && b && a->subdevice == b->subdevice && a->channel == b->channel;
}

}  // namespace

std::string ComediOptions::wiring() const {
  std::ostringstream text;
  text << describe() << " sensor " << feedback.subdevice << ' ' << feedback.channel << " valve " << command.subdevice
       << ' ' << command.channel;
  return text.str();
}

std::vector<OptionIssue> check(const ComediOptions& o) {
  std::vector<OptionIssue> issues;
  if (o.device.empty()) issues.push_back(issue("device", "the device node, as \"/dev/comedi0\"", "\"\""));
  if (o.board.empty()) issues.push_back(issue("board", "the board's name, as \"pci1716\"", "\"\""));
  if (o.driver.empty()) issues.push_back(issue("driver", "the driver's name, as \"adv_pci1710\"", "\"\""));
  if (o.resolution_bits < 1 || o.resolution_bits > 31) {
    issues.push_back(issue("resolution_bits", "from 1 to 31", o.resolution_bits));
  }
  for (const auto& [key, channel] :
       {std::pair<const char*, const AnalogChannel&>{"feedback", o.feedback}, {"command", o.command}}) {
    if (channel.channel >= kChannelLimit) {
      issues.push_back(issue(std::string(key) + ".channel", "from 0 to 65535", channel.channel));
    }
    if (!(std::isfinite(channel.range_min_V) && std::isfinite(channel.range_max_V) &&
          channel.range_min_V < channel.range_max_V)) {
      std::ostringstream expected;
      expected << "more than range_min_V = " << channel.range_min_V;
      issues.push_back(issue(std::string(key) + ".range_max_V", expected.str(), channel.range_max_V));
    }
  }
  if (!(o.feedback_settling_us >= 0.0 && o.feedback_settling_us < kSettlingLimit_us)) {
    issues.push_back(issue("feedback_settling_us", "from 0 to 99", o.feedback_settling_us));
  }
  const std::optional<DigitalLine> contact =
      o.enable_contact ? std::optional<DigitalLine>(o.enable_contact->line()) : std::nullopt;
  for (const auto& [key, line] :
       {std::pair<const char*, const std::optional<DigitalLine>&>{"emergency_stop", o.emergency_stop},
        {"enable", o.enable},
        {"heartbeat", o.heartbeat},
        {"enable_contact", contact}}) {
    if (line && line->channel >= kLinesOfOneInstruction) {
      issues.push_back(issue(std::string(key) + ".channel", "from 0 to 31", line->channel));
    }
  }
  if (same_line(o.enable, o.heartbeat)) {
    issues.push_back(issue("heartbeat.channel", "another line than enable", o.heartbeat->channel));
  }
  if (same_line(o.emergency_stop, o.enable) || same_line(o.emergency_stop, o.heartbeat)) {
    issues.push_back(issue("emergency_stop.channel", "a line of its own", o.emergency_stop->channel));
  }
  if (same_line(contact, o.emergency_stop) || same_line(contact, o.enable) || same_line(contact, o.heartbeat)) {
    issues.push_back(issue("enable_contact.channel", "a line of its own", contact->channel));
  }
  if (contact && !o.enable)
    issues.push_back(issue("enable_contact", "an enable line that it follows", "enable = \"none\""));
  if (!std::isfinite(o.scale_in_per_V) || std::abs(o.scale_in_per_V) < 1e-9) {
    issues.push_back(issue("scale_in_per_V", "a number that is not 0", o.scale_in_per_V));
  }
  if (!std::isfinite(o.offset_in)) issues.push_back(issue("offset_in", "a finite number", o.offset_in));
  if (!is_date(o.calibration_date)) {
    issues.push_back(issue("calibration_date", "a day as YYYY-MM-DD", '"' + o.calibration_date + '"'));
  }
  return issues;
}

}  // namespace eha::hal
