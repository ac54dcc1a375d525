// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/record_csv.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

using record::channel_from_header;
using record::header_from_channel;
using record::InputSeries;
using record::series_csv;
using test::TemporaryFolder;

TEST(SeriesCsv, KeepsANameWithQuotesAndSeparatorsInOneColumn) {
  const TemporaryFolder folder;
  const std::vector<double> time_s{0.0, 0.1, 0.2};
  for (const char* name : {"a \"b\"", "a,b", "a;b"}) {
    const auto path = folder.write("y.csv", series_csv(time_s, {name, "V"}, Eigen::Vector3d(1.0, 2.0, 3.0)));
    const InputSeries again = import_input(path, {}, "").series;
    EXPECT_EQ(again.channel.name, name);
    EXPECT_EQ(again.channel.unit, "V");
    EXPECT_EQ(again.values, Eigen::VectorXd(Eigen::Vector3d(1.0, 2.0, 3.0)));
  }
}

const std::string kHeader = "time_s,voltage_V,displacement_in\n";

ident::Record read(const std::string& text) {
  const TemporaryFolder folder;
  return import_record(folder.write("r.csv", text), {}).record;
}

/// The message about a faulty record, without the folder's name.
std::string fault_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto path = folder.write("r.csv", text);
  try {
    static_cast<void>(import_record(path, {}));
  } catch (const DataError& error) {
    const std::string message = error.what();
    const std::string prefix = folder.path().string() + "/";
    EXPECT_EQ(message.rfind(prefix, 0), 0U) << message;
    return message.substr(prefix.size());
  }
  return "no fault";
}

void expect_fault(const std::string& text, const std::string& beginning) {
  EXPECT_EQ(fault_of(text).substr(0, beginning.size()), beginning);
}

TEST(RecordCsv, ReadsColumnsNamesAndUnits) {
  const ident::Record record =
      read("# a comment, with a \"quote\n\ntime_s,valve_command_V,rod_in\n0.5,1,-2e-1\n0.6,+2,3\n");
  EXPECT_DOUBLE_EQ(record.start_s, 0.5);
  EXPECT_DOUBLE_EQ(record.step_s, 0.1);
  EXPECT_EQ(record.input, Eigen::Vector2d(1.0, 2.0));
  EXPECT_EQ(record.output, Eigen::Vector2d(-0.2, 3.0));
  EXPECT_EQ(record.input_channel.name, "valve_command");
  EXPECT_EQ(record.input_channel.unit, "V");
  EXPECT_EQ(record.output_channel.name, "rod");
  EXPECT_EQ(record.output_channel.unit, "in");
}

TEST(RecordCsv, ToleratesByteOrderMarkCarriageReturnsBlanksAndQuotes) {
  const ident::Record record =
      read("\xEF\xBB\xBF\"time_s\", \"voltage_V\",displacement_in\r\n0, 1 ,2\r\n\r\n1,\"3\",4");
  EXPECT_EQ(record.input, Eigen::Vector2d(1.0, 3.0));
  EXPECT_EQ(record.output, Eigen::Vector2d(2.0, 4.0));
  EXPECT_EQ(record.input_channel.name, "voltage");
}

TEST(RecordCsv, RefusesAnEmptyFile) { expect_fault("", "r.csv: the file is empty; expected a header"); }

TEST(RecordCsv, RefusesAFileOfComments) { expect_fault("# one\n# two\n", "r.csv: only comments, no header row"); }

TEST(RecordCsv, RefusesAHeaderWithoutRows) { expect_fault(kHeader, "r.csv:1: no row follows the header"); }

TEST(RecordCsv, RefusesASingleRow) { expect_fault(kHeader + "0,1,2\n", "r.csv:2: only one row follows the header"); }

TEST(RecordCsv, RefusesABinaryFile) {
  expect_fault(std::string("\x89HDF\r\n\x1a\n\0\0\0", 11), "r.csv: a damaged or truncated HDF5 file");
  expect_fault(std::string("ab\0cd\n", 6), "r.csv:1: a NUL byte: this is a binary file");
  expect_fault(kHeader + "0,1,2\n1,1" + std::string("\0", 1) + "5,2\n", "r.csv:3: a NUL byte");
  expect_fault(std::string(70000, 'x'), "r.csv:1: the line is longer than");
}

