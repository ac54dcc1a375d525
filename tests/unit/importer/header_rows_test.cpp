// SPDX-License-Identifier: GPL-3.0-or-later
// What stands above, between, beside and behind the rows.
#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

std::string tabs(int k) { return fmt::format("{:.5f}\t{:.5f}\t{:.5f}", 0.01 * k, Rig::volts(k), Rig::place(k)); }

void expect_rig(const Imported& imported, const std::string& input = "V", const std::string& output = "mm") {
  const ident::Record& record = imported.record;
  ASSERT_EQ(record.input.size(), Rig::kRows) << imported.guess;
  EXPECT_NEAR(record.step_s, 0.01, 1e-9) << imported.guess;
  EXPECT_NEAR(record.input[20], Rig::volts(20), 1e-3) << imported.guess;
  EXPECT_NEAR(record.output[20], Rig::place(20), 1e-3) << imported.guess;
  EXPECT_EQ(record.input_channel.unit, input) << imported.guess;
  EXPECT_EQ(record.output_channel.unit, output) << imported.guess;
}

TEST_F(ImportedFile, HasTabsWhereTheyNameItsColumns) {
  // As many words between blanks as there are columns.
  expect_rig(import_record(write("a.txt", Rig::rows("Post time: 0\nTime [s]\tVentil [V]\tWeg [mm]\n", tabs)), {}));
  expect_rig(import_record(
      write("b.asc", Rig::rows("Anzahl:\t3\nZeit 1 - schnell [s]\tCH_2 Ventil [V]\tCH_1 Weg [mm]\n\n\n", tabs)), {}));
}

TEST_F(ImportedFile, HasNamesAndUnitsAboveRowsOfHardwareAndDates) {
  const std::string below = "schnell\tCH_2\tCH_1\n25.11.2026 14:03:07\t25.11.2026 14:03:07\t25.11.2026 14:03:07\n";
  expect_rig(import_record(write("a.asc", Rig::rows("Zeit\tVentil\tWeg\ns\tV\tmm\n" + below, tabs)), {}));
  expect_rig(import_record(
      write("b.asc",
            Rig::rows("Kanal:\tZeit\tVentil\tWeg\nEinheit:\ts\tV\tmm\nRate:\t1 Hz\t1 Hz\t1 Hz\nSensor:\t\tU10\tW9\n",
                      [](int k) { return "\t" + tabs(k); })),
      {}));
}

TEST_F(ImportedFile, HasALineOfOneWordBetweenItsHeaderAndItsRows) {
  const auto rows = [](int k) { return fmt::format("{:.4f},{:.5f},{:.5f}", 0.01 * k, Rig::volts(k), Rig::place(k)); };
  expect_rig(import_record(
      write("dspace.csv", Rig::rows("Origin,ControlDesk\nExperiment,sine\npath,Root/t,Root/u_valve,Root/x_rod\n"
                                    "Time,u_valve,x_rod\ns,V,mm\ntrace_values\n",
                                    rows)),
      {}));
  expect_rig(import_record(
      write("labels.csv", Rig::rows("Origin,ControlDesk\npath,Root/t,Root/u_valve,Root/x_rod\nunit,s,V,mm\n"
                                    "trace_values\n",
                                    rows)),
      {}));
}

TEST_F(ImportedFile, HasItsChannelsNamesInThePreambleAndAboveTheRows) {
  const auto rows = [](int k) { return fmt::format("{:.4f},{:.5f},{:.5f}", 0.01 * k, Rig::volts(k), Rig::place(k)); };
  const auto path = write("scope.csv", Rig::rows("Sample Interval,1.0E-02,s\nSource,CH1,CH2\nVertical Units,V,mm\n"
                                                 "Vertical Scale,1.0,0.5\nVertical Offset,0.0,0.1\nTime,CH1,CH2\n",
                                                 rows));
  Options options;
  options.input = "CH1";
  options.output = "CH2";
  const Imported imported = import_record(path, options);
  expect_rig(imported);
  EXPECT_NE(imported.guess.find("Time"), std::string::npos) << imported.guess;
}

