// SPDX-License-Identifier: GPL-3.0-or-later
// Files as a technician has them: what is read, what is asked, and never a number that nothing said.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/importer/foreign_reader.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/importer/bench_file.hpp"

namespace eha::importer {
namespace {

/// Rows of "TIME;u;y" in German, below a header.
std::string german(std::size_t rows, const std::function<std::string(std::size_t)>& time, const char* header) {
  std::string text = header;
  for (std::size_t k = 0; k < rows; ++k) {
    const double phase = 0.05 * static_cast<double>(k);
    text += time(k) + ";" + with_comma(std::sin(phase), 4) + ";" + with_comma(2.0 + std::sin(phase - 0.5), 4) + "\n";
  }
  return text;
}

constexpr const char* kGermanHeader = "Zeit;Spannung [V];Weg [mm]\n";

std::string clock_at(double seconds, int decimals) {
  const int whole = static_cast<int>(seconds);
  const std::string text = fmt::format("10:{:02}:{:02}", whole / 60, whole % 60);
  return decimals == 0 ? text : text + with_comma(seconds - whole, decimals).substr(1);
}

TEST_F(BenchFile, OfAClockOfWholeSecondsOffersThePeriodOfAllItsRows) {
  for (const double period_s : {0.01, 0.004, 0.02}) {
    // The first row is somewhere within its second.
    for (const double begin_s : {0.0, 0.37, 0.993}) {
      const auto rows = static_cast<std::size_t>(60.0 / period_s);
      const auto path = write(
          "excel.csv", german(
                           rows,
                           [&](std::size_t k) {
                             return "23.11.2026 " + clock_at(begin_s + period_s * (static_cast<double>(k) + 1e-6), 0);
                           },
                           kGermanHeader));
      const std::string refusal = refusal_of(path);
      EXPECT_DOUBLE_EQ(offered(refusal), period_s) << refusal;
      Options options;
      options.period_s = offered(refusal);
      EXPECT_DOUBLE_EQ(import_record(path, options).record.step_s, period_s);
    }
  }
}

TEST_F(BenchFile, KeepsTheMillisecondsOfAGermanDate) {
  const auto path =
      write("date.csv",
            german(
                300, [](std::size_t k) { return "23.11.2026 " + clock_at(0.02 * (static_cast<double>(k) + 1e-6), 3); },
                kGermanHeader));
  EXPECT_DOUBLE_EQ(import_record(path, {}).record.step_s, 0.02);
}

TEST_F(BenchFile, GoesOverMidnightAndStopsWhereAClockRestarts) {
  const auto at = [](std::size_t k) {
    const std::size_t second = (23 * 3600 + 59 * 60 + 50 + k / 10) % 86400;
    return fmt::format("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60);
  };
  EXPECT_DOUBLE_EQ(offered(refusal_of(write("night.csv", german(600, at, kGermanHeader)))), 0.1);
  const auto twice = [](std::size_t k) { return clock_at(0.1 * (static_cast<double>(k % 400) + 1e-6), 0); };
  const auto path = write("twice.csv", german(800, twice, kGermanHeader));
  const std::string refusal = refusal_of(path);
  EXPECT_DOUBLE_EQ(offered(refusal), 0.1) << refusal;
  EXPECT_NE(refusal.find("goes back at row 401"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--to 39.9`"), std::string::npos) << refusal;
  Options options;
  options.period_s = 0.1;
  options.to_s = 39.9;
  EXPECT_EQ(import_record(path, options).record.input.size(), 400);
}

TEST_F(BenchFile, NamesAPauseOfAClockAndOffersThePeriodOfTheRowsBesideIt) {
  for (const int decimals : {0, 2, 3}) {
    for (const double begin_s : {0.0, 0.37}) {
      const auto at = [&](std::size_t k) {
        return clock_at(begin_s + 0.01 * (static_cast<double>(k) + 1e-6) + (k < 2050 ? 0.0 : 10.0), decimals);
      };
      const auto path = write("pause.csv", german(6000, at, kGermanHeader));
      const std::string refusal = refusal_of(path);
      Options options;
      if (decimals == 0) {
        EXPECT_DOUBLE_EQ(offered(refusal), 0.01) << refusal;
        EXPECT_NE(refusal.find(" s before row 2051"), std::string::npos) << refusal;
        EXPECT_NE(refusal.find("--from 20.5`"), std::string::npos) << refusal;
        options.period_s = 0.01;
        options.from_s = 20.5;
      } else {
        EXPECT_NE(refusal.find("a step of 10.01 s"), std::string::npos) << refusal;
        EXPECT_NE(refusal.find("--from 30.5`"), std::string::npos) << refusal;
        options.from_s = 30.5;
      }
      EXPECT_EQ(import_record(path, options).record.input.size(), 3950);
    }
  }
}

TEST_F(BenchFile, TakesTheUnevenStampsOfABusyComputerForNoPause) {
  const auto at = [](std::size_t k) {
    const double late_s = k % 7 == 3 ? 0.008 : k % 11 == 5 ? 0.004 : 0.0;
    return clock_at(0.01 * static_cast<double>(k) + late_s + 1e-6, 3);
  };
  const std::string refusal = refusal_of(write("busy.csv", german(3001, at, kGermanHeader)));
  EXPECT_DOUBLE_EQ(offered(refusal), 0.01) << refusal;
  EXPECT_EQ(refusal.find("before row"), std::string::npos) << refusal;
}

TEST_F(BenchFile, AsksWhetherPartsOfADayAreTimesOfDay) {
  const auto path =
      write("day.csv",
            german(
                2000, [](std::size_t k) { return with_comma(0.4166667 + 0.02 / 86400.0 * static_cast<double>(k), 10); },
                kGermanHeader));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("days of a spreadsheet, or seconds?"), std::string::npos) << refusal;
  EXPECT_NEAR(offered(refusal), 0.02, 1e-4) << refusal;
}

TEST_F(BenchFile, AsksWhetherASpreadsheetsDatesAreDaysOrSeconds) {
  const auto path = write(
      "serial.csv",
      german(
          2000, [](std::size_t k) { return with_comma(46349.4166667 + 15.0 / 86400.0 * static_cast<double>(k), 7); },
          kGermanHeader));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("days of a spreadsheet, or seconds?"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("--time 1`"), std::string::npos) << refusal;
  EXPECT_DOUBLE_EQ(offered(refusal), 15.0) << refusal;
  // A clock that counts seconds since the machine was switched on.
  const auto uptime = write(
      "uptime.csv",
      german(
          2000, [](std::size_t k) { return with_comma(46349.4 + 0.01 * static_cast<double>(k), 2); }, kGermanHeader));
  EXPECT_DOUBLE_EQ(import_record(uptime, {}).record.step_s, 0.01);
}

TEST_F(BenchFile, TakesTimesInSinglePrecisionAsEven) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  for (int k = 0; k < 24841; ++k) text += fmt::format("{:.9g},{},2.5\n", static_cast<float>(k) * 0.001F, k % 7);
  const Imported imported = import_record(write("single.csv", text), {});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.001);
  EXPECT_EQ(imported.record.input.size(), 24841);
  EXPECT_TRUE(imported.repairs.empty());
  Options options;
  options.resample = true;
  EXPECT_TRUE(import_record(write("single.csv", text), options).repairs.empty());
}

