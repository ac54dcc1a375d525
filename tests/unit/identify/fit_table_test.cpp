// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/fit_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"
#include "daemon/identify/identification.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::identify {
namespace {

ident::Record record_of(int rows) {
  ident::Record record;
  record.step_s = 0.01;
  record.start_s = 5.0;
  record.input = Eigen::VectorXd::LinSpaced(rows, 0.0, rows - 1.0);
  record.output = 2.0 * record.input;
  return record;
}

IdentifiedModel compared_every(int step, const std::string& name, const ident::Record& record) {
  IdentifiedModel identified;
  identified.result.model.name = name;
  const Eigen::Index rows = record.input.size() / step;
  identified.result.time_s.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    identified.result.time_s[i] = record.start_s + static_cast<double>(i * step) * record.step_s;
  }
  identified.result.measured = Eigen::VectorXd::Constant(rows, 3.0);
  identified.result.simulated = Eigen::VectorXd::Constant(rows, 2.5);
  return identified;
}

TEST(FitTable, HoldsTheInputOfTheComparedRows) {
  const ident::Record record = record_of(100);
  ident::FitOptions options;
  options.procedure = ident::Procedure::paper;
  const FitTable table = fit_table(record, options, {compared_every(10, "io", record)});
  ASSERT_EQ(table.applied.size(), 10U);
  EXPECT_DOUBLE_EQ(table.applied[3], 30.0);
}

TEST(FitTable, LeavesOutAModelThatComparedOtherRows) {
  const ident::Record record = record_of(100);
  const FitTable table = fit_table(record, {}, {compared_every(10, "io", record), compared_every(20, "fo", record)});
  EXPECT_NE(table.find("io"), nullptr);
  EXPECT_EQ(table.find("fo"), nullptr);
}

TEST(FitTable, ReadsWhatItWrote) {
  const ident::Record record = record_of(40);
  FitTable table =
      fit_table(record, {}, {compared_every(10, "io_valve", record), compared_every(10, "a_residual", record)});
  table.models[1].simulated[2] = std::numeric_limits<double>::infinity();
  const eha::test::TemporaryFolder folder;
  const FitTable again = read_fit_table(folder.write("fit.csv", to_csv(table)));
  ASSERT_EQ(again.models.size(), 2U);
  EXPECT_EQ(again.models[0].model, "io_valve");
  EXPECT_EQ(again.models[1].model, "a_residual");
  EXPECT_EQ(again.input.unit, "V");
  EXPECT_EQ(again.output.name, "displacement");
  EXPECT_EQ(again.time_s, table.time_s);
  EXPECT_EQ(again.applied, table.applied);
  EXPECT_EQ(again.models[0].simulated, table.models[0].simulated);
  EXPECT_TRUE(std::isnan(again.models[1].simulated[2]));
}

TEST(FitTable, KeepsItsColumnsWhateverTheChannelsAreCalled) {
  ident::Record record = record_of(40);
  record.input_channel.name = "=cmd, \"x\"";
  const eha::test::TemporaryFolder folder;
  const FitTable table = fit_table(record, {}, {compared_every(10, "io", record)});
  const FitTable again = read_fit_table(folder.write("fit.csv", to_csv(table)));
  EXPECT_EQ(again.input.name, "'=cmd, \"x\"") << "no formula for a spreadsheet";
  EXPECT_EQ(again.models.at(0).simulated, table.models[0].simulated);
}

TEST(FitTable, NamesAFileThatIsNone) {
  const eha::test::TemporaryFolder folder;
  for (const char* text : {"time_s,voltage_V\n0,1\n", "time_s,voltage_V,x_in,io_in,other_in\n0,1,2,3,4\n",
                           "time_s,voltage_V,x_in\n0,1\n", "time_s,voltage_V,x_in\n0,1,two\n", ""}) {
    const auto path = folder.write("fit.csv", text);
    try {
      static_cast<void>(read_fit_table(path));
      ADD_FAILURE() << "accepted " << text;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace eha::identify
