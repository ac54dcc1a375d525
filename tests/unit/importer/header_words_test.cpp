// SPDX-License-Identifier: GPL-3.0-or-later
// What headers and the lines above them say of the time and of the columns' roles.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/importer/imported_file.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

/// 300 rows of "time,u,y" whose clock stands at start + (k step, rounded).
std::string counted(const char* header, double step, double start = 0.0) {
  std::string text = std::string(header) + "\n";
  for (int k = 0; k < 300; ++k) {
    text += fmt::format("{:.0f},{:.4f},{:.4f}\n", start + std::round(step * k), std::sin(0.05 * k),
                        2.0 + std::sin(0.05 * k - 0.5));
  }
  return text;
}

TEST(TimeUnit, ReadsATimeColumnNamedAfterItsUnit) {
  const test::TemporaryFolder folder;
  for (const char* header : {"ms,u_V,y_mm", "millis,cmd,pos", "msec,u,y", "Millisekunden,u,y", "Time ms,u,y"}) {
    EXPECT_NEAR(import_record(folder.write("r.csv", counted(header, 10.0)), {}).record.step_s, 0.01, 1e-9) << header;
  }
  for (const char* header : {"micros,u,y", "usec,u,y"}) {
    const auto path = folder.write("r.csv", counted(header, 1e4, 4.2e9));
    EXPECT_NEAR(import_record(path, {}).record.step_s, 0.01, 1e-9) << header;
  }
  EXPECT_NEAR(import_record(folder.write("r.csv", counted("Time ms,Valve V,Rod mm", 10.0)), {}).record.step_s, 0.01,
              1e-9);
  EXPECT_NEAR(import_record(folder.write("r.csv", counted("min,u,y", 1.0)), {}).record.step_s, 60.0, 1e-9);
}

TEST(TimeUnit, AsksForTheUnitOfAClockOfUnevenCounts) {
  const test::TemporaryFolder folder;
  for (const double step : {10.4, 2.5, 0.7}) {
    const auto path = folder.write("r.csv", counted("t,u,y", step));
    for (const Options& options : {Options{}, Options{.resample = true}, Options{.time = "t", .resample = true}}) {
      try {
        FAIL() << import_record(path, options).guess;
      } catch (const DataError& error) {
        const std::string refusal = error.what();
        if (step < 1.0) continue;  // rows alike: the coarse clock is told
        EXPECT_NE(refusal.find("has no unit; if in seconds: `"), std::string::npos) << refusal;
        EXPECT_NE(refusal.find(
                      fmt::format("; if in milliseconds: `eha import {} --period {:.9g}`", path.string(), 1e-3 * step)),
                  std::string::npos)
            << refusal;
      }
    }
  }
}

TEST(SetPoint, IsNoOutputOfAnExampleEither) {
  const test::TemporaryFolder folder;
  std::string text = "Zeit [min];Sollwert [°C];Temperatur [°C];Stellgrad [%]\n";
  for (int k = 0; k < 200; ++k) {
    text += fmt::format("{};{};{};{}\n", k, k < 100 ? 60 : 75, 20.0 + 0.25 * k + 0.5 * (k % 3), k % 40 < 20 ? 80 : 20);
  }
  try {
    EXPECT_EQ(import_record(folder.write("thermostat.csv", text), {}).guess, "") << "taken unasked";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("--input 4 --output 3"), std::string::npos) << error.what();
  }
}

TEST(SetPoint, IsNoOutputThatIsTakenUnasked) {
  const test::TemporaryFolder folder;
  const auto taken = [&](const char* header) {
    try {
      return import_record(folder.write("r.csv", counted(header, 1.0)), {}).guess + " taken";
    } catch (const DataError& error) {
      return std::string(error.what());
    }
  };
  for (const char* header :
       {"Zeit [s],Ventil [V],Weg Soll [mm]", "t [s],Valve [V],Position command", "t [s],Servo [V],PosRef",
        "time [s],valve [V],setpoint", "t [s],Ventil [V],w [mm]", "Zeit [s],Ventil [V],Führungsgröße [mm]",
        "t [s],u_valve [V],Model Root/Controller/Setpoint/Out1 [mm]"}) {
    EXPECT_NE(taken(header).find("which columns are input and output?"), std::string::npos)
        << header << ": " << taken(header);
  }
  for (const char* header : {"t [s],Valve command,Position", "t [s],Command [V],Position [mm]", "t [s],u,y"}) {
    EXPECT_TRUE(taken(header).ends_with(" taken")) << header << ": " << taken(header);
  }
}

/// The refusal of 300 rows of "u,y" below these lines.
std::string refused_below(const std::string& lines) {
  const test::TemporaryFolder folder;
  std::string text = lines;
  for (int k = 0; k < 300; ++k) text += fmt::format("{:.4f};{:.4f}\n", std::sin(0.05 * k), std::sin(0.05 * k - 0.5));
  try {
    return "taken: " + import_record(folder.write("r.csv", text), {}).guess;
  } catch (const DataError& error) {
    return error.what();
  }
}