TEST_F(BenchFile, SumsUpRepairsInOneLineAKind) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  for (int k = 0; k < 4000; ++k) {
    if (k % 100 == 50) continue;
    text += fmt::format("{:.6f},{},2.5\n", 0.01 * k + (k % 10 == 3 ? 0.002 : 0.0), k % 7);
  }
  Options options;
  options.resample = true;
  const Imported imported = import_record(write("gaps.csv", text), options);
  ASSERT_EQ(imported.repairs.size(), 2U) << fmt::format("{}", fmt::join(imported.repairs, "\n"));
  EXPECT_NE(imported.repairs[0].find("40 rows in 40 places: nothing measured, filled"), std::string::npos)
      << imported.repairs[0];
  EXPECT_NE(imported.repairs[1].find("400 rows in 400 places: up to 0.002 s off the grid, moved"), std::string::npos)
      << imported.repairs[1];
}

TEST_F(BenchFile, InventsNoSamplePeriod) {
  for (const char* text : {"u,y\n0.1,2.5\n0.2,2.6\n0.1,2.7\n", "n;u;y\n0;1;2\n1;2;2\n2;1;3\n",
                           "Zeit [bar],u,y\n0.5,1,2\n0.6,2,2\n0.7,1,3\n"}) {
    const std::string refusal = refusal_of(write("plain.csv", text));
    EXPECT_NE(refusal.find("--period SECONDS"), std::string::npos) << refusal;
    EXPECT_EQ(refusal.find("0.001"), std::string::npos) << refusal;
    EXPECT_EQ(refusal.find("1 ms"), std::string::npos) << refusal;
  }
}

