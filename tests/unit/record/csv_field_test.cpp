// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/csv_field.hpp"

#include <gtest/gtest.h>

namespace eha::record {
namespace {

TEST(CsvField, IsOneFieldWhateverItHolds) {
  EXPECT_EQ(csv_field("voltage_V"), "voltage_V");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a\"b"), "\"a\"\"b\"");
}

TEST(CsvField, MakesNoFormulaOfAName) {
  EXPECT_EQ(csv_name("=cmd|'/C calc'!A0_V"), "'=cmd|'/C calc'!A0_V");
  EXPECT_EQ(csv_name("=HYPERLINK(\"x\")"), "\"'=HYPERLINK(\"\"x\"\")\"");
  for (const char* name : {"+1_V", "-1_V", "@SUM_V"}) EXPECT_EQ(csv_name(name), "'" + std::string(name));
  EXPECT_EQ(csv_name("voltage_V"), "voltage_V");
}

}  // namespace
}  // namespace eha::record
