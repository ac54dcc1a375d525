// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/roles.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/importer/imported_table.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

using Pair = std::pair<std::string, std::string>;

TEST(NameAndUnit, AreToldApartInTheWaysOfHeaders) {
  EXPECT_EQ(name_and_unit("Spannung [V]"), Pair("Spannung", "V"));
  EXPECT_EQ(name_and_unit("Weg (mm)"), Pair("Weg", "mm"));
  EXPECT_EQ(name_and_unit("t / s"), Pair("t", "s"));
  EXPECT_EQ(name_and_unit("Zeit in ms"), Pair("Zeit", "ms"));
  EXPECT_EQ(name_and_unit("voltage_V"), Pair("voltage", "V"));
  EXPECT_EQ(name_and_unit("Time [sec]"), Pair("Time", "s"));
  EXPECT_EQ(name_and_unit("Flow [gpm]"), Pair("Flow", "gpm"));
  for (const char* label : {"ms", "msec", "msecs", "millis", "Millisekunden", "Time ms", "Zeit ms"}) {
    EXPECT_EQ(name_and_unit(label).second, "ms") << label;
  }
  for (const char* label : {"us", "usec", "micros", "Microseconds"}) EXPECT_EQ(name_and_unit(label).second, "us");
  for (const char* label : {"min", "minutes", "Time min"}) EXPECT_EQ(name_and_unit(label).second, "min");
  // No unit that is known, or none of a time: part of the name.
  for (const char* label : {"s", "h", "Channel s", "Force min"}) EXPECT_EQ(name_and_unit(label), Pair(label, ""));
  for (const char* label : {"Flow l/min", "Flow_l/min", "Flow, l/min", "Flow in l/min", "Flow (l/min)"}) {
    EXPECT_EQ(name_and_unit(label), Pair("Flow", "l/min")) << "a rate is no time: " << label;
  }
  EXPECT_EQ(name_and_unit("Speed 1/min"), Pair("Speed", "1/min"));
  EXPECT_EQ(name_and_unit("Flow m3/h"), Pair("Flow", "m3/h"));
  EXPECT_EQ(name_and_unit("Run Time/s"), Pair("Run Time", "s"));
  EXPECT_EQ(name_and_unit("valve_command"), Pair("valve_command", ""));
  EXPECT_EQ(name_and_unit("channel_1"), Pair("channel_1", ""));
  EXPECT_EQ(name_and_unit(""), Pair("", ""));
}

TEST(Hints, KnowNamesInThreeLanguagesAndUnits) {
  EXPECT_EQ(hints_of("Ventilspannung", "V").input, 3);
  EXPECT_EQ(hints_of("Kolbenweg", "mm").output, 3);
  EXPECT_EQ(hints_of("D\xC3\xA9placement", "").output, 2);
  EXPECT_EQ(hints_of("Temps", "s").time, 3);
  EXPECT_EQ(hints_of("rec.u", "").input, 2);
  EXPECT_EQ(hints_of("Pressure A", "bar").output, 0);
  EXPECT_EQ(hints_of("Unnamed: 0", "").index, 2);
}

TEST(ClockText, GivesDifferencesOfDatesAndTimesOfDay) {
  for (const auto& [early, late] :
       {std::pair("2024-03-01 10:00:00.25", "2024-03-01 10:00:01.75"),
        std::pair("2024-03-01T10:00:00.25Z", "2024-03-01T10:00:01.75Z"),
        std::pair("01.03.2024 10:00:00,25", "01.03.2024 10:00:01,75"), std::pair("10:00:00.25", "10:00:01.75")}) {
    ASSERT_TRUE(clock_seconds(early) && clock_seconds(late)) << early;
    EXPECT_NEAR(*clock_seconds(late) - *clock_seconds(early), 1.5, 1e-6) << early;
  }
  for (const char* text : {"", "12.5", "Monday", "10:00", "2024-03-01"}) EXPECT_FALSE(clock_seconds(text)) << text;
}