TEST_F(BenchFile, SaysThatNoRigIsSampledSoFast) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  for (int k = 0; k < 100; ++k) text += fmt::format("{},{},2.5\n", 1e-6 * k, k % 7);
  EXPECT_NE(remarks_of(write("fast.csv", text)).find("faster than any hydraulic rig"), std::string::npos);
}

TEST_F(BenchFile, SaysThatNoRodIsRecordedSoSlowly) {
  // Milliseconds in a column of seconds, at 1 kHz and at 50 Hz.
  for (const double step : {1.0, 20.0}) {
    const auto rows = [&](const char* output) {
      std::string text = fmt::format("time_s,voltage_V,{}\n", output);
      for (int k = 0; k < 100; ++k) text += fmt::format("{},{},{}\n", step * k, k % 7, k % 5);
      return text;
    };
    EXPECT_NE(remarks_of(write("slow.csv", rows("displacement_in")))
                  .find("is slow for a rod, if the output is one: check the unit of the time"),
              std::string::npos);
    EXPECT_EQ(remarks_of(write("tank.csv", rows("temperature_K"))).find("slow for a rod"), std::string::npos);
  }
}

TEST_F(BenchFile, TakesASpreadsheetsErrorForAMissingValue) {
  for (const char* error : {"#WERT!", "#NV", "#DIV/0!", "#BEZUG!", "#N/A"}) {
    for (const int kind : {0, 1, 2}) {  // a cell, the first cell, the only cell of a row
      std::string text = "Zeit [s];Spannung [V];Weg [mm]\n";
      for (int k = 0; k < 50; ++k) {
        const std::string time = with_comma(0.1 * k, 1);
        const std::string rest = with_comma(0.3 * (k % 5), 1) + ";" + with_comma(2.0 + 0.1 * (k % 3), 1);
        text += k != 20     ? time + ";" + rest
                : kind == 0 ? time + ";" + error + ";2,0"
                : kind == 1 ? error + (";" + rest)
                            : error;
        text += "\n";
      }
      const auto path = write("errors.csv", text);
      EXPECT_NE(refusal_of(path), "") << error << kind;
      Options options;
      options.resample = true;
      const Imported imported = import_record(path, options);
      EXPECT_EQ(imported.record.input.size(), 50) << error << kind;
      EXPECT_EQ(imported.record.unmeasured, std::vector<std::size_t>{20}) << error << kind;
    }
  }
}