TEST(RecordCsv, RefusesANamelessFirstColumnThatMayNumberTheRows) {
  expect_fault("0,1,2\n1,2,3\n", "r.csv: column 1 counts 0, 1, 2: seconds, or the numbers of the rows?");
}

TEST(RecordCsv, RefusesAWrongHeader) {
  expect_fault("time_s\n0\n", "r.csv:1: got 1 column; expected a header of three columns");
  expect_fault("time_s,a_V,b_V,c_in\n0,1,2,3\n",
               "r.csv:1: which columns are input and output? It has 4 columns: 1 \"time_s\"");
  expect_fault("time_s,,b_in\n", "r.csv:1: column 2 of the header has no name");
  expect_fault("time_s,a_V,a_V\n", "r.csv:1: two columns are named \"a_V\"");
  expect_fault("time_s,a\x1b_V,b_in\n", "r.csv:1: column 2 of the header is named \"a?_V\"");
}

TEST(RecordCsv, NeverTakesACarriageReturnWithinALineForTheEndOfARow) {
  expect_fault("\r\r\rx\n", "r.csv:1: a carriage return within the line");
  expect_fault(kHeader + "0,1\r2\n1,1,2\n", "r.csv:2: a carriage return within the line");
  EXPECT_EQ(read("time_s,u,y\r0,1,2\r1,1,2\r").input, Eigen::Vector2d(1.0, 1.0));
  expect_fault("\r\r\n", "r.csv: only comments, no header row");
  EXPECT_EQ(read("time_s,u,y\r\r\n0,1,2\r\r\n\r\r\n1,3,4\r\r\n").input, Eigen::Vector2d(1.0, 3.0));
}

TEST(RecordCsv, TakesAColumnNameInLatin1) {
  EXPECT_EQ(read("time_s,Weg_\xB5m,y\n0,1,2\n1,1,2\n").input_channel.unit, "um");
  EXPECT_EQ(read("time_s,Weg_\xC2\xB5m,y\n0,1,2\n1,1,2\n").input_channel.unit, "um");
}

TEST(RecordCsv, KeepsMessagesShortAndPrintableWhateverTheColumnsAreCalled) {
  const std::string name = "\xC2\xB5" + std::string(2000, 'x');
  EXPECT_EQ(fault_of("time_s," + name + ",y\n0,a,2\n"),
            "r.csv:2: \xC2\xB5" + std::string(38, 'x') + "...: expected a number, got \"a\"");
  EXPECT_LT(fault_of(std::string(2000, '1') + ",u,y\n").size(), 400U);
}

TEST(RecordCsv, RefusesTextWhereANumberBelongs) {
  expect_fault(kHeader + "0,1,2\n# note\n1,abc,2\n", "r.csv:4: voltage_V: expected a number, got \"abc\"");
  expect_fault(kHeader + "0,1,2x\n", "r.csv:2: displacement_in: expected a number, got \"2x\"");
  expect_fault(kHeader + "0,,2\n", "r.csv:2: voltage_V: expected a number, got \"\"");
  expect_fault(kHeader + "0,++1,2\n", "r.csv:2: voltage_V: expected a number, got \"++1\"");
  expect_fault(kHeader + "0,0x10,2\n", "r.csv:2: voltage_V: expected a number, got \"0x10\"");
}

TEST(RecordCsv, RefusesNumbersThatAreNotFinite) {
  expect_fault(kHeader + "0,1,2\n1,nan,2\n", "r.csv:3: voltage_V: expected a finite number, got \"nan\"");
  expect_fault(kHeader + "0,1,-inf\n", "r.csv:2: displacement_in: expected a finite number, got \"-inf\"");
  expect_fault(kHeader + "NaN,1,2\n", "r.csv:2: time_s: expected a finite number, got \"NaN\"");
  expect_fault(kHeader + "0,1e999,2\n", "r.csv:2: voltage_V: expected a finite number, got \"1e999\"");
}

