// SPDX-License-Identifier: GPL-3.0-or-later
// What loggers write beside the rows: codes for missing values, temperatures, a clock beside each channel, set points.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/import.hpp"
#include "daemon/importer/missing_codes.hpp"
#include "tests/unit/importer/bench_file.hpp"

namespace eha::importer {
namespace {

class LoggerFile : public BenchFile {};

/// A rod that follows a sine, 300 rows of 0.01 s. @param rod  of a row, as written
std::string rod_file(const std::string& header, const std::function<std::string(int, double)>& row) {
  std::string text = header;
  double place = 100.0;
  for (int k = 0; k < 300; ++k) {
    const double volts = std::sin(0.05 * k);
    text += row(k, volts) + fmt::format("{:.2f}\n", place);
    place += 0.12 * volts;
  }
  return text;
}

TEST_F(LoggerFile, WithACodeForMissingValuesIsAskedAbout) {
  const auto with = [&](const std::string& code, int first, int last) {
    std::string text = "Time [s],Valve [V],Rod [mm]\n";
    for (int k = 0; k < 300; ++k) {
      text += fmt::format("{:.2f},{:.3f},{}\n", 0.01 * k, std::sin(0.05 * k),
                          k >= first && k < last ? code : fmt::format("{:.2f}", 100.0 + 5.0 * std::sin(0.03 * k)));
    }
    return write("codes.csv", text);
  };
  for (const char* code : {"-9999", "-999", "9999", "-99999", "1e30", "3.4e38", "-3.4028235e+38", "-999.25"}) {
    const auto path = with(code, 100, 140);
    Options options;
    options.command = "eha fit codes.csv";
    const std::string refusal = refusal_of(path, options);
    EXPECT_NE(refusal.find("40 rows of the output hold "), std::string::npos) << code << ": " << refusal;
    EXPECT_NE(refusal.find("a code for missing values"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("`eha fit codes.csv --resample`"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("`eha fit codes.csv --from 1.4`"), std::string::npos) << refusal;
    options.resample = true;
    const Imported filled = import_record(path, options);
    EXPECT_EQ(filled.record.unmeasured.size(), 40U) << code;
    EXPECT_LT(filled.record.output.maxCoeff(), 106.0) << code;
  }
  EXPECT_EQ(refusal_of(with("123.4", 10, 12)).find("a code for"), std::string::npos);
  for (const char* word : {"---", "OVLD", "OL", "over", "#DIV/0!", "OVERFLOW"}) {
    const std::string refusal = refusal_of(with(word, 100, 102));
    EXPECT_NE(refusal.find("--resample` fills missing values"), std::string::npos) << word << ": " << refusal;
  }
}

TEST_F(LoggerFile, WithNinesAmongItsPlacesIsNotSaidToMissThem) {
  std::string text = "Time [s],Valve [V],Rod [um]\n";
  for (int k = 0; k < 300; ++k) {
    text += fmt::format("{:.2f},{:.3f},{}\n", 0.01 * k, std::sin(0.05 * k),
                        std::lround(9999.0 + 800.0 * std::sin(0.03 * k)));
  }
  EXPECT_EQ(refusal_of(write("um.csv", text)), "");
}

TEST_F(LoggerFile, TakesNoTemperatureForTheTime) {
  for (const char* name :
       {"T_oil [degC]", "T_oil", "T", "T_\u00d6l", "Oil temperature [\u00b0C]", "T [\u00b0C]", "T_tank"}) {
    for (const bool rises : {false, true}) {
      const auto degrees = [&](int k) { return rises ? 41.31 + 0.01 * k : 41.0 + 0.1 * (k % 3); };
      const auto dated =
          write("dated.csv", rod_file(fmt::format("timestamp,u_valve [V],{},x [mm]\n", name), [&](int k, double u) {
                  return fmt::format("2025-11-21T08:14:{:06.3f}Z,{:.4f},{:.2f},", 0.01 * k, u, degrees(k));
                }));
      EXPECT_NE(import_record(dated, {}).guess.find("time 1 \"timestamp\""), std::string::npos) << name;
      Options even;
      even.period_s = 0.01;
      EXPECT_EQ(import_record(dated, even).record.output_channel.unit, "mm") << name;
      if (rises && std::string(name) == "T") continue;  // a time without a unit, for what it shows
      const auto bare = write("bare.csv", rod_file(fmt::format("u_valve [V],{},x [mm]\n", name), [&](int k, double u) {
                                return fmt::format("{:.4f},{:.2f},", u, degrees(k));
                              }));
      EXPECT_NE(refusal_of(bare).find("--period SECONDS`"), std::string::npos) << name << ": " << refusal_of(bare);
      EXPECT_EQ(import_record(bare, even).record.output_channel.unit, "mm") << name;
      EXPECT_EQ(import_record(bare, even).record.input_channel.unit, "V") << name;
    }
  }
}

/// As TwinCAT's Scope View exports its channels: a clock beside each.
std::string scope_of(double second_clock) {
  std::string text =
      "Name\tYT Scope Project\nFile\tC:\\Scope\\Axis.svdx\nStarttime of export\t134082944430000000\n\n"
      "Name\tu_Ventil\tName\tx_Ist\nSymbolComment\t\tSymbolComment\t\nData-Type\tREAL64\tData-Type\tREAL64\n"
      "SampleTime[ms]\t10\tSampleTime[ms]\t10\nSymbolName\tMAIN.u_Ventil\tSymbolName\tMAIN.x_Ist\n"
      "Offset\t0\tOffset\t0\nScaleFactor\t1\tScaleFactor\t1\nUnit\t(V)\tUnit\t(mm)\n\n";
  for (int k = 0; k < 300; ++k) {
    text += fmt::format("{}\t{}\t{}\t{}\n", 10 * k, with_comma(std::sin(0.05 * k), 5), 10 * k + second_clock,
                        with_comma(100.0 - 2.0 * std::cos(0.05 * k), 5));
  }
  return text;
}

TEST_F(LoggerFile, OfTwinCatHasNamesUnitsAndPeriod) {
  const Imported imported = import_record(write("scope.csv", scope_of(0.0)), {});
  EXPECT_EQ(imported.record.input_channel.name, "u_Ventil") << imported.guess;
  EXPECT_EQ(imported.record.input_channel.unit, "V");
  EXPECT_EQ(imported.record.output_channel.name, "x_Ist");
  EXPECT_EQ(imported.record.output_channel.unit, "mm");
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  EXPECT_EQ(imported.record.input.size(), 300);
}

TEST_F(LoggerFile, OfTwinCatWithClocksThatDifferIsRefused) {
  const std::string refusal = refusal_of(write("scope.csv", scope_of(5.0)));
  EXPECT_NE(refusal.find("the time of x_Ist is 5 where that of u_Ventil is 0"), std::string::npos) << refusal;
}

TEST_F(LoggerFile, WithAnOutputThatDropsOutIsFilledByACommand) {
  const auto text = [](int length, double from) {
    return Rig::rows("time_s,voltage_V,position_mm\n", [&](int k) {
      const bool is_lost = (k >= 60 && k < 60 + length) || (k >= 200 && k < 200 + length);
      return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, Rig::volts(k), is_lost ? 0.0 : Rig::place(k) + from);
    });
  };
  const auto path = write("drops.csv", text(10, 0.0));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("the output drops to 0 and comes back within a row in 2 places, 20 rows in all"),
            std::string::npos)
      << refusal;
  ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
  const Imported filled = import_record(path, {.resample = true});
  EXPECT_EQ(filled.record.unmeasured.size(), 20U);
  EXPECT_GT(filled.record.output.minCoeff(), 35.0);
  // A rod that passes through 0, or rests there, drops nowhere.
  EXPECT_EQ(import_record(write("through.csv", text(1, -50.0)), {.keep_lone_rows = true}).record.input.size(),
            Rig::kRows);
  EXPECT_FALSE(dropouts(std::vector<double>{0, 0, 0, 0, 1, 2, 1, 0, 0, 0, 0, 1, 2, 3, 2, 1, 0, 0, 0, 0}));
  EXPECT_FALSE(dropouts(std::vector<double>{5, 0, 0, 0, 0, 5, 5, 0, 0, 0, 0, 5, 0, 5, 5, 5, 5, 5})) << "a square wave";
}

TEST_F(LoggerFile, OfAClosedLoopIsStillOneAfterItsImport) {
  const auto path = write("loop.csv", rod_file("Time [s],Set point [mm],Valve [V],Rod [mm]\n", [](int k, double u) {
                            return fmt::format("{:.2f},{},{:.4f},", 0.01 * k, 100 + k / 100, u);
                          }));
  const Imported imported = import_record(path, {});
  ASSERT_FALSE(imported.remarks.empty());
  EXPECT_NE(imported.remarks.front().find("is a set point, so that a controller"), std::string::npos);
  // Names as of a record, but more columns than one has: which were taken is said, and what a set point makes of them.
  const Imported plain =
      import_record(write("plain.csv", Rig::rows("time_s,reference_V,valve_V,position_mm\n",
                                                 [](int k) {
                                                   return fmt::format("{:.2f},{:.4f},{:.4f},{:.4f}", 0.01 * k,
                                                                      std::cos(0.1 * k), Rig::volts(k), Rig::place(k));
                                                 })),
                    {});
  EXPECT_NE(plain.guess.find("input 3 \"valve_V\", output 4 \"position_mm\""), std::string::npos) << plain.guess;
  EXPECT_TRUE(plain.is_closed_loop);
  std::string text;
  write_record_csv(imported, [&](std::string_view piece) { text += piece; });
  const Imported again = import_record(write("again.csv", text), {});
  ASSERT_EQ(again.remarks.size(), 1U);
  EXPECT_NE(again.remarks.front().find("had a set point, so that a controller"), std::string::npos)
      << again.remarks.front();
  EXPECT_TRUE(again.guess.empty()) << "a record of our own";
  EXPECT_EQ(again.record.input, imported.record.input);
}

TEST_F(LoggerFile, WithRowsOffAnEvenGridSaysWhatMovingThemCosts) {
  const auto remark = [&](int every) {
    const auto path = write("jitter.csv", rod_file("Time [s],Valve [V],Rod [mm]\n", [every](int k, double u) {
                              return fmt::format("{:.3f},{:.4f},", 0.01 * k + (k % every == 1 ? 0.002 : 0.0), u);
                            }));
    Options options;
    options.resample = true;
    const Imported imported = import_record(path, options);
    return imported.remarks.empty() ? "" : imported.remarks.front();
  };
  EXPECT_NE(remark(5).find("rows were moved by up to 0.002 s to an even step of 0.01 s"), std::string::npos)
      << remark(5);
  EXPECT_NE(remark(2).find("rows were up to 0.002 s off an even step of 0.01 s: as if their times were those of the "
                           "samples, the output is interpolated, and the input the mean over each step"),
            std::string::npos)
      << remark(2);
  EXPECT_NE(remark(2).find("--period 0.01 takes them so"), std::string::npos) << remark(2);
}

TEST_F(LoggerFile, ThatEndsWithinANumberLosesThatRow) {
  const std::string text = Rig::rows("time_s,voltage_V,displacement_mm\n", [](int k) {
    return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, Rig::volts(k), Rig::place(k));
  });
  for (const std::size_t digits : {1U, 3U, 5U}) {  // of "6.1234\n"
    const Imported cut = import_record(write("cut.csv", text.substr(0, text.size() - 1 - digits)), {});
    EXPECT_EQ(cut.record.output.size(), Rig::kRows - 1) << digits;
    ASSERT_FALSE(cut.remarks.empty());
    EXPECT_NE(cut.remarks.front().find("cut.csv:301: the file ends within the number"), std::string::npos)
        << cut.remarks.front();
  }
  const Imported whole = import_record(write("whole.csv", text.substr(0, text.size() - 1)), {});
  EXPECT_EQ(whole.record.output.size(), Rig::kRows) << "a last line without an end";
  const Imported ended = import_record(write("ended.csv", text.substr(0, text.size() - 4) + "\n"), {});
  EXPECT_EQ(ended.record.output.size(), Rig::kRows) << "a short number with an end of the line";
}

TEST_F(LoggerFile, WithEachRowTwiceIsReadOnceByTheCommandOfItsRefusal) {
  const auto text = [](bool are_copies) {
    return Rig::rows("time_s,voltage_V,displacement_mm\n", [are_copies](int k) {
      const int at = are_copies ? k / 2 : k;
      return fmt::format("{:.3f},{:.4f},{:.4f}", 0.02 * (k / 2), Rig::volts(at), Rig::place(at));
    });
  };
  const auto path = write("twice.csv", text(true));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("150 of 300 rows repeat the row before, its time and all its values"), std::string::npos)
      << refusal;
  const Imported once = import_record(path, {.resample = true});
  EXPECT_EQ(once.record.output.size(), 150);
  EXPECT_DOUBLE_EQ(once.record.step_s, 0.02);
  // Other values at a time that is shown twice are rows of their own: the clock is coarse.
  const auto coarse = write("coarse.csv", text(false));
  const Imported all = import_record(coarse, {.period_s = offered(refusal_of(coarse))});
  EXPECT_EQ(all.record.output.size(), 300) << refusal_of(coarse);
  EXPECT_DOUBLE_EQ(all.record.step_s, 0.01) << refusal_of(coarse);
}

TEST_F(LoggerFile, WithALateInputIsShiftedBack) {
  const auto path = write("late.csv", Rig::rows("time_s,voltage_V,displacement_mm\n", [](int k) {
                            return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, Rig::volts(k - 2), Rig::place(k));
                          }));
  const Imported late = import_record(path, {.input_late = 2});
  ASSERT_EQ(late.record.input.size(), Rig::kRows - 2);
  EXPECT_NEAR(late.record.input[0], Rig::volts(0), 1e-4);
  EXPECT_NEAR(late.record.output[0], Rig::place(0), 1e-4);
  EXPECT_THROW(static_cast<void>(import_record(path, {.input_late = 299})), DataError);
}

}  // namespace
}  // namespace eha::importer
