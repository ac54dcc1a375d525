// SPDX-License-Identifier: GPL-3.0-or-later
// Files laid out as other programs document theirs: each is read as the record that it is, or asked about with a
// command that reads it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

constexpr int kRows = 200;
constexpr double kStep_s = 1e-3;

double volts(int k) { return std::sin(0.1 * k); }
double place(int k) { return 50.0 + 10.0 * std::sin(0.1 * k - 0.5); }

std::string german(std::string text) {
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

std::string rows(const std::string& header, const std::function<std::string(int)>& row) {
  std::string text = header;
  for (int k = 0; k < kRows; ++k) text += row(k);
  return text;
}

/// A file, and the units that it tells; an empty unit is not told.
struct Program {
  std::string name;
  std::string file;
  std::string text;
  std::string input_unit;
  std::string output_unit;
  double output_factor = 1.0;  ///< of the column over place()
  Options answer = {};         ///< to the question that is asked; its command must hold `asked`
  std::string asked = {};      ///< empty: nothing is asked
  double input_factor = 1.0;   ///< of the column over volts()
};

std::vector<Program> programs() {
  const auto seconds = [](int k) { return kStep_s * k; };
  std::vector<Program> all;
  all.push_back(
      {"Advantech", "daq.csv",
       rows("Advantech DAQNavi DataLogger\r\nDevice: PCI-1716,BID#0\r\nSample Rate: 1000 Hz\r\n\r\n"
            "No.,Time,AI 0 (V),AI 1 (mm)\r\n",
            [&](int k) { return fmt::format("{},{:.3f},{:.5f},{:.5f}\r\n", k, seconds(k), volts(k), place(k)); }),
       "V", "mm"});
  all.push_back(
      {"ControlDesk", "dspace.csv",
       rows("descriptor,,,\npath,,Model Root/valve,Model Root/rod\ntrace,time,u,y\nunit,s,V,mm\n",
            [&](int k) { return fmt::format("trace_values,{:.4f},{:.6f},{:.6f}\n", seconds(k), volts(k), place(k)); }),
       "V", "mm"});
  all.push_back({"Mts", "specimen.dat",
                 rows("MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\nData Header:\tCyclic\tTime:\t0.5\tSec\nStation Name: bench\n\n"
                      "Time\tAxial Displacement\tAxial Command\nSec\tmm\tV\n",
                      [&](int k) { return fmt::format("{:.6f}\t{:.6f}\t{:.6f}\n", seconds(k), place(k), volts(k)); }),
                 "V", "mm"});
  all.push_back(
      {"Instron", "bluehill.csv",
       rows("\"Specimen 1\"\n\"Test run\",\"23.11.2026\"\n\n\"Time\",\"Command\",\"Extension\"\n"
            "\"(s)\",\"(V)\",\"(mm)\"\n",
            [&](int k) { return fmt::format("\"{:.4f}\",\"{:.5f}\",\"{:.5f}\"\n", seconds(k), volts(k), place(k)); }),
       "V", "mm"});
  all.push_back(
      {"PicoScope",
       "pico.csv",
       rows("Time,Channel A,Channel B\n(ms),(V),(mV)\n\n",
            [&](int k) { return fmt::format("{:.8f},{:.8f},{:.8f}\n", 1.0 * k, volts(k), 100.0 * place(k)); }),
       "V",
       "mV",
       100.0,
       {.input = "2", .output = "3"},
       "--input 2 --output 3"});
  all.push_back(
      {"Catman", "catman.asc",
       rows("HBM_CATMAN_DATAFILE_50\nDATEI: messung.bin\nT0 = 23.11.2026 10:00:00\nWerte: 200\n"
            "Zeit \tVentil \tWeg \ns\tV\tmm\n",
            [&](int k) { return german(fmt::format("{:.6f}\t{:.6f}\t{:.6f}\n", seconds(k), volts(k), place(k))); }),
       "V", "mm"});
  // ControlDesk 7 with semicolons: rows named in their first field, some of them between units and data.
  all.push_back({"ControlDeskRows", "measurement.csv",
                 rows("descriptor;value;;;\nname;Measurement 1;;;\n;;;;\n"
                      "path;\"\";\"Model Root/Valve/In1\";\"Model Root/Sensor/Out1\";\nunit;\"s\";\"V\";\"mm\";\n"
                      "description;\"\";\"\";\"\";\nraster;\"\";\"HostService\";\"HostService\";\ntrace_values;;;;\n",
                      [&](int k) { return fmt::format(";{:.6f};{:.4f};{:.6f}\n", seconds(k), volts(k), place(k)); }),
                 "V", "mm"});
  // catman: a row of the hardware below the units.
  all.push_back(
      {"CatmanHardware", "hardware.asc",
       rows("HBM_CATMAN_DATAFILE_40\nEXPORT CHANNELS=3 LENGTH=9000\nDatum/Zeit: 20.11.2026 14:03:17\n\n"
            "Zeit  1 - Standardmessrate\tVentil_U\tWeg_1\n[s]\t[V]\t[mm]\n"
            "MX840A_0 hw\tMX840A CH 1 SlowADC\tMX840A CH 2\n",
            [&](int k) { return german(fmt::format("{:.6f}\t{:.6f}\t{:.6f}\n", seconds(k), volts(k), place(k))); }),
       "V", "mm"});
  // LabVIEW: the units are in the second header.
  all.push_back({"LabviewUnits", "units.lvm",
                 rows("LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n"
                      "***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t200\t200\t\n"
                      "Y_Unit_Label\tVolts\tMillimeters\t\nX_Dimension\tTime\tTime\t\nDelta_X\t0.001\t0.001\t\n"
                      "***End_of_Header***\t\t\t\nX_Value\tValve\tPosition\tComment\n",
                      [&](int k) { return fmt::format("{:.6f}\t{:.6f}\t{:.6f}\n", seconds(k), volts(k), place(k)); }),
                 "V", "mm"});
  all.push_back({"Tektronix",
                 "tds.csv",
                 rows("",
                      [&](int k) {
                        const std::vector<std::string> head{
                            "Record Length,2.000000e+02", "Sample Interval,1.000000e-03", "Trigger Point,1.000000e+02",
                            "Source,CH1", "Vertical Units,V"};
                        const auto i = static_cast<std::size_t>(k);
                        return fmt::format("{},{:.12f},{:.5f},{:.5f},\n", i < head.size() ? head[i] : ",", seconds(k),
                                           volts(k), 0.1 * place(k));
                      }),
                 "",
                 "",
                 0.1,
                 {.time = "3", .input = "4", .output = "5"},
                 "--time 3 --input 4 --output 5"});
  // MDO3000 and MSO 4 to 6: a block of facts, the units and labels of the channels among them.
  const std::string block =
      "Model,MDO3024\nFirmware Version,1.30\n\nWaveform Type,ANALOG,\nPoint Format,Y,\nHorizontal Units,s,\n"
      "Horizontal Scale,0.02,\nHorizontal Delay,0,\nSample Interval,0.001,\nRecord Length,200,\n"
      "Gating,0.0% to 100.0%,\nProbe Attenuation,1,1\nVertical Units,V,{1}\nVertical Offset,0,0\nVertical Scale,2,1\n"
      "Vertical Position,-1.98,0\n,,\n,,\n,,\nLabel,{0}\nTIME,CH1,CH2\n";
  const auto scope_row = [&](int k) {
    return fmt::format("{:.7e},{:.5f},{:.5f}\n", -0.1 + seconds(k), volts(k), 0.1 * place(k));
  };
  all.push_back({"TektronixLabels", "mdo.csv", rows(fmt::format(fmt::runtime(block), "Valve,Rod", "mm"), scope_row),
                 "V", "mm", 0.1});
  all.push_back({"TektronixVolts",
                 "mso.csv",
                 rows(fmt::format(fmt::runtime(block), ",", "V"), scope_row),
                 "V",
                 "V",
                 0.1,
                 {.input = "2", .output = "3"},
                 "--input 2 --output 3"});
  std::string commented;
  for (const char c : fmt::format(fmt::runtime(block), "Valve,Rod", "mm")) {
    if (commented.empty() || commented.back() == '\n') commented += '#';
    commented += c;
  }
  all.push_back({"TektronixComments", "mdo.csv", rows(commented, scope_row), "V", "mm", 0.1});
  all.push_back(
      {"TektronixBlocks", "blocks.csv",
       rows("Model,MDO3024,,\nWaveform Type,ANALOG,,Waveform Type,ANALOG\nHorizontal Units,s,,Horizontal Units,s\n"
            "Sample Interval,0.001,,Sample Interval,0.001\nVertical Units,V,,Vertical Units,mm\n,,,,\n"
            "Label,,,Label,Rod\nTIME,CH1,,TIME,CH2\n",
            [&](int k) { return fmt::format("{0:.6e},{1:.5f},,{0:.6e},{2:.5f}\n", seconds(k), volts(k), place(k)); }),
       "V", "mm"});
  // TDS and TBS: facts stand beside the rows; a file for each channel, here beside each other.
  all.push_back({"TektronixBeside", "both.csv",
                 rows("",
                      [&](int k) {
                        const std::vector<std::string> head{"Record Length,2.000000e+02",
                                                            "Sample Interval,1.000000e-03",
                                                            "Trigger Point,1.000000e+02",
                                                            "",
                                                            "Source,CH{}",
                                                            "Vertical Units,{}",
                                                            "Horizontal Units,s"};
                        const auto i = static_cast<std::size_t>(k);
                        const auto fact = [&](const char* source, const char* unit) {
                          if (i >= head.size() || head[i].empty()) return std::string(",");
                          return fmt::format(fmt::runtime(head[i]), k == 4 ? source : unit);
                        };
                        return fmt::format("{},,{:.11f},{:.5f},,{},,{:.11f},{:.5f},\n", fact("1", "V"), seconds(k),
                                           volts(k), fact("2", "mm"), seconds(k), place(k));
                      }),
                 "V", "mm"});
  all.push_back({"LeCroy", "wave.csv",
                 rows("LECROYHDO4104,30152,Waveform\nSegments,1,SegmentSize,200\nSegment,TrigTime,TimeSinceSegment1\n"
                      "#1,28-Dec-2020 13:34:10,0\nTime,Ampl1,Ampl2\n",
                      scope_row),
                 "", "", 0.1});
  all.push_back({"Canape", "canape.csv",
                 rows("timestamps,Valve,Rod\nsec,V,mm\n,,\n",
                      [&](int k) { return fmt::format("{:.6f},{:.6f},{:.6f}\n", seconds(k), volts(k), place(k)); }),
                 "V", "mm"});
  // InfiniiVision, "CSV": two rows of header, the channels by their numbers.
  all.push_back({"Keysight",
                 "scope_1.csv",
                 rows("x-axis,1,2\nsecond,Volt,Volt\n",
                      [&](int k) {
                        return fmt::format("{:+.9E},{:+.6E},{:+.6E}\n", -0.1 + seconds(k), volts(k), 0.1 * place(k));
                      }),
                 "V",
                 "V",
                 0.1,
                 {.input = "2", .output = "3"},
                 "--input 2 --output 3"});
  // BenchVue and BenchLink: scans are numbered, milliseconds stand behind a colon.
  all.push_back({"BenchVue", "data_logger.csv",
                 rows("Name:,bench\nOwner:,lab\nInstrument:,34972A\n\nTotal Channels:,2\n\n"
                      "Scan,Time,101 <Valve> (VDC),102 <Rod> (MM)\n",
                      [&](int k) {
                        return fmt::format("{},11/23/2026 10:00:00:{:03},{:+.8E},{:+.8E}\n", k + 1, k, volts(k),
                                           place(k));
                      }),
                 "V", "mm"});
  // LabVIEW without a column of times: Delta_X stands in the second header.
  all.push_back({"LabviewWithoutTimes",
                 "fast.lvm",
                 rows("LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tNo\n"
                      "***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t200\t200\t\n"
                      "Y_Unit_Label\tVolts\tMillimeters\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\n"
                      "Delta_X\t0.001\t0.001\t\n***End_of_Header***\t\t\t\nX_Value\tValve\tPosition\tComment\n",
                      [&](int k) { return fmt::format("\t{:.6f}\t{:.6f}\t\n", volts(k), place(k)); }),
                 "V",
                 "mm",
                 1.0,
                 {},
                 {}});
  // Two times, one for each channel.
  all.push_back({"LabviewTwoTimes",
                 "multi.lvm",
                 rows("LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tMulti\n"
                      "***End_of_Header***\t\n\t\nChannels\t2\t\t\t\nSamples\t200\t\t200\t\n"
                      "Y_Unit_Label\tVolts\t\tMillimeters\t\nX_Dimension\tTime\t\tTime\t\n"
                      "Delta_X\t0.001\t\t0.001\t\n***End_of_Header***\t\t\t\t\n"
                      "X_Value\tValve\tX_Value\tPosition\tComment\n",
                      [&](int k) {
                        return fmt::format("{:.6f}\t{:.6f}\t{:.6f}\t{:.6f}\n", seconds(k), volts(k), seconds(k),
                                           place(k));
                      }),
                 "",
                 "",
                 1.0,
                 {},
                 {}});
  // DAQExpress and MTS TestSuite: units in a row of their own, and the command is the loop's set point.
  all.push_back(
      {"MtsTestSuite",
       "daqTaskActivity1.txt",
       rows("Test Name:\tbench\nDate:\t11/23/2026\n\nTime\tAxial Displacement\tAxial Displacement Command\n"
            "sec\tmm\tmm\n",
            [&](int k) { return fmt::format("{:.7e}\t{:.7e}\t{:.7e}\n", seconds(k), place(k), 20.0 * volts(k)); }),
       "mm",
       "mm",
       1.0,
       {.input = "3", .output = "2"},
       "which columns are input and output?",
       20.0});
  // DS1000Z: rows are numbered, the period stands in the header.
  all.push_back({"Rigol",
                 "rigol.csv",
                 rows("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.000000e-01,1.000000e-03,\n",
                      [&](int k) { return fmt::format("{},{:.4e},{:.4e},,\n", k, volts(k), 0.1 * place(k)); }),
                 "",
                 "",
                 0.1,
                 {.input = "2", .output = "3", .period_s = 1e-3},
                 "--period 0.001"});
  // DLM3000 and DL850, ASCII: no time at all, but HResolution.
  all.push_back({"Yokogawa",
                 "wave.csv",
                 rows("\"Header Size\",16\n\"Model "
                      "Name\",\"DLM3054\"\n\"Comment\",\"\"\n\"BlockNumber\",1,1\n\"TraceName\",\"CH1\","
                      "\"CH2\"\n\"BlockSize\",200,200\n\"VUnit\",\"V\",\"V\"\n\"SampleRate\",1.0E+03,1.0E+"
                      "03\n\"HResolution\",1.0E-03,"
                      "1.0E-03\n\"HOffset\",-1.0E-01,-1.0E-01\n\"HUnit\",\"s\",\"s\"\n\"DisplayBlockSize\",200,200\n"
                      "\"DisplayPointNo.\",1,1\n\"Date\",\"2026/11/23\",\"2026/11/"
                      "23\"\n\"Time\",\"10:00:00.10\",\"10:00:00.10\"\n\n",
                      [&](int k) { return fmt::format(",{:.6E},{:.6E}\n", volts(k), 0.1 * place(k)); }),
                 "V",
                 "V",
                 0.1,
                 {.input = "2", .output = "3", .period_s = 1e-3},
                 "--period 0.001"});
  return all;
}

class OtherProgram : public testing::TestWithParam<Program> {
 protected:
  void expect_record(const Imported& imported) const {
    const Program& program = GetParam();
    const ident::Record& record = imported.record;
    ASSERT_EQ(record.input.size(), kRows) << imported.guess;
    EXPECT_NEAR(record.step_s, kStep_s, 1e-9) << imported.guess;
    for (int k = 0; k < kRows; ++k) {
      ASSERT_NEAR(record.input[k], program.input_factor * volts(k), 1e-4 * program.input_factor)
          << k << " " << imported.guess;
      ASSERT_NEAR(record.output[k], program.output_factor * place(k), 1e-3 * program.output_factor) << k;
    }
    if (!program.input_unit.empty()) {
      EXPECT_EQ(record.input_channel.unit, program.input_unit) << imported.guess;
    }
    if (!program.output_unit.empty()) {
      EXPECT_EQ(record.output_channel.unit, program.output_unit) << imported.guess;
    }
  }

  test::TemporaryFolder folder_;
};

TEST_P(OtherProgram, IsReadAsItsRecordOrAskedAbout) {
  const Program& program = GetParam();
  const auto path = folder_.write(program.file, program.text);
  if (program.asked.empty()) {
    expect_record(import_record(path, {}));
    return;
  }
  try {
    const Imported imported = import_record(path, {});
    ADD_FAILURE() << "taken without a question: " << imported.guess;
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find(program.asked), std::string::npos) << error.what();
  }
  expect_record(import_record(path, program.answer));
}