TEST_F(ImportedFile, HasASetPointBesideSoThatItsLoopWasClosed) {
  const auto rows = [](int k) {
    return fmt::format("{:.4f};{:.5f};{:.5f};{:.5f}", 0.01 * k, Rig::volts(k), Rig::place(k), Rig::place(k) + 0.3);
  };
  const auto path = write("loop.csv", Rig::rows("Zeit [s];Ventil [V];Weg Ist [mm];Weg Soll [mm]\n", rows));
  Options options;
  options.input = "2";
  options.output = "3";
  const Imported imported = import_record(path, options);
  const auto is_of_loop = [](const std::string& remark) { return remark.find("closed loop") != std::string::npos; };
  EXPECT_TRUE(std::any_of(imported.remarks.begin(), imported.remarks.end(), is_of_loop))
      << fmt::format("{}", fmt::join(imported.remarks, "\n"));
}

TEST_F(ImportedFile, HasASetPointInVoltsBesideSoThatItsLoopWasClosed) {
  const auto rows = [](int k) {
    return fmt::format("{:.4f},{:.5f},{:.5f},{:.5f}", 0.01 * k, 5.0 + std::sin(0.1 * k), Rig::volts(k), Rig::place(k));
  };
  const auto is_of_loop = [](const std::string& header, const auto& row) {
    test::TemporaryFolder folder;
    return import_record(folder.write("loop.csv", Rig::rows(header, row)), {}).is_closed_loop;
  };
  for (const char* set_point :
       {"Setpoint [V]", "Sollwert [V]", "Set point (V)", "Reference [V]", "Position command [V]"}) {
    for (const char* input : {"Valve [V]", "Control [V]", "u [V]"}) {
      const auto path = write("loop.csv", Rig::rows(fmt::format("t [s],{},{},Rod [mm]\n", set_point, input), rows));
      const Imported imported = import_record(path, {});
      EXPECT_TRUE(imported.is_closed_loop) << imported.guess;
      EXPECT_NE(imported.guess.find(fmt::format("input 3 \"{}\"", input)), std::string::npos) << imported.guess;
      ASSERT_FALSE(imported.remarks.empty());
      EXPECT_NE(imported.remarks[0].find(set_point), std::string::npos) << imported.remarks[0];
    }
  }
  EXPECT_FALSE(is_of_loop("t [s],Command [V],Spool current [mA],Rod [mm]\n", rows)) << "the valve's command";
  EXPECT_FALSE(is_of_loop("t [s],Ref [V],Valve [V],Rod [mm]\n", [](int k) {
    return fmt::format("{:.4f},5.0,{:.5f},{:.5f}", 0.01 * k, Rig::volts(k), Rig::place(k));
  })) << "a sensor's supply";
}

TEST_F(ImportedFile, HasUnitsInARowOfOtherWords) {
  const std::string head =
      "Vendor,X\nSampling interval,100ms\nNumber,Date&Time,ms,CH1,CH2,Alarm\nNO.,Time,ms,V,mm,A1\n";
  const auto path = write("logger.csv", Rig::rows(head, [](int k) {
                            return fmt::format("{},2026/11/25 14:03:{:02},{},{:+.4f},{:+.4f},LL", k + 1, k / 100,
                                               10 * (k % 100), Rig::volts(k), Rig::place(k));
                          }));
  const std::string refusal = refusal_of(path);
  expect_rig(answered(path, refusal));
}

TEST_F(ImportedFile, HasATimeBesideEachChannelAndItsPeriodAboveTheRows) {
  const auto path =
      write("scope.csv",
            Rig::rows("Name\tScope\n\nName\tMAIN.fValve\tName\tMAIN.fPos\n"
                      "SampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tV\tUnit\tmm\n\n",
                      [](int k) { return fmt::format("{}\t{:.5f}\t{}\t{:.5f}", k, Rig::volts(k), k, Rig::place(k)); }));
  expect_rig(answered(path, refusal_of(path)));
}

TEST_F(ImportedFile, HasUnitsBehindABlankWhereAllColumnsHave) {
  const auto rows = [](int k) { return fmt::format("{};{:.4f};{:.4f}", 10 * k, Rig::volts(k), Rig::place(k)); };
  expect_rig(import_record(write("a.csv", Rig::rows("Zeit ms;Ventil V;Weg mm\n", rows)), {}));
  const std::string refusal = refusal_of(write("b.csv", Rig::rows("Time [ms];Channel A;Channel V\n", rows)));
  EXPECT_EQ(refusal.find("[A]"), std::string::npos) << refusal;
}

