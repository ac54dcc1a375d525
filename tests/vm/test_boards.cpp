// SPDX-License-Identifier: GPL-3.0-or-later
// The test boards themselves, on which the other tests depend.
#include <comedilib.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "board.hpp"

namespace eha::test {
namespace {

struct CloseDevice {
  void operator()(comedi_t* device) const { comedi_close(device); }
};
using Device = std::unique_ptr<comedi_t, CloseDevice>;

Device open_device() { return Device(comedi_open("/dev/comedi0")); }

constexpr unsigned kInput = 0;
constexpr unsigned kOutput = 1;
constexpr unsigned kDigitalInput = 2;
constexpr unsigned kDigitalOutput = 3;

TEST(KernelTestBoard, ReadsBackEveryCodeThatIsWritten) {
  const Board board("comedi_test");
  const Device device = open_device();
  ASSERT_TRUE(device);
  EXPECT_STREQ(comedi_get_board_name(device.get()), "comedi_test");
  for (const lsampl_t written : {0U, 1U, 0x7fffU, 0x8000U, 0xfffeU, 0xffffU}) {
    ASSERT_EQ(comedi_data_write(device.get(), kOutput, 0, 0, AREF_GROUND, written), 1);
    lsampl_t read = 0;
    ASSERT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &read), 1);
    EXPECT_EQ(read, written);
  }
}

TEST(StandInCard, LooksLikeThePci1716) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  EXPECT_STREQ(comedi_get_board_name(device.get()), "pci1716");
  EXPECT_STREQ(comedi_get_driver_name(device.get()), "adv_pci1710");
  EXPECT_EQ(comedi_get_subdevice_type(device.get(), kInput), COMEDI_SUBD_AI);
  EXPECT_EQ(comedi_get_subdevice_type(device.get(), kOutput), COMEDI_SUBD_AO);
  EXPECT_EQ(comedi_get_subdevice_type(device.get(), kDigitalInput), COMEDI_SUBD_DI);
  EXPECT_EQ(comedi_get_subdevice_type(device.get(), kDigitalOutput), COMEDI_SUBD_DO);
  EXPECT_EQ(comedi_get_n_channels(device.get(), kInput), 16);
  EXPECT_EQ(comedi_get_n_channels(device.get(), kOutput), 2);
  EXPECT_EQ(comedi_get_maxdata(device.get(), kInput, 0), 0xffffU);
  EXPECT_EQ(comedi_get_maxdata(device.get(), kOutput, 0), 0xffffU);
  const std::vector<std::pair<double, double>> ranges = {
      {-5, 5}, {-2.5, 2.5}, {-1.25, 1.25}, {-0.625, 0.625}, {-10, 10}, {0, 10}, {0, 5}, {0, 2.5}, {0, 1.25}};
  ASSERT_EQ(comedi_get_n_ranges(device.get(), kInput, 0), static_cast<int>(ranges.size()));
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const comedi_range* range = comedi_get_range(device.get(), kInput, 0, static_cast<unsigned>(i));
    ASSERT_NE(range, nullptr);
    EXPECT_DOUBLE_EQ(range->min, ranges[i].first);
    EXPECT_DOUBLE_EQ(range->max, ranges[i].second);
  }
}

TEST(StandInCard, CarriesVoltsFromItsOutputToItsInputAcrossRanges) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  for (const double volts : {-4.9, -1.0, 0.0, 0.3, 4.9}) {
    for (const unsigned output_range : {0U, 1U}) {   // +-5, +-10
      for (const unsigned input_range : {0U, 4U}) {  // +-5, +-10
        comedi_range* out = comedi_get_range(device.get(), kOutput, 0, output_range);
        comedi_range* in = comedi_get_range(device.get(), kInput, 0, input_range);
        const lsampl_t code = comedi_from_phys(volts, out, 0xffff);
        ASSERT_EQ(comedi_data_write(device.get(), kOutput, 0, output_range, AREF_GROUND, code), 1);
        lsampl_t read = 0;
        ASSERT_EQ(comedi_data_read(device.get(), kInput, 0, input_range, AREF_GROUND, &read), 1);
        const double output_lsb_V = (out->max - out->min) / 0xffff;
        const double input_lsb_V = (in->max - in->min) / 0xffff;
        EXPECT_NEAR(comedi_to_phys(read, in, 0xffff), volts, 0.51 * (output_lsb_V + input_lsb_V));
      }
    }
  }
}

