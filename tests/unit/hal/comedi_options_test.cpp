// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/comedi_options.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "pci1716_options.hpp"

namespace eha::hal {
namespace {

using testing::pci1716_options;

std::string keys(const ComediOptions& options) {
  std::string list;
  for (const OptionIssue& fault : check(options)) list += (list.empty() ? "" : " ") + fault.key;
  return list;
}

TEST(ComediOptions, AcceptARigThatIsWiredSoundly) { EXPECT_EQ(keys(pci1716_options()), ""); }

TEST(ComediOptions, SayThatAnEmptyRigFileNamesNoCard) {
  EXPECT_EQ(keys(ComediOptions()), "board driver scale_in_per_V calibration_date");
}

TEST(ComediOptions, NameEveryFaultAtOnce) {
  ComediOptions o = pci1716_options();
  o.resolution_bits = 0;
  o.feedback.channel = 70000;
  o.command.range_max_V = -5.0;
  o.feedback_settling_us = 100.0;
  o.emergency_stop->channel = 32;
  o.heartbeat = o.enable;
  o.scale_in_per_V = 0.0;
  o.offset_in = std::numeric_limits<double>::infinity();
  o.calibration_date = "2026-13-01";
  EXPECT_EQ(keys(o),
            "resolution_bits feedback.channel command.range_max_V feedback_settling_us emergency_stop.channel "
            "heartbeat.channel scale_in_per_V offset_in calibration_date");
}

TEST(ComediOptions, RefuseAnEmergencyStopOnAnOutputLine) {
  ComediOptions o = pci1716_options();
  o.emergency_stop = o.heartbeat;
  EXPECT_EQ(keys(o), "emergency_stop.channel");
}

TEST(ComediOptions, RefuseAnEnableContactWithoutALineOfItsOwnOrWithoutAnEnableLine) {
  ComediOptions o = pci1716_options();
  o.enable_contact = ContactLine{.subdevice = 2, .channel = 1};
  EXPECT_EQ(keys(o), "");
  o.enable_contact->channel = o.emergency_stop->channel;
  EXPECT_EQ(keys(o), "enable_contact.channel");
  o.enable_contact->channel = 1;
  o.enable.reset();
  EXPECT_EQ(keys(o), "enable_contact");
}

}  // namespace
}  // namespace eha::hal