TEST_F(ImportedFile, EndsItsRowsWithADelimiterThatTheHeaderLacks) {
  for (const char delimiter : {';', ','}) {
    std::string text = Rig::rows("Zeit [s];Ventil [V];Weg [mm]\n", [](int k) { return tabs(k) + "\t"; });
    std::replace(text.begin(), text.end(), '\t', delimiter);
    std::replace(text.begin(), text.end(), ';', delimiter);
    expect_rig(import_record(write("ends.csv", text), {}));
  }
}

TEST_F(ImportedFile, EndsBeforeRowsOfStatistics) {
  const auto path =
      write("footer.csv", Rig::rows("Time [s]\tValve [V]\tRod [mm]\n", tabs) + "\nMinimum\t-4\t40\nMean\t0\t50\n");
  const std::string refusal = refusal_of(path);
  ASSERT_EQ(commands_of(refusal).size(), 1U) << refusal;
  expect_rig(answered(path, refusal));
  // Without the column of times rows are counted, and the same lines are none.
  const std::string counted = refusal_of(path, {.period_s = 0.01});
  Options options = options_of(commands_of(counted).at(0));
  options.period_s = 0.01;
  expect_rig(import_record(path, options));
}

TEST_F(ImportedFile, HasACommandForTheRowsBeforeAndBehindASecondHeader) {
  for (const char* between : {"", "\n\nTest 2\n"}) {
    const std::string part = Rig::rows("Time [s]\tValve [V]\tRod [mm]\n", tabs);
    const auto path = write("two.txt", part + between + part);
    const std::string refusal = refusal_of(path);
    ASSERT_EQ(commands_of(refusal).size(), 3U) << refusal;
    expect_rig(answered(path, refusal));
    ASSERT_TRUE(shell(commands_of(refusal)[1])) << refusal;
    expect_rig(import_record(folder_.path() / "two-rest.txt", {}));
  }
}

