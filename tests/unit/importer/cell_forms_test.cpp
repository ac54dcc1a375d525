// SPDX-License-Identifier: GPL-3.0-or-later
// Forms of cells and rows that some loggers and databases write.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "daemon/importer/import.hpp"
#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

class CellForms : public ImportedFile {};

TEST_F(CellForms, UnitsBehindTheNumbersAreThoseOfTheColumns) {
  for (const std::string sign : {",", ";", "\t"}) {
    const auto row = [&](int k) {
      return fmt::format("{0:.2f} s{3}{1:.4f} V{3}{2:.3f} mm", 0.01 * k, Rig::volts(k), Rig::place(k), sign);
    };
    const Imported file =
        import_record(write("cells.csv", Rig::rows("Time" + sign + "Valve" + sign + "Rod\n", row)), {});
    EXPECT_EQ(file.record.input_channel.unit, "V");
    EXPECT_EQ(file.record.output_channel.unit, "mm");
    EXPECT_NEAR(file.record.step_s, 0.01, 1e-12);
    ASSERT_EQ(file.record.output.size(), Rig::kRows);
    EXPECT_NEAR(file.record.output[17], Rig::place(17), 1e-3);
    EXPECT_NE(file.guess.find("units in the cells"), std::string::npos) << file.guess;
  }
}

TEST_F(CellForms, ACellInAnotherUnitThanTheOthersIsRefused) {
  const auto row = [](int k) {
    return fmt::format("{:.2f};{:.4f} V;{:.3f} {}", 0.01 * k, Rig::volts(k), Rig::place(k), k == 200 ? "cm" : "mm");
  };
  const std::string refusal = refusal_of(write("cells.csv", Rig::rows("Time [s];Valve;Rod\n", row)));
  EXPECT_NE(refusal.find("cells.csv:202: "), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("cm\""), std::string::npos) << refusal;
}

TEST_F(CellForms, AnotherUnitInTheCellsThanInTheHeaderIsSaid) {
  const auto row = [](int k) {
    return fmt::format("{:.2f};{:.4f} V;{:.3f} mm", 0.01 * k, Rig::volts(k), Rig::place(k));
  };
  const Imported file = import_record(write("cells.csv", Rig::rows("Time [s];Valve [mV];Rod\n", row)), {});
  const std::string remarks = fmt::format("{}", fmt::join(file.remarks, "\n"));
  EXPECT_NE(remarks.find("mV in its name and V below it"), std::string::npos) << remarks;
}

TEST_F(CellForms, TheMinusOfTypesettersIsOne) {
  const auto row = [](int k) {
    std::string volts = fmt::format("{:.4f}", Rig::volts(k));
    if (volts.starts_with('-')) volts.replace(0, 1, "\xE2\x88\x92");
    return fmt::format("{:.2f},{},{:.3f}", 0.01 * k, volts, Rig::place(k));
  };
  const Imported file = import_record(write("minus.csv", Rig::rows("t [s],u [V],y [mm]\n", row)), {});
  ASSERT_LT(Rig::volts(40), -1.0);
  EXPECT_NEAR(file.record.input[40], Rig::volts(40), 1e-4);
}

TEST_F(CellForms, MonthsHaveNames) {
  for (const char* form : {"13-Mar-2026 09:59:{:06.3f}", "13 Mar 2026 09:59:{:06.3f}", "Mar 13 2026 09:59:{:06.3f}"}) {
    const auto row = [&](int k) {
      return fmt::format("{},{:.4f},{:.3f}", fmt::format(fmt::runtime(form), 30.0 + 0.02 * k), Rig::volts(k),
                         Rig::place(k));
    };
    const Imported file = import_record(write("months.csv", Rig::rows("Date,u [V],y [mm]\n", row)), {});
    EXPECT_NEAR(file.record.step_s, 0.02, 1e-9) << form;
  }
}

TEST_F(CellForms, ACommandWrittenWhereItChangesIsHeld) {
  const auto level = [](int k) { return k / 10 % 3; };
  const auto row = [&](int k) {
    const bool changes = k == 0 || level(k) != level(k - 1);
    return fmt::format("{:.2f},{},{:.3f}", 0.01 * k, changes ? std::to_string(level(k)) : "", Rig::place(k));
  };
  const auto path = write("command.csv", Rig::rows("t [s],u [V],y [mm]\n", row));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("--resample` fills missing values"), std::string::npos) << refusal;
  Options options;
  options.resample = true;
  const Imported file = import_record(path, options);
  EXPECT_TRUE(file.record.unmeasured.empty());
  ASSERT_EQ(file.record.input.size(), Rig::kRows);
  for (int k = 0; k < Rig::kRows; ++k) EXPECT_EQ(file.record.input[k], level(k)) << k;
}

TEST_F(CellForms, ASineThatLostMostOfItsCellsIsNoSuchCommand) {
  const auto row = [](int k) {
    return fmt::format("{:.2f},{},{:.3f}", 0.01 * k, k % 3 == 0 ? fmt::format("{:.4f}", Rig::volts(k)) : "",
                       Rig::place(k));
  };
  Options options;
  options.resample = true;
  const Imported file = import_record(write("lost.csv", Rig::rows("t [s],u [V],y [mm]\n", row)), options);
  EXPECT_GT(file.record.unmeasured.size(), 150U);
}

TEST_F(CellForms, ARowForEachValueIsPartedByTheCommandOfTheRefusal) {
  const auto row = [](int k) {
    return fmt::format("{0:.2f};Rod [mm];{2:.3f}\n{0:.2f};Valve [V];{1:.4f}", 0.01 * k, Rig::volts(k), Rig::place(k));
  };
  const std::string refusal = refusal_of(write("long.csv", Rig::rows("Time [s];Channel;Value\n", row)));
  const std::vector<std::string> commands = commands_of(refusal);
  ASSERT_GE(commands.size(), 2U) << refusal;
  std::string parting = commands[0];
  const std::string full = (folder_.path() / "long.csv").string();
  if (const std::size_t at = parting.find(full); at != std::string::npos) parting.replace(at, full.size(), "long.csv");
  ASSERT_TRUE(shell(parting)) << parting;
  const Imported file = import_record(folder_.path() / "long-columns.csv", {});
  EXPECT_EQ(file.record.input_channel.unit, "V");
  EXPECT_EQ(file.record.output_channel.unit, "mm");
  ASSERT_EQ(file.record.output.size(), Rig::kRows);
  EXPECT_NEAR(file.record.input[17], Rig::volts(17), 1e-4);
  EXPECT_NEAR(file.record.output[17], Rig::place(17), 1e-3);
}

}  // namespace
}  // namespace eha::importer