TEST(Readable, KeepsLettersAndDropsControlCharacters) {
  EXPECT_EQ(readable("L\xC3\xA4nge", 40), "L\xC3\xA4nge");
  EXPECT_EQ(readable("a\x1b[31m", 40), "a?[31m");
  EXPECT_EQ(readable("a\xC2\x9B"
                     "b",
                     40),
            "a?b");
  // Not within a character.
  EXPECT_EQ(readable("a\xC3\xA4\xC3\xA4", 4), "a\xC3\xA4...");
}

/// Time, input and output of a text as "time/input/output", or the end of the refusal.
std::string columns_of(const std::string& text, const Options& options = {}) {
  const test::TemporaryFolder folder;
  try {
    const Imported imported = import_record(folder.write("r.csv", text), options);
    return imported.record.input_channel.name + "/" + imported.record.output_channel.name;
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(Roles, AreFoundByNamesAndUnitsInAnyOrder) {
  EXPECT_EQ(columns_of("Weg;Zeit;Spannung\n1;0,5;2\n2;1,0;3\n3;1,5;4\n"), "Spannung/Weg");
  EXPECT_EQ(columns_of("a [V],b [mm],time [s]\n1,2,0\n2,3,1\n"), "a/b");
  EXPECT_EQ(columns_of("0.5,1,2\n1.0,1,3\n1.5,2,4\n"), "input/output");
}

TEST(Roles, AreAskedForWhereTwoColumnsMayBeTheInput) {
  const std::string text = "time,a [V],b [V],c [mm]\n0,1,2,3\n1,2,3,4\n";
  const std::string refusal = columns_of(text);
  EXPECT_NE(refusal.find("which columns are input and output?"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--time 1 --input 2 --output 4`"), std::string::npos) << refusal;
  EXPECT_EQ(columns_of(text, {.input = "b"}), "b/c");
  EXPECT_EQ(columns_of(text, {.input = "3", .output = "c [mm]"}), "b/c");
}

TEST(Roles, OfColumnsThatAreNamedByNumbersAreAskedAboutAndChosenByNumber) {
  const std::string rows = "\n0,1,2\n0.1,2,3\n0.2,4,3\n";
  const std::string refusal = columns_of("Time (s),1 (VOLT),2 (VOLT)" + rows);
  EXPECT_NE(refusal.find("--time 1 --input 2 --output 3`"), std::string::npos) << refusal;
  EXPECT_EQ(columns_of("Time (s),1 (VOLT),2 (VOLT)" + rows, {.input = "2", .output = "3"}), "1/2");
  EXPECT_NE(columns_of("Time (s),a [V],b [V]" + rows, {.input = "a [V]", .output = "2"}).find("are one column"),
            std::string::npos);
}

TEST(Roles, OfACardsPortsAreAsTheCardDrivesAndReads) {
  const std::string rows = "\n0,1,2\n0.1,2,3\n0.2,4,3\n";
  for (const auto& [out, in] :
       {std::pair("AO0", "AI0"), std::pair("AO 0 [V]", "AI 1 [V]"), std::pair("Dev1/ao0", "Dev1/ai3"),
        std::pair("Analog Output 0", "Analog Input 0"), std::pair("AnalogOut_V", "AnalogIn_V"),
        std::pair("DAC1", "ADC2"), std::pair("Out", "Act"), std::pair("PWM", "Encoder"), std::pair("MV", "PV"),
        std::pair("Stellgröße", "Regelgröße")}) {
    const auto read = [&, out = std::string(out), in = std::string(in)](bool in_order) {
      const std::string roles = columns_of("Time (s)," + (in_order ? out + "," + in : in + "," + out) + rows);
      const std::size_t slash = roles.rfind('/');
      return std::pair(roles.substr(0, slash), roles.substr(slash + 1));
    };
    EXPECT_EQ(read(true), read(false)) << out << " and " << in;
    EXPECT_EQ(read(true).first.substr(0, 1), std::string_view(out).starts_with("Dev") ? "a" : std::string(1, out[0]))
        << out;
  }
  // What a name says beside the port counts, and of two inputs of a card none is the plant's by itself.
  EXPECT_EQ(columns_of("Time (s),AI0 Rod [mm],AI1 Valve [V]" + rows), "AI1_Valve/AI0_Rod");
  EXPECT_EQ(columns_of("Time (s),AI0 [mm],AI1 [V]" + rows), "AI1/AI0");
  EXPECT_NE(columns_of("Time (s),AI0 [V],AI1 [V]" + rows).find("which columns"), std::string::npos);
  EXPECT_NE(columns_of("Time (s),Contact,Impact" + rows).find("Contact"), std::string::npos);
}

TEST(Roles, LeaveOutSetPointsForcesAndPressures) {
  EXPECT_EQ(columns_of("Zeit;Soll;Ist;Ventil\n0;1;2;3\n0,1;2;3;4\n0,2;3;4,5;5\n"), "Ventil/Ist");
  EXPECT_EQ(columns_of("Time [s],Ch 1 Displacement [mm],Ch 1 Command [mm],Ch 1 Force [kN],Servo Output [V]\n"
                       "0,1,2,3,4\n0.1,2,3,4,5\n0.2,3,4,5,6\n"),
            "Servo_Output/Ch_1_Displacement");
  EXPECT_EQ(columns_of("Zeit (s);Stellwert;Lage_Ist;Lage_Soll\n0;1;2;3\n0,1;2;3;4\n0,2;3;4;5\n"), "Stellwert/Lage Ist");
  EXPECT_EQ(columns_of("Zeit;Ventil Soll [V];Kraft [kN];Weg [mm]\n0;1;2;3\n0,1;2;3;4\n0,2;3;4;5\n"), "Ventil_Soll/Weg");
}

TEST(Roles, AskBeforeAForceOrASetPointIsTheInput) {
  for (const char* header : {"time [s],force [kN],place [mm]", "time [s],p [bar],place [mm]",
                             "time [s],position set point,place [mm]", "time [s],Command [mm],Actual [mm]"}) {
    const std::string text = std::string(header) + "\n0,1,2\n0.1,2,3\n0.2,4,3\n";
    const std::string refusal = columns_of(text);
    EXPECT_NE(refusal.find("--time 1 --input 2 --output 3`"), std::string::npos) << refusal;
    EXPECT_EQ(columns_of(text, {.input = "2", .output = "3"}).find("which columns"), std::string::npos);
  }
}

TEST(Roles, AskBeforeAValvesOwnFeedbackIsTheOutput) {
  for (const auto& [header, answer] :
       {std::pair("Zeit [s];Ventil Soll [V];Ventil Ist [V];Druck [bar]", "--input 2 --output 4`"),
        std::pair("Zeit [s];Ventil Soll [V];Ventil Ist [V]", "--input 2 --output 3`"),
        std::pair("time;valve_cmd;valve_fbk;p [bar]", "--input 2 --output 4`"),
        std::pair("time [s];spool command [%];spool actual [%];p [bar]", "--input 2 --output 4`"),
        std::pair("time [s];spool command [mm];spool actual [mm]", "--input 2 --output 3`"),
        std::pair("Zeit [s];Strom Soll [mA];Strom Ist [mA];Kraft [N]", "--input 2 --output 4`")}) {
    const bool is_three = std::count(header, header + std::string_view(header).size(), ';') == 2;
    const std::string text =
        std::string(header) + (is_three ? "\n0;1;2\n0.1;2;3\n0.2;4;3\n" : "\n0;1;2;5\n0.1;2;3;6\n0.2;4;3;8\n");
    const std::string refusal = columns_of(text);
    EXPECT_NE(refusal.find("which columns are input and output?"), std::string::npos) << header << ": " << refusal;
    EXPECT_NE(refusal.find("is what the valve reports of itself"), std::string::npos) << header << ": " << refusal;
    EXPECT_NE(refusal.find(answer), std::string::npos) << header << ": " << refusal;
    EXPECT_EQ(columns_of(text, {.input = "2", .output = "3"}).find("which columns"), std::string::npos) << header;
  }
  EXPECT_EQ(columns_of("Zeit [s];Ventil Soll [V];Ventil Ist [V];Weg [mm]\n0;1;2;3\n0,1;2;3;5\n0,2;4;3;6\n"),
            "Ventil_Soll/Weg");
  EXPECT_EQ(columns_of("Zeit [s];Ventil Ist [V];Weg [mm]\n0;1;2\n0,1;2;3\n0,2;4;3\n"), "Ventil_Ist/Weg");
  EXPECT_EQ(columns_of("Zeit [s];Ventil [V];Kolben Ist [V]\n0;1;2\n0,1;2;3\n0,2;4;3\n"), "Ventil/Kolben_Ist");
}

TEST(Roles, AskBeforeThePlaceThatALoopIsToReachIsTheInput) {
  for (const char* header : {"Zeit [s];Weg Soll [V];Weg Ist [V]", "Zeit [s];Weg Soll [mm];Weg Ist [mm]",
                             "time [s];position command [V];position [V]", "time [s];pos_ref;pos"}) {
    const std::string text = std::string(header) + "\n0;1;2\n0.1;2;3\n0.2;4;3\n";
    const std::string refusal = columns_of(text);
    EXPECT_NE(refusal.find("--time 1 --input 2 --output 3`"), std::string::npos) << header << ": " << refusal;
    EXPECT_EQ(columns_of(text, {.input = "2", .output = "3"}).find("which columns"), std::string::npos) << header;
  }
}

TEST(Roles, OfAHeaterAreNotItsSurroundings) {
  const std::string text = "Time [s];Ambient;Heater_W;T_block\n0;21;0;20\n1;21.1;50;20\n2;21;50;22\n3;21.1;50;25\n";
  const std::string refusal = columns_of(text);
  EXPECT_NE(refusal.find("--time 1 --input 3 --output 4`"), std::string::npos) << refusal;
}

TEST(ExampleOfAQuestion, TakesANamelessColumnThatIsHeldForTheInput) {
  const std::string refusal =
      columns_of("1,0.0,23.9,0,0.1\n2,0.1,24.1,0,0.2\n3,0.2,24.0,5,0.1\n4,0.3,23.8,5,0.9\n5,0.4,24.2,5,1.7\n");
  EXPECT_NE(refusal.find("--input 4 --output 5`"), std::string::npos) << refusal;
}

TEST(ExampleOfAQuestion, TakesNoTemperatureThatCreepsForTheInput) {
  const std::string refusal = columns_of(
      "0.0,-1.3,149.9,41.00\n0.1,-1.4,149.8,41.00\n0.2,-1.5,149.7,41.00\n0.3,-1.6,149.5,41.01\n"
      "0.4,-1.2,149.3,41.01\n0.5,-0.9,149.2,41.01\n");
  EXPECT_NE(refusal.find("--input 2 --output 3`"), std::string::npos) << refusal;
}

TEST(EpochTimes, AreInTheUnitInWhichTheyLieInThisCentury) {
  const auto unit_of_column = [](double from, double step) {
    Column time;
    for (int k = 0; k < 5; ++k) time.sample.push_back(from + k * step);
    return epoch_unit_s(time);
  };
  EXPECT_EQ(unit_of_column(1795764000.0, 0.05), 1.0);
  EXPECT_EQ(unit_of_column(1795764000006.0, 50.0), 1e-3);
  EXPECT_EQ(unit_of_column(1795764000006000.0, 50e3), 1e-6);
  EXPECT_EQ(unit_of_column(1795764000006000000.0, 50e6), 1e-9);
  EXPECT_FALSE(unit_of_column(1795764000.0, 20e3));  // microseconds since the start of the machine
  EXPECT_FALSE(unit_of_column(0.0, 0.05));
}

TEST(Command, HasEachOptionOnce) {
  const auto with = [](const std::string& command, const std::string& extra) {
    return command_with({.command = command}, "r.csv", extra);
  };
  EXPECT_EQ(with("", "--resample"), "eha import r.csv --resample");
  EXPECT_EQ(with("eha fit r.csv --input 2 --output 3", "--input 3 --output 2"), "eha fit r.csv --input 3 --output 2");
  EXPECT_EQ(with("eha fit --input 'a '\\''b' --to 5 -- -r.csv", "--input 3"), "eha fit --to 5 --input 3 -- -r.csv");
  EXPECT_EQ(with("eha fit r.csv --resample --to 5", "--resample"), "eha fit r.csv --to 5 --resample");
  EXPECT_EQ(with("eha fit r.csv --to=5 --from=1", "--to 9"), "eha fit r.csv --from=1 --to 9");
}

TEST(Command, OfOneWithoutTheseOptionsFollowsOnAnImportedCopy) {
  const Options options{.then = "eha compare a.csv 'b c.csv' -o x.html"};
  EXPECT_EQ(command_with(options, "b c.csv", "--resample"),
            "eha import 'b c.csv' --resample -o 'b c-record.csv' && eha compare a.csv 'b c-record.csv' -o x.html");
  EXPECT_EQ(command_on(options, "a.csv", "a-rest.csv"), "eha compare a-rest.csv 'b c.csv' -o x.html");
}

TEST(Command, OnAFileThatWasMadeOfTheNamedOneKeepsWhatHoldsForIt) {
  const Options options{.command = "eha fit r.txt --delimiter tab --input u --to 9 --units mm -o m"};
  EXPECT_EQ(command_on(options, "r.txt", "r-columns.csv", kOfText),
            "eha fit r-columns.csv --input u --to 9 --units mm -o m");
  EXPECT_EQ(command_on(options, "r.txt", "r-rest.txt", {}, "--input 2"),
            "eha fit r-rest.txt --delimiter tab --to 9 --units mm -o m --input 2");
  EXPECT_EQ(command_on({}, "r.txt", "r-rest.txt"), "eha import r-rest.txt");
  EXPECT_EQ(command_that_made({.command = "eha fit r.txt --to 9 -o 'm 1' --json -v"}), "eha fit r.txt --to 9");
  EXPECT_EQ(command_that_made({.command = "eha fit 'bench -v -o 2.csv' --units mm --output=y"}),
            "eha fit 'bench -v -o 2.csv' --output=y");
}

TEST(Units, OfTimeAreConvertedAndOthersKept) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("r.csv", "t [ms];u [mV];y [mm]\n0;1;2\n0,5;1;3\n1,0;2;4\n");
  const ident::Record record = import_record(path, {}).record;
  EXPECT_DOUBLE_EQ(record.step_s, 0.0005);
  EXPECT_EQ(record.input_channel.unit, "mV");
  EXPECT_EQ(record.output_channel.unit, "mm");
}

TEST(Period, ReplacesTheTimeColumn) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("r.csv", "u,y\n1,2\n1,3\n2,4\n4,8\n");
  const ident::Record record = import_record(path, {.period_s = 0.25, .from_s = 0.25, .to_s = 0.5}).record;
  EXPECT_DOUBLE_EQ(record.step_s, 0.25);
  EXPECT_DOUBLE_EQ(record.start_s, 0.25);
  EXPECT_EQ(record.output, Eigen::Vector2d(3.0, 4.0));
}

TEST(ExampleOfAQuestion, PrefersAPlaceOrAPressureToATemperature) {
  const test::TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> files{
      {"t [s],Valve A [V],Valve B [V],Oil temp [degC],Position left [mm],Position right [mm]", "--input 2 --output 5`"},
      {"t [s],Temperature [degC],Valve [V],p A [bar],p B [bar]", "--output 4`"},
      {"t [s],T1 [degC],Valve A [V],Valve B [V],Signal", "--output 5`"},
      {"t [s],Oil temp [V],Valve A [V],Valve B [V],Rod [V],Lage [V]", "--output 5`"}};
  for (const auto& [header, example] : files) {
    std::string text = header + "\n";
    const auto columns = std::count(header.begin(), header.end(), ',');
    for (int k = 0; k < 60; ++k) {
      text += fmt::format("{:.2f}", 0.01 * k);
      for (int c = 0; c < columns; ++c) text += fmt::format(",{:.4f}", std::sin(0.1 * k * (c + 1)) + 0.01 * (k % 7));
      text += "\n";
    }
    try {
      static_cast<void>(import_record(folder.write("many.csv", text), {}));
      ADD_FAILURE() << header;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find(example), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace eha::importer