TEST_F(ImportedFile, IsNoRecordWhereMostLinesAreWords) {
  std::string text;
  for (int k = 0; k < 5; ++k)
    text += "Liste\n2 Dichtungen 35x45\n1 Fass HLP46\n3, 4, 5 Schrauben M8\nTel. 0711 / 123\n\n";
  const std::string refusal = refusal_of(write("list.txt", text));
  EXPECT_NE(refusal.find("no rows of numbers"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find("--period"), std::string::npos) << refusal;
}

TEST_F(ImportedFile, IsNoRecordWhereAPageOfTheWebWasFetched) {
  const std::string refusal = refusal_of(write("rod.csv", "<!DOCTYPE html>\n<html><body>Log in</body></html>\n"));
  EXPECT_NE(refusal.find("rod.csv: is a web page"), std::string::npos) << refusal;
}

TEST_F(ImportedFile, HasCommasBetweenColumnsAndInNumbers) {
  const std::string refusal = refusal_of(
      write("both.csv", Rig::rows("Zeit (s),Ventil (V),Weg (mm)\n", [](int k) {
              return with_commas(fmt::format("{:.2f},{:.4f},{:.3f}", 0.01 * k, Rig::volts(k), Rig::place(k)));
            })));
  EXPECT_NE(refusal.find("3 names above rows of 6 fields"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find("--period"), std::string::npos) << refusal;
}

TEST_F(ImportedFile, HasYokogawasRowsWhereverTheTracesAreNamed) {
  const std::string head =
      "\"Header "
      "Size\",\"8\",\"\"\n\"BlockNumber\",\"1\",\"\"\n\"TraceName\",\"CH1\",\"CH2\"\n\"BlockSize\",\"300\",\"300\"\n"
      "\"VUnit\",\"V\",\"mm\"\n\"HResolution\",\"1.0E-02\",\"1.0E-02\"\n\"HUnit\",\"s\",\"s\"\n"
      "\"Time\",\"14:03:07.1\",\"14:03:07.1\"\n\n";
  const auto path = write(
      "wave.csv", Rig::rows(head, [](int k) { return fmt::format(",{:.5E},{:.5E}", Rig::volts(k), Rig::place(k)); }));
  expect_rig(answered(path, refusal_of(path)));
  // Rows that end with a comma.
  const std::string shorter =
      "\"Model\",\"DL850E\"\n\"BlockNumber\",1\n\"TraceName\",\"CH1\",\"CH2\"\n\"VUnit\",\"V\",\"mm\"\n"
      "\"HResolution\",1.0E-02,1.0E-02\n\"HUnit\",\"s\",\"s\"\n\"Time\",\"14:03:07.1\"\n\n";
  const auto ended =
      write("ended.csv",
            Rig::rows(shorter, [](int k) { return fmt::format(",{:.5E},{:.5E},", Rig::volts(k), Rig::place(k)); }));
  const std::string refusal = refusal_of(ended);
  EXPECT_NE(refusal.find("one every 0.01 s"), std::string::npos) << refusal;
  expect_rig(answered(ended, refusal));
}

TEST_F(ImportedFile, HasSecondsThatAScopeWritesAsS) {
  const auto path = write(
      "tek.csv",
      Rig::rows("Model,MSO44\nHorizontal Units,S,,\nSample Interval,0.01,,\n"
                "Vertical Units,V,mm\nLabel,Valve,Rod\nTIME,CH1,CH2\n",
                [](int k) { return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, Rig::volts(k), Rig::place(k)); }));
  expect_rig(import_record(path, {}));
}

/// Rows as LabVIEW writes them in blocks of `length`, each with a header.
std::string labview_blocks(int length, const std::function<double(int)>& time_s) {
  std::string text =
      "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tYes\n"
      "X_Columns\tOne\n***End_of_Header***\t\n\t\n";
  for (int k = 0; k < Rig::kRows; ++k) {
    if (k % length == 0) {
      text += fmt::format(
          "{}Channels\t2\t\t\nSamples\t100\t100\t\nY_Unit_Label\tV\tmm\t\nX0\t{}\t{}\t\n"
          "***End_of_Header***\t\t\t\nX_Value\tValve\tPosition\tComment\n",
          k > 0 ? "\n" : "", time_s(k), time_s(k));
    }
    text += fmt::format("{:.2f}\t{:.4f}\t{:.4f}\n", time_s(k), Rig::volts(k), Rig::place(k));
  }
  return text;
}

TEST_F(ImportedFile, ReadsLabviewsBlocksAsOneRecordAndDropsNone) {
  const Imported whole = import_record(write("blocks.lvm", labview_blocks(100, [](int k) { return 0.01 * k; })), {});
  expect_rig(whole);
  EXPECT_NE(whole.guess.find("blocks with a header each, read as one"), std::string::npos) << whole.guess;
  // A block each with a clock from 0: a command for each.
  const auto path = write("again.lvm", labview_blocks(100, [](int k) { return 0.01 * (k % 100); }));
  const std::string refusal = refusal_of(path);
  ASSERT_EQ(commands_of(refusal).size(), 3U) << refusal;
  EXPECT_NEAR(answered(path, refusal, 0).record.input[3], Rig::volts(3), 1e-4);
  EXPECT_NEAR(answered(path, refusal, 1).record.input[3], Rig::volts(103), 1e-4);
}

TEST_F(ImportedFile, SaysWhichOfTwoUnitsOfAColumnItTakes) {
  const auto file = [&](const std::string& name, const std::string& names) {
    std::string text =
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n"
        "***End_of_Header***\t\n\t\nChannels\t2\t\t\nY_Unit_Label\tV\tmm\t\n"
        "***End_of_Header***\t\t\t\n" +
        names + "\tComment\n";
    for (int k = 0; k < Rig::kRows; ++k) {
      text += fmt::format("{:.2f}\t{:.4f}\t{:.4f}\n", 0.01 * k, Rig::volts(k), Rig::place(k));
    }
    return import_record(write(name, text), {});
  };
  const Imported two = file("two.lvm", "X_Value\tValve (V)\tRod (in)");
  EXPECT_EQ(two.record.output_channel.unit, "in");
  ASSERT_EQ(two.remarks.size(), 1U);
  EXPECT_NE(two.remarks[0].find("column 3 \"Rod (in)\" has two units, in in its name and mm below it: in is "
                                "taken; if mm is right, its values are wrong by the factor 25.4"),
            std::string::npos)
      << two.remarks[0];
  // The same unit twice is one.
  for (const char* names :
       {"X_Value\tValve (V)\tRod (mm)", "X_Value\tValve V\tRod mm", "X_Value\tValve [V] (V)\tRod [mm] (mm)"}) {
    const Imported same = file("same.lvm", names);
    EXPECT_TRUE(same.remarks.empty()) << names;
    EXPECT_EQ(same.record.input_channel.name, "Valve") << names;
    EXPECT_EQ(same.record.output_channel.name, "Rod") << names;
    EXPECT_EQ(same.record.output_channel.unit, "mm") << names;
  }
  const Imported place = file("place.lvm", "X_Value\tValve (left)\tRod (top)");
  EXPECT_EQ(place.record.input_channel.unit, "V") << "no unit is left, a place is";
  EXPECT_EQ(place.record.output_channel.unit, "mm");
  EXPECT_TRUE(place.remarks.empty());
}

TEST_F(ImportedFile, HasACommandForTheRowsOfASlowerOutput) {
  const auto path = write("mixed.csv", Rig::rows("t [s];u [V];y [mm]\n", [](int k) {
                            return fmt::format("{:.2f};{:.4f};{}", 0.01 * k, Rig::volts(k),
                                               k % 5 == 0 ? fmt::format("{:.4f}", Rig::place(k)) : "");
                          }));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("in every 5th row only"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--resample`"), std::string::npos) << refusal;
  Options options;
  options.resample = true;
  const Imported imported = import_record(path, options);
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  EXPECT_NEAR(imported.record.output[15], Rig::place(15), 1e-4);
  EXPECT_TRUE(imported.held.empty()) << "the input of each row is known";
  EXPECT_EQ(imported.gaps, "");
  EXPECT_TRUE(imported.without_gaps.keeps_all());
  EXPECT_EQ(imported.slow_rows, "");
}

TEST_F(ImportedFile, HasTheSignOfInfinityForAnOverload) {
  const auto path = write("pico.csv", Rig::rows("Time [s],A [V],B [mm]\n", [](int k) {
                            return fmt::format("{:.2f},{:.4f},{}", 0.01 * k, Rig::volts(k),
                                               k == 100 ? "\xE2\x88\x9E" : fmt::format("{:.4f}", Rig::place(k)));
                          }));
  const std::string refusal = refusal_of(path);
  const Imported imported = answered(path, refusal);
  expect_rig(imported);
  EXPECT_EQ(imported.record.unmeasured, std::vector<std::size_t>{100});
}

TEST_F(ImportedFile, IsRefusedOnceWithAllThatItNeeds) {
  const auto path = write("over.csv", Rig::rows("Time,Channel A,Channel B\n(ms),(V),(mV)\n\n", [](int k) {
                            return fmt::format("{},{:.4f},{}", 10 * k, Rig::volts(k),
                                               k == 100 ? "\xE2\x88\x9E" : fmt::format("{:.4f}", Rig::place(k)));
                          }));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("which columns are input and output?"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find(" Its rows need --resample: "), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--input 2 --output 3 --resample`"), std::string::npos) << refusal;
  EXPECT_EQ(answered(path, refusal).record.unmeasured, std::vector<std::size_t>{100});
}

TEST_F(ImportedFile, IsSaidToBeExchangedAfterAnAnswerToo) {
  double place = 0.0;
  const auto path = write("ai.csv", Rig::rows("Time (s),AI0 (V),AI1 (V)\n", [&](int k) {
                            const double volts = 4.0 * std::sin(0.9 * k) + 3.0 * std::sin(0.23 * k);
                            place += 0.05 * (volts - place);
                            return fmt::format("{:.2f},{:.4f},{:.4f}", 0.01 * k, place, volts);
                          }));
  const std::string refusal = refusal_of(path);
  const Imported imported = answered(path, refusal);
  const std::string remarks = fmt::format("{}", fmt::join(imported.remarks, "\n"));
  EXPECT_NE(remarks.find("may be exchanged"), std::string::npos) << refusal << remarks;
}

}  // namespace
}  // namespace eha::importer