TEST_F(BenchFile, ShowsUmlautsAsTheyAre) {
  const std::string text = "März;Öldruck;Größe\n1;2;3\n2;1;2\n3;2;1\n";
  const std::string refusal = refusal_of(write("umlaut.csv", text));
  EXPECT_NE(refusal.find("März"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find("??"), std::string::npos) << refusal;
}

/// The parts of a workbook with rows of a date, volts and millimetres every 10 ms, as Excel writes them.
std::vector<std::pair<std::string, std::string>> workbook_parts() {
  const std::string head = "<?xml version=\"1.0\"?>";
  const std::string office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
  const std::string main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
  const std::string package = "http://schemas.openxmlformats.org/package/2006/";
  const auto relation = [&](int id, const char* kind, const char* target) {
    return fmt::format("<Relationship Id=\"rId{}\" Type=\"{}/{}\" Target=\"{}\"/>", id, office, kind, target);
  };
  const auto relations = [&](const std::string& list) {
    return head + "<Relationships xmlns=\"" + package + "relationships\">" + list + "</Relationships>";
  };
  std::string rows = "<row r=\"1\">";
  for (const char* name : {"Zeit", "Spannung [V]", "Weg [mm]"}) {
    rows += fmt::format("<c t=\"inlineStr\"><is><t>{}</t></is></c>", name);
  }
  rows += "</row>";
  for (int k = 0; k < 300; ++k) {
    rows += fmt::format("<row r=\"{}\"><c s=\"1\"><v>{}</v></c><c><v>{}</v></c><c><v>{}</v></c></row>", k + 2,
                        46349.4166666667 + 0.01 / 86400.0 * k, 0.25 * (k % 7), 2.0 + 0.5 * (k % 3));
  }
  return {{"[Content_Types].xml", head + "<Types xmlns=\"" + package +
                                      "content-types\"><Default Extension=\"rels\" ContentType=\"application/"
                                      "vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"xml\" "
                                      "ContentType=\"application/xml\"/></Types>"},
          {"_rels/.rels", relations(relation(1, "officeDocument", "xl/workbook.xml"))},
          {"xl/workbook.xml", head + "<workbook xmlns=\"" + main + "\" xmlns:r=\"" + office +
                                  "\"><sheets><sheet name=\"Daten\" sheetId=\"1\" r:id=\"rId1\"/></sheets></workbook>"},
          {"xl/_rels/workbook.xml.rels",
           relations(relation(1, "worksheet", "worksheets/sheet1.xml") + relation(2, "styles", "styles.xml"))},
          {"xl/styles.xml", head + "<styleSheet xmlns=\"" + main +
                                "\"><numFmts count=\"1\"><numFmt numFmtId=\"164\" formatCode=\"dd.mm.yyyy "
                                "hh:mm:ss\"/></numFmts><cellXfs count=\"2\"><xf numFmtId=\"0\"/><xf numFmtId=\"164\" "
                                "applyNumberFormat=\"1\"/></cellXfs></styleSheet>"},
          {"xl/worksheets/sheet1.xml",
           head + "<worksheet xmlns=\"" + main + "\"><sheetData>" + rows + "</sheetData></worksheet>"}};
}

void replace(std::string& text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
}

/// A zip archive of stored files.
std::string archive_of(const std::vector<std::pair<std::string, std::string>>& files) {
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xffU);
    return text;
  };
  const auto checksum = [](const std::string& text) {
    std::uint32_t crc = 0xffffffffU;
    for (const char c : text) {
      crc ^= static_cast<unsigned char>(c);
      for (int i = 0; i < 8; ++i) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
    }
    return ~crc;
  };
  std::string all;
  std::string directory;
  for (const auto& [name, content] : files) {
    const auto size = static_cast<std::uint32_t>(content.size());
    const std::string facts = number(0, 2) + number(0, 2) + number(0, 4) + number(checksum(content), 4) +
                              number(size, 4) + number(size, 4) + number(static_cast<std::uint32_t>(name.size()), 2) +
                              number(0, 2);
    directory += number(0x02014b50, 4) + number(20, 2) + number(20, 2) + facts + number(0, 2) + number(0, 2) +
                 number(0, 2) + number(0, 4) + number(static_cast<std::uint32_t>(all.size()), 4) + name;
    all += number(0x04034b50, 4) + number(20, 2) + facts + name + content;
  }
  const auto count = static_cast<std::uint32_t>(files.size());
  return all + directory + number(0x06054b50, 4) + number(0, 4) + number(count, 2) + number(count, 2) +
         number(static_cast<std::uint32_t>(directory.size()), 4) + number(static_cast<std::uint32_t>(all.size()), 4) +
         number(0, 2);
}

TEST_F(BenchFile, IsAWorkbook) {
  if (access(kWorkbookProgram, X_OK) != 0) GTEST_SKIP() << "xlsx2csv is not installed";
  const auto path = write("bench.xlsx", archive_of(workbook_parts()));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("days of a spreadsheet"), std::string::npos) << refusal;
  EXPECT_DOUBLE_EQ(offered(refusal), 0.01) << refusal;
  Options options;
  options.period_s = 0.01;
  const Imported imported = import_record(path, options);
  ASSERT_EQ(imported.record.input.size(), 300);
  EXPECT_EQ(imported.record.input[6], 1.5);
  EXPECT_EQ(imported.record.output[4], 2.5);
  EXPECT_EQ(imported.record.output_channel.unit, "mm");
  EXPECT_NE(imported.guess.find("workbook, first sheet"), std::string::npos) << imported.guess;
  EXPECT_NE(refusal_of(write("other.xlsx", archive_of({{"a.txt", "1,2,3\n"}}))).find("no workbook"), std::string::npos);
}

