// SPDX-License-Identifier: GPL-3.0-or-later
// The order in which the comedi backend makes a card safe, seen from the card.
#include <comedilib.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "hal/comedi/comedi_rig.hpp"
#include "hal/comedi/safe_snapshot.hpp"
#include "pci1716_options.hpp"
#include "stand_in_comedi.hpp"

namespace eha::hal {
namespace {

using testing::StandInCard;
using Writes = std::vector<StandInCard::Write>;

/// A card that drives 2 V with the hydraulics on, what was written so far forgotten.
std::unique_ptr<Rig> driven_card() {
  testing::stand_in_card() = {};
  std::unique_ptr<Rig> rig = open_rig(testing::pci1716_options(), 0.0);
  AppliedCommand applied;
  EXPECT_EQ(rig->command(2.0, applied), RigStatus::ok);
  EXPECT_EQ(rig->set_enable(true), RigStatus::ok);
  EXPECT_EQ(testing::stand_in_card().digital_outputs & 1U, 1U);
  testing::stand_in_card().writes.clear();
  return rig;
}

/// A card whose lines change direction eight at a time, with the emergency stop beside the enable line.
ComediOptions one_subdevice(unsigned emergency_stop_channel) {
  testing::stand_in_card() = {};
  testing::stand_in_card().port_lines = 8;
  ComediOptions options = testing::pci1716_options();
  options.emergency_stop = DigitalLine{.subdevice = 3, .channel = emergency_stop_channel, .active = ActiveLevel::low};
  return options;
}

TEST(CardDirections, OfAnInputInThePortOfAnOutputAreRefused) {
  const ComediOptions options = one_subdevice(2);
  try {
    static_cast<void>(open_rig(options, 0.0));
    FAIL() << "opened: the emergency stop reads the output's latch";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("comedi.enable: subdevice 3 line 0 became an input"), std::string::npos)
        << error.what();
  }
  // No output is left against the contact of the emergency stop.
  EXPECT_EQ(testing::stand_in_card().directions[3][2], static_cast<unsigned>(COMEDI_INPUT));
}

TEST(CardDirections, OfPortsOfTheirOwnAreKept) {
  const std::unique_ptr<Rig> rig = open_rig(one_subdevice(8), 0.0);
  EXPECT_EQ(testing::stand_in_card().directions[3][8], static_cast<unsigned>(COMEDI_INPUT));
  EXPECT_EQ(testing::stand_in_card().directions[3][0], static_cast<unsigned>(COMEDI_OUTPUT));
}

TEST(CardSafe, SwitchesTheHydraulicsOffBeforeAnOutputThatTimesOut) {
  const std::unique_ptr<Rig> rig = driven_card();
  StandInCard& card = testing::stand_in_card();
  card.output_times_out = true;
  EXPECT_EQ(rig->make_safe(), RigStatus::timed_out);
  EXPECT_EQ(card.writes, (Writes{StandInCard::Write::enable_off, StandInCard::Write::output}));
  EXPECT_EQ(card.digital_outputs & 1U, 0U);
}

TEST(CardSafe, WritesTheSafeVoltageThoughTheEnableLineIsRefused) {
  const std::unique_ptr<Rig> rig = driven_card();
  StandInCard& card = testing::stand_in_card();
  card.enable_refused = true;
  EXPECT_EQ(rig->make_safe(), RigStatus::io_error);
  EXPECT_EQ(card.writes, (Writes{StandInCard::Write::enable_off, StandInCard::Write::output}));
  EXPECT_EQ(card.output_code, 32768U);
}

TEST(CardSafe, IsMadeInTheSameOrderFromASnapshot) {
  const std::unique_ptr<Rig> rig = driven_card();
  SafeCard guard(safe_snapshot_from_text(rig->safe_snapshot(), "safe.json"));
  StandInCard& card = testing::stand_in_card();
  card.output_times_out = true;
  EXPECT_THROW(guard.make_safe(std::chrono::milliseconds(0)), DeviceError);
  EXPECT_EQ(card.writes, (Writes{StandInCard::Write::enable_off, StandInCard::Write::output}));
  card.output_times_out = false;
  EXPECT_NO_THROW(guard.make_safe(std::chrono::milliseconds(0)));
  EXPECT_EQ(card.output_code, 32768U);
}

/// The guard of a driven card.
struct Guarded {
  std::unique_ptr<Rig> rig = driven_card();
  SafeCard guard{safe_snapshot_from_text(rig->safe_snapshot(), "safe.json")};
  StandInCard& card = testing::stand_in_card();
};

TEST(CardSafe, NeedsNoDeviceNodeOnceItIsKeptOpen) {
  for (const int error : {ENOENT, EMFILE, EBUSY, EACCES, ENXIO}) {
    Guarded guarded;
    ASSERT_TRUE(guarded.guard.keep_open());
    guarded.card.open_error = error;
    EXPECT_TRUE(guarded.guard.switch_off()) << error;
    EXPECT_EQ(guarded.card.digital_outputs & 1U, 0U) << error;
    EXPECT_NO_THROW(guarded.guard.make_safe(std::chrono::milliseconds(0))) << error;
    EXPECT_EQ(guarded.card.output_code, 32768U) << error;
  }
}

TEST(CardSafe, OpensACardAnewThatWasRemovedAndWaitsForItWhateverTheCause) {
  for (const int error : {ENOENT, EMFILE, EBUSY, EACCES, ENXIO}) {
    Guarded guarded;
    ASSERT_TRUE(guarded.guard.keep_open());
    ++guarded.card.removals;
    guarded.card.open_error = error;
    guarded.card.open_failures = 5;
    EXPECT_FALSE(guarded.guard.switch_off()) << error;
    EXPECT_NO_THROW(guarded.guard.make_safe(std::chrono::seconds(10))) << error;
    EXPECT_EQ(guarded.card.digital_outputs & 1U, 0U) << error;
    EXPECT_EQ(guarded.card.output_code, 32768U) << error;
  }
}

TEST(CardSafe, WaitsForACardThatItHasNotOpenedBeforeWhateverTheCause) {
  for (const int error : {ENOENT, EMFILE, EBUSY, EACCES, ENXIO}) {
    Guarded guarded;
    guarded.card.open_error = error;
    guarded.card.open_failures = 5;
    EXPECT_NO_THROW(guarded.guard.make_safe(std::chrono::seconds(10))) << error;
    EXPECT_EQ(guarded.card.digital_outputs & 1U, 0U) << error;
    EXPECT_EQ(guarded.card.output_code, 32768U) << error;
  }
}

TEST(CardSafe, SaysAfterItsPatienceThatThereIsNoCard) {
  Guarded guarded;
  guarded.card.open_error = ENOENT;
  EXPECT_FALSE(guarded.guard.keep_open());
  EXPECT_THROW(guarded.guard.make_safe(std::chrono::milliseconds(50)), DeviceError);
  EXPECT_LT(guarded.card.open_failures, (1 << 30) - 2) << "tried more than once";
}

}  // namespace
}  // namespace eha::hal
