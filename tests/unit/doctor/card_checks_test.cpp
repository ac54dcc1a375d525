// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/card_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hal/comedi/comedi_available.hpp"
#include "hal/comedi/comedi_rig.hpp"
#include "tests/unit/hal/pci1716_options.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::doctor {
namespace {

using hal::testing::pci1716_options;

/// A card that has what the wiring of pci1716_options() needs.
hal::CardDescription pci1716() {
  using hal::AnalogReference;
  using hal::SubdeviceKind;
  return {.board = "pci1716",
          .driver = "adv_pci1710",
          .subdevices = {{SubdeviceKind::analog_input, 16, 65535, {AnalogReference::diff}, {{5, 0, 10}}},
                         {SubdeviceKind::analog_output, 2, 65535, {AnalogReference::ground}, {{0, -5, 5}}},
                         {SubdeviceKind::digital_input, 16, 1, {}, {}},
                         {SubdeviceKind::digital_output, 16, 1, {}, {}}}};
}

CardFinding opened(hal::CardDescription card) {
  CardFinding finding;
  finding.card = std::move(card);
  return finding;
}

std::vector<std::string> failures(const std::vector<Check>& checks) {
  std::vector<std::string> names;
  for (const Check& check : checks) {
    if (check.level == Level::fail) names.push_back(check.name);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(CardChecks, PassTheCardOfTheRigFile) {
  const std::vector<Check> checks = check_card(pci1716_options(), opened(pci1716()));
  EXPECT_EQ(failures(checks), Names{});
  EXPECT_EQ(exit_code(checks), ExitCode::ok);
}

TEST(CardChecks, SayWhatTheWrongCardOffers) {
  hal::CardDescription card = pci1716();
  card.board = "comedi_test";
  const std::vector<Check> checks = check_card(pci1716_options(), opened(card));
  ASSERT_EQ(failures(checks), Names{"board"});
  EXPECT_EQ(exit_code(checks), ExitCode::device_unavailable);
  EXPECT_NE(checks.back().found.find("expected \"pci1716\", the card has \"comedi_test\""), std::string::npos);
  EXPECT_NE(checks.back().found.find("subdevice 1: analog output, 2 channels, 16 bit, -5..5 V"), std::string::npos);
}

TEST(CardChecks, PointToTheOutOfTreeDriverWhereTheKernelsLacksTheCard) {
  CardFinding finding;
  finding.code = ExitCode::device_unavailable;
  finding.error = "/dev/comedi0: no such file";
  finding.on_bus = true;
  finding.module = ModuleSupport::not_listed;
  const std::vector<Check> checks = check_card(pci1716_options(), finding);
  EXPECT_EQ(failures(checks), (Names{"device", "driver"}));
  EXPECT_EQ(exit_code(checks), ExitCode::device_unavailable);
  EXPECT_NE(checks.back().remedy.find("Linux-Comedi"), std::string::npos);
  finding.module = ModuleSupport::listed;
  EXPECT_EQ(failures(check_card(pci1716_options(), finding)), Names{"device"});
  finding.on_bus = false;
  EXPECT_EQ(failures(check_card(pci1716_options(), finding)), (Names{"device", "card"}));
}

TEST(CardChecks, AskForTheGroupWhereTheDeviceMayNotBeOpened) {
  if (!hal::comedi_available) GTEST_SKIP() << "this build has no comedi backend";
  CardFinding finding;
  finding.code = ExitCode::permission;
  finding.error = "/dev/comedi0: Permission denied";
  const std::vector<Check> checks = check_card(pci1716_options(), finding);
  EXPECT_EQ(failures(checks), Names{"device"});
  EXPECT_NE(checks.front().remedy.find("iocard"), std::string::npos);
  EXPECT_EQ(exit_code(checks), ExitCode::permission);
}

TEST(CardChecks, FindThatThereIsNoDevice) {
  const test::TemporaryFolder root;
  hal::ComediOptions options = pci1716_options();
  options.device = (root.path() / "comedi0").string();
  const CardFinding finding = find_card(options, root.path(), "6.1.0");
  EXPECT_FALSE(finding.card.has_value());
  EXPECT_EQ(finding.code, ExitCode::device_unavailable);
  EXPECT_NE(finding.error.find(options.device), std::string::npos);
  EXPECT_FALSE(finding.on_bus);
  EXPECT_EQ(finding.module, ModuleSupport::unknown);
}

TEST(CardChecks, WarnAboutEachSafetyLineThatTheRigFileDeclaresMissing) {
  hal::ComediOptions options = pci1716_options();
  const auto warned = [&] {
    const std::vector<Check> checks = check_lines(options);
    EXPECT_EQ(exit_code(checks), ExitCode::ok);
    return std::count_if(checks.begin(), checks.end(), [](const Check& check) { return check.level == Level::warn; });
  };
  EXPECT_EQ(warned(), 0);
  options.heartbeat.reset();
  EXPECT_EQ(warned(), 1);
  options.enable.reset();
  options.emergency_stop.reset();
  EXPECT_EQ(warned(), 3);
}

}  // namespace
}  // namespace eha::doctor