TEST(PeriodAboveRows, StandsBehindItsNameInOneLine) {
  const auto offers = [](const std::string& line, const char* period) {
    const std::string refusal = refused_below(line + "\nVentil [V];Weg [mm]\n");
    EXPECT_NE(refusal.find(std::string("--period ") + period + "`"), std::string::npos) << line << ": " << refusal;
  };
  offers("Abtastrate: 200 Hz", "0.005");
  offers("File: x\nScan rate: 100 Hz", "0.01");
  offers("Sample interval: 5 ms", "0.005");
  offers("# Sampling rate [Hz] = 1000", "0.001");
  offers("Sample Rate;2;kHz", "0.0005");
  offers("Abtastzeit 0,01 s", "SECONDS");  // a comma where the rows have points
  offers("Abtastrate: 200 U/min", "SECONDS");
  offers("Abtastrate: 200 Hz\nScan rate: 100 Hz", "SECONDS");
}

TEST(Octave, FilesOfItsOwnFormatsAreNamed) {
  const test::TemporaryFolder folder;
  for (const char* text :
       {"# Created by Octave 7.3.0, Wed Nov 25\n# name: t\n# type: matrix\n 0\n 0.01\n", "Octave-1-L\x01\x02\x03"}) {
    try {
      FAIL() << import_record(folder.write("r.mat", text), {}).guess;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find("Octave, `save -v7 FILE.mat`"), std::string::npos) << error.what();
    }
  }
}

TEST(Numbers, HaveNoBreakSpacesBetweenThousands) {
  const test::TemporaryFolder folder;
  for (const char* space : {"\xC2\xA0", "\xE2\x80\xAF", "\xA0"}) {
    std::string text = "Temps (s);Tension (mV);Position (um)\n";
    for (int k = 0; k < 20; ++k) text += fmt::format("0,{:02};-1{}026,{};75{}006,{}\n", k, space, k, space, k);
    const Imported imported = import_record(folder.write("r.csv", text), {});
    EXPECT_DOUBLE_EQ(imported.record.input[3], -1026.3);
    EXPECT_DOUBLE_EQ(imported.record.output[3], 75006.3);
  }
}

TEST(Numbers, MayHaveFortransExponent) {
  const test::TemporaryFolder folder;
  std::string text = "# time u y\n";
  for (int k = 0; k < 20; ++k) text += fmt::format(" {}.00000D-02 -1.02{:02}0D+00 7.50{:02}7D+01\n", k, k, k);
  const Imported imported = import_record(folder.write("r.dat", text), {});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  EXPECT_DOUBLE_EQ(imported.record.output[3], 75.0037);
}

TEST(KnownUnit, HasOneSpellingForEachUnit) {
  for (const auto& [written, unit] : std::vector<std::pair<std::string, std::string>>{{"inch", "in"},
                                                                                      {"inches", "in"},
                                                                                      {"Inch", "in"},
                                                                                      {"\"", "in"},
                                                                                      {"in", "in"},
                                                                                      {"um", "um"},
                                                                                      {"\u00b5m", "um"},
                                                                                      {"\u03bcm", "um"},
                                                                                      {"micron", "um"},
                                                                                      {"mV", "mV"},
                                                                                      {"mv", "mV"},
                                                                                      {"v", "V"},
                                                                                      {"V", "V"}}) {
    EXPECT_EQ(known_unit(written), unit) << written;
    EXPECT_EQ(record::channel_from_header("x_" + written).unit, unit) << written;
  }
  EXPECT_EQ(name_and_unit("u_v"), std::pair(std::string("u"), std::string("V")));
  EXPECT_EQ(name_and_unit("piston_v").second, "") << "a velocity";
}

TEST_F(ImportedFile, NamesInchesByTheirSign) {
  const Imported imported = import_record(
      write("sign.csv", Rig::rows("t [s],u [V],x [\"]\n",
                                  [](int k) {
                                    return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, Rig::volts(k), Rig::place(k));
                                  })),
      {});
  EXPECT_EQ(imported.record.output_channel.unit, "in") << imported.guess;
  EXPECT_EQ(imported.record.output_channel.name, "x");
}

TEST_F(ImportedFile, IsConvertedToTheInputOfAModel) {
  const ImportedInput input = import_input(
      write("mv.csv", Rig::rows("t [s],u [mV]\n",
                                [](int k) { return fmt::format("{:.2f},{:.1f}", 0.01 * k, 1e3 * Rig::volts(k)); })),
      {}, "V");
  EXPECT_EQ(input.series.channel.unit, "V");
  EXPECT_NEAR(input.series.values[7], Rig::volts(7), 1e-3);
}

TEST(UnitMeant, IsThatOfASlipOfThePen) {
  for (const auto& [written, meant] : std::vector<std::pair<std::string, std::string>>{{"mn", "mm"},
                                                                                       {"MV", "mV"},
                                                                                       {"Mm", "mm"},
                                                                                       {"mm", ""},
                                                                                       {"nm", ""},
                                                                                       {"Nm", ""},
                                                                                       {"degC", ""},
                                                                                       {"km", ""},
                                                                                       {"rpm", ""},
                                                                                       {"", ""}}) {
    EXPECT_EQ(unit_meant(written), meant) << written;
  }
}

}  // namespace
}  // namespace eha::importer