TEST(Scope, WithAFileForEachChannelHasACommandThatPutsThemBesideEachOther) {
  test::TemporaryFolder folder;
  const auto one = [&](const std::string& name, double (*value)(int)) {
    return folder.write(name, rows("LECROYHDO4104,30152,Waveform\r\nSegments,1,SegmentSize,200\r\n"
                                   "Segment,TrigTime,TimeSinceSegment1\r\n#1,28-Dec-2020 13:34:10,0\r\nTime,Ampl\r\n",
                                   [&](int k) { return fmt::format("{:.4f},{:.4f}\r\n", kStep_s * k, value(k)); }));
  };
  const auto first = one("C1.csv", volts);
  const auto second = one("C2.csv", place);
  std::string refusal;
  try {
    static_cast<void>(import_record(first, {}));
  } catch (const DataError& error) {
    refusal = error.what();
  }
  const std::size_t begin = refusal.find("`paste");
  ASSERT_NE(begin, std::string::npos) << refusal;
  std::string command = refusal.substr(begin + 1, refusal.find('`', begin + 1) - begin - 1);
  command.replace(command.find("OTHER"), 5, second.string());
  ASSERT_EQ(std::system(fmt::format("cd '{}' && {}", folder.path().string(), command).c_str()), 0) << command;
  const Imported imported = import_record(folder.path() / "C1-both.csv", {});
  EXPECT_NEAR(imported.record.output[7], place(7), 1e-3);
  EXPECT_NEAR(imported.record.input[7], volts(7), 1e-3);
}