TEST(RecordCsv, RefusesRowsOfAnotherWidth) {
  expect_fault(kHeader + "0,1\n", "r.csv:2: expected 3 columns as in the header, got 2");
  expect_fault(kHeader + "0,1,2\n1,2,3,4\n", "r.csv:3: expected 3 columns as in the header, got 4");
}

TEST(RecordCsv, RefusesAQuotationMarkOutOfPlace) {
  expect_fault(kHeader + "0,1,\"2\n1,2,3\n", "r.csv:2: a quotation mark out of place");
}

TEST(RecordCsv, RefusesAMissingFileAndAFolder) {
  const TemporaryFolder folder;
  EXPECT_THROW(static_cast<void>(import_record(folder.path() / "none.csv", {})), IoError);
  EXPECT_THROW(static_cast<void>(import_record(folder.path(), {})), IoError);
}

TEST(InputCsv, TakesTheLastColumnAndLooksAtNoOther) {
  const TemporaryFolder folder;
  const auto path = folder.write("u.csv", "time_s,remark,duty_1\n0,first,0.25\n0.5,second,-1\n");
  const InputSeries series = import_input(path, {}, "").series;
  EXPECT_EQ(series.values, Eigen::Vector2d(0.25, -1.0));
  EXPECT_EQ(series.time_s, (std::vector<double>{0.0, 0.5}));
  EXPECT_DOUBLE_EQ(series.step_s, 0.5);
  EXPECT_EQ(series.channel.name, "duty");
  EXPECT_EQ(series.channel.unit, "1");
}

TEST(InputCsv, OfTimesInMinutesAreEvenInSeconds) {
  const TemporaryFolder folder;
  std::string text = "time [min];heater [%]\n";
  for (int k = 0; k < 60; ++k) text += fmt::format("{:.4f};{}\n", 5.0 * k / 60.0, k % 7);
  const InputSeries series = import_input(folder.write("oven.csv", text), {}, "%").series;
  ASSERT_EQ(series.time_s.size(), 60U);
  for (std::size_t k = 0; k < 60; ++k) EXPECT_EQ(series.time_s[k], 5.0 * static_cast<double>(k));
}

TEST(InputCsv, OfAForeignNameReadsBackWhenItIsWritten) {
  const TemporaryFolder folder;
  for (const char* name : {"voltage_", "_voltage", "valve  ", "Weg\\_"}) {
    const auto path = folder.write("u.csv", fmt::format("none_s,{}\n0,1\n0.001,-1\n0.002,0.5\n", name));
    const InputSeries series = import_input(path, {}, "").series;
    const auto written = folder.write("w.csv", series_csv(series.time_s, series.channel, series.values));
    const InputSeries again = import_input(written, {}, "").series;
    EXPECT_EQ(again.channel.name, series.channel.name) << name;
    EXPECT_EQ(again.channel.unit, series.channel.unit) << name;
  }
}

TEST(ChannelHeader, SplitsAtTheLastUnderscoreAndBack) {
  for (const char* name : {"voltage_V", "valve_command_V", "plain", "_V", "ends_"}) {
    EXPECT_EQ(header_from_channel(channel_from_header(name)), name);
  }
  EXPECT_EQ(channel_from_header("valve_command_V").unit, "V");
  EXPECT_EQ(channel_from_header("plain").unit, "");
}

TEST(SeriesCsv, ReadsBackToTheSameBits) {
  const std::vector<double> time_s{0.0, 0.1, 0.2};
  const Eigen::Vector3d values(1.0 / 3.0, -std::numeric_limits<double>::min(), 1e300);
  const TemporaryFolder folder;
  const auto path = folder.write("y.csv", series_csv(time_s, {"output", "in"}, values));
  const InputSeries series = import_input(path, {}, "in").series;
  EXPECT_EQ(series.time_s, time_s);
  EXPECT_EQ(series.values, values);
  EXPECT_EQ(series.channel.name, "output");
}

}  // namespace
}  // namespace eha::importer
