// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/card_description.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "pci1716_options.hpp"

namespace eha::hal {
namespace {

using testing::pci1716_options;

/// A PCI-1716 as the out-of-tree driver reports it.
CardDescription pci1716() {
  CardDescription card;
  card.board = "pci1716";
  card.driver = "adv_pci1710";
  const std::vector<AnalogReference> single_ended = {AnalogReference::ground, AnalogReference::common};
  const std::vector<AnalogReference> all = {AnalogReference::ground, AnalogReference::common, AnalogReference::diff};
  card.subdevices = {
      {SubdeviceKind::analog_input,
       16,
       65535,
       all,
       {{0, -5, 5}, {1, -2.5, 2.5}, {2, -1.25, 1.25}, {3, -0.625, 0.625}, {4, -10, 10}, {5, 0, 10}, {6, 0, 5}}},
      {SubdeviceKind::analog_output, 2, 65535, single_ended, {{0, -5, 5}, {1, -10, 10}, {2, 0, 5}, {3, 0, 10}}},
      {SubdeviceKind::digital_input, 16, 1, {}, {}},
      {SubdeviceKind::digital_output, 16, 1, {}, {}}};
  return card;
}

std::string refusal(const ComediOptions& options, const CardDescription& card) {
  try {
    (void)match(options, card);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CardDescription, FindsRangesByTheirVolts) {
  const CardMatch found = match(pci1716_options(), pci1716());
  EXPECT_EQ(found.feedback_range, 5U);
  EXPECT_EQ(found.command_range, 0U);
  EXPECT_EQ(found.last_code, 65535U);
  EXPECT_FALSE(found.enable_is_bidirectional);
  ComediOptions options = pci1716_options();
  options.command.range_min_V = -10.0;
  options.command.range_max_V = 10.0;
  EXPECT_EQ(match(options, pci1716()).command_range, 1U);
}

TEST(CardDescription, SaysWhichRangesThereAreInsteadOfTheWantedOne) {
  ComediOptions options = pci1716_options();
  options.command.range_min_V = -7.0;
  EXPECT_EQ(refusal(options, pci1716()),
            "/dev/comedi0: the card differs from the rig file; correct the file or the wiring\n"
            "/dev/comedi0: comedi.command: expected the range -7..5 V, the card has -5..5, -10..10, 0..5, 0..10 V");
}

TEST(CardDescription, NamesTheWrongBoardBeforeAnythingElse) {
  CardDescription card = pci1716();
  card.board = "comedi_test";
  card.subdevices.clear();
  EXPECT_EQ(refusal(pci1716_options(), card),
            "/dev/comedi0: the card differs from the rig file; correct the file or the wiring\n"
            "/dev/comedi0: comedi.board: expected \"pci1716\", the card has \"comedi_test\"");
  card = pci1716();
  card.driver = "adv_pci1720";
  EXPECT_NE(refusal(pci1716_options(), card).find("driver: expected \"adv_pci1710\", the card has \"adv_pci1720\""),
            std::string::npos);
}

TEST(CardDescription, NamesEveryDifferenceAtOnce) {
  ComediOptions options = pci1716_options();
  options.resolution_bits = 12;
  options.feedback.channel = 16;
  options.command.reference = AnalogReference::diff;
  options.emergency_stop->subdevice = 3;
  options.enable->subdevice = 7;
  options.heartbeat->channel = 20;
  EXPECT_EQ(
      refusal(options, pci1716()),
      "/dev/comedi0: the card differs from the rig file; correct the file or the wiring\n"
      "/dev/comedi0: comedi.feedback.channel: expected 16, the card has channels 0 to 15 on subdevice 0\n"
      "/dev/comedi0: comedi.resolution_bits: expected 12 bit for command, the card has 16 bit\n"
      "/dev/comedi0: comedi.command.reference: expected \"diff\", the card has ground, common\n"
      "/dev/comedi0: comedi.emergency_stop.subdevice: expected digital input at 3, the card has digital output, 16 "
      "channels\n"
      "/dev/comedi0: comedi.enable.subdevice: expected digital output at 7, the card has 4 subdevices\n"
      "/dev/comedi0: comedi.heartbeat.channel: expected 20, the card has channels 0 to 15 on subdevice 3");
}

TEST(CardDescription, TakesLinesThatGoBothWaysAndSaysSo) {
  CardDescription card = pci1716();
  card.subdevices[2].kind = SubdeviceKind::digital_io;
  card.subdevices[3].kind = SubdeviceKind::digital_io;
  const CardMatch found = match(pci1716_options(), card);
  EXPECT_TRUE(found.emergency_stop_is_bidirectional);
  EXPECT_TRUE(found.enable_is_bidirectional);
  EXPECT_TRUE(found.heartbeat_is_bidirectional);
}

TEST(CardDescription, NeedsNoLineThatIsNotConfigured) {
  ComediOptions options = pci1716_options();
  options.emergency_stop.reset();
  options.enable.reset();
  options.heartbeat.reset();
  CardDescription card = pci1716();
  card.subdevices.resize(2);
  EXPECT_EQ(refusal(options, card), "accepted");
}

TEST(CardDescription, ReadsAsOneLineASubdevice) {
  EXPECT_EQ(to_lines(pci1716()).substr(0, 100),
            "subdevice 0: analog input, 16 channels, 16 bit, -5..5, -2.5..2.5, -1.25..1.25, -0.625..0.625, -10..1");
}

}  // namespace
}  // namespace eha::hal