TEST_F(BenchFile, IsNoWorkbookThatNamesALongTextInEachRow) {
  if (access(kWorkbookProgram, X_OK) != 0) GTEST_SKIP() << "xlsx2csv is not installed";
  // The text stands once in the file, and in each row of what is unpacked: 10 MB of 0.1 MB.
  auto parts = workbook_parts();
  for (auto& [name, content] : parts) {
    if (name == "xl/_rels/workbook.xml.rels") {
      replace(content, "</Relationships>",
              "<Relationship Id=\"rId3\" Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/"
              "sharedStrings\" Target=\"sharedStrings.xml\"/></Relationships>");
    }
    if (name == "[Content_Types].xml") {
      replace(
          content, "</Types>",
          "<Override PartName=\"/xl/sharedStrings.xml\" ContentType=\"application/vnd.openxmlformats-officedocument."
          "spreadsheetml.sharedStrings+xml\"/></Types>");
    }
    if (name == "xl/worksheets/sheet1.xml") {
      std::string rows;
      for (int k = 0; k < 200; ++k) {
        rows +=
            fmt::format("<row r=\"{0}\"><c r=\"A{0}\"><v>1</v></c><c r=\"B{0}\" t=\"s\"><v>0</v></c></row>", k + 302);
      }
      replace(content, "</sheetData>", rows + "</sheetData>");
    }
  }
  parts.emplace_back(
      "xl/sharedStrings.xml",
      "<?xml version=\"1.0\"?><sst xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"><si>"
      "<t>" +
          std::string(50'000, 'x') + "</t></si></sst>");
  const std::string refusal = refusal_of(write("padded.xlsx", archive_of(parts)));
  EXPECT_NE(refusal.find("unpack to more than 3 MB of text; export the record as CSV"), std::string::npos) << refusal;
}

TEST_F(BenchFile, IsAskedAboutWhereAPointMayBeDecimalOrSeparateThousands) {
  const auto with = [&](const std::string& first_time) {
    std::string text = "Zeit [ms];Spannung [mV];Weg [um]\n" + first_time;
    for (int k = 1; k < 200; ++k) {
      const int um = 50'000 + static_cast<int>(10'000.0 * std::sin(0.1 * k));
      text += fmt::format("{};{};{}.{:03}\n", k, 20 * (k % 7), um / 1000, um % 1000);
    }
    return write("weg.txt", text);
  };
  const std::string refusal = refusal_of(with("0;0;74.989\n"));
  EXPECT_NE(refusal.find("is \"74.989\" 74989 or 74.989?"), std::string::npos) << refusal;
  // One number whose point can only be decimal decides for the file.
  EXPECT_EQ(refusal_of(with("0;0;0.989\n")), "");
  EXPECT_EQ(refusal_of(with("0.0;0;74.989\n")), "");
}

/// As LabVIEW's "Write To Measurement File" makes it, with one column of times for all channels.
TEST_F(BenchFile, IsAMeasurementOfLabView) {
  std::string text =
      "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
      "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tAbsolute\nOperator\tlab\nDate\t2026/11/23\nTime\t10:00:00.5\n"
      "***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t200\t200\t\nDate\t2026/11/23\t2026/11/23\t\n"
      "Time\t10:00:00.5\t10:00:00.5\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.005\t0.005\t\n"
      "***End_of_Header***\t\t\t\nX_Value\tVoltage_V\tDisplacement_in\tComment\n";
  for (int k = 0; k < 200; ++k) text += fmt::format("{:.6f}\t{:.6f}\t{:.6f}\n", 0.005 * k, std::sin(0.1 * k), 2.5);
  const Imported imported = import_record(write("lab.lvm", text), {});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.005) << imported.guess;
  EXPECT_EQ(imported.record.input.size(), 200);
  EXPECT_EQ(imported.record.input_channel.unit, "V");
}

}  // namespace
}  // namespace eha::importer