TEST(StandInCard, ShowsTheOldCodeInTheNewRangeBeforeTheNewCode) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  EXPECT_EQ(read_wire().ao0_uV, 0);  // code 0 of 0..5 V
  const std::size_t before = read_wire_changes().size();
  ASSERT_EQ(comedi_data_write(device.get(), kOutput, 0, 1, AREF_GROUND, 0x8000), 1);
  const std::vector<WireChange> changes = read_wire_changes();
  ASSERT_EQ(changes.size(), before + 2);
  EXPECT_EQ(changes[before].value, -10'000'000);
  EXPECT_NEAR(static_cast<double>(changes[before + 1].value), 0.0, 20e6 / 0xffff);
}

TEST(StandInCard, FailsAsManyConversionsAsItIsTold) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  lsampl_t code = 0;
  board.set("ai_timeout", 2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &code), -1);
    EXPECT_EQ(comedi_errno(), ETIME);
  }
  EXPECT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &code), 1);
  board.set("ai_io_error", -1);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &code), -1);
    EXPECT_EQ(comedi_errno(), EIO);
  }
  board.set("ai_io_error", 0);
  EXPECT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &code), 1);
}

TEST(StandInCard, SticksAndReadsAllOnes) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  const auto write_then_read = [&](lsampl_t written) {
    EXPECT_EQ(comedi_data_write(device.get(), kOutput, 0, 0, AREF_GROUND, written), 1);
    lsampl_t read = 0;
    EXPECT_EQ(comedi_data_read(device.get(), kInput, 0, 0, AREF_GROUND, &read), 1);
    return read;
  };
  EXPECT_EQ(write_then_read(0x9000), 0x9000U);
  board.set("ai_stuck", 1);
  EXPECT_EQ(write_then_read(0xa000), 0x9000U);
  board.set("ai_stuck", 0);
  EXPECT_EQ(write_then_read(0xa000), 0xa000U);
  board.set("all_ones", 1);
  board.set("di", 0);
  EXPECT_EQ(write_then_read(0xa000), 0xffffU);
  lsampl_t bits = 0;
  ASSERT_GE(comedi_dio_bitfield2(device.get(), kDigitalInput, 0, &bits, 0), 0);
  EXPECT_EQ(bits, 0xffffU);
}

TEST(StandInCard, CarriesDigitalLinesBothWays) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  board.set("di", 0x8001);
  lsampl_t bits = 0;
  ASSERT_GE(comedi_dio_bitfield2(device.get(), kDigitalInput, 0, &bits, 0), 0);
  EXPECT_EQ(bits, 0x8001U);
  bits = 0xffff;
  ASSERT_GE(comedi_dio_bitfield2(device.get(), kDigitalOutput, 0x0005, &bits, 0), 0);
  EXPECT_EQ(read_wire().digital_outputs, 0x0005);
}

TEST(StandInCard, PutsItsOutputsAwayWhenItIsRemovedAndFailsEveryCallFromThenOn) {
  const Board board("pci1716_card");
  const Device device = open_device();
  ASSERT_TRUE(device);
  ASSERT_EQ(comedi_data_write(device.get(), kOutput, 0, 0, AREF_GROUND, 0xffff), 1);
  EXPECT_EQ(read_wire().ao0_uV, 5'000'000);
  board.set("removed", 1);
  EXPECT_EQ(read_wire().ao0_uV, 0);
  EXPECT_EQ(comedi_data_write(device.get(), kOutput, 0, 0, AREF_GROUND, 0xffff), -1);
  EXPECT_EQ(comedi_errno(), ENODEV);
  board.set("removed", 0);
}

}  // namespace
}  // namespace eha::test