TEST(WinCC, IsRefusedWithACommandThatMakesColumnsOfItsRows) {
  // TIA Portal's data log: a row for each variable and time, Time_ms a million times a spreadsheet's days.
  std::string log = "\"VarName\";\"TimeString\";\"VarValue\";\"Validity\";\"Time_ms\"\n";
  for (int k = 0; k < kRows; ++k) {
    const std::string time = fmt::format("{:.9f}", 46349.416666667 * 1e6 + kStep_s * k / 0.0864);
    log += fmt::format("\"Ventil_V\";\"23.11.2026 10:00:00\";{};1;{}\n", german(fmt::format("{:.6f}", volts(k))),
                       german(time));
    log += fmt::format("\"Weg_mm\";\"23.11.2026 10:00:00\";{};1;{}\n", german(fmt::format("{:.6f}", place(k))),
                       german(time));
  }
  log += "\"$RT_OFF$\";\"23.11.2026 10:00:01\";0;2;46349416678,2407\n";
  const test::TemporaryFolder folder;
  const auto path = folder.write("log0.csv", log);
  std::string message;
  try {
    static_cast<void>(import_record(path, {}));
    FAIL() << "taken";
  } catch (const DataError& error) {
    message = error.what();
  }
  const std::size_t begin = message.find('`');
  ASSERT_NE(begin, std::string::npos) << message;
  const std::string command = message.substr(begin + 1, message.find('`', begin + 1) - begin - 1);
  ASSERT_EQ(std::system(fmt::format("cd '{}' && {}", folder.path().string(), command).c_str()), 0) << command;
  const ident::Record record = import_record(folder.path() / "log0-columns.csv", {.resample = true}).record;
  ASSERT_EQ(record.input.size(), kRows);
  EXPECT_NEAR(record.step_s, kStep_s, 1e-6);
  for (int k = 0; k < kRows; ++k) {
    ASSERT_NEAR(record.input[k], volts(k), 1e-3) << k;
    ASSERT_NEAR(record.output[k], place(k), 1e-2) << k;
  }
  EXPECT_EQ(record.output_channel.unit, "mm");
}

INSTANTIATE_TEST_SUITE_P(Of, OtherProgram, testing::ValuesIn(programs()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace eha::importer
