// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/system/refusal.hpp"

namespace eha::test {
namespace {

constexpr const char* kInput = "time_s,voltage_V\n0,1\n0.1,1\n0.2,1\n";

/// `eha simulate` must refuse this model as wrong configuration.
void expect_bad_model(const std::string& text, const std::vector<std::string>& fragments) {
  const TemporaryFolder folder;
  folder.write("m.json", text);
  folder.write("u.csv", kInput);
  expect_refused(folder, {"simulate", "m.json", "u.csv", "-o", "y.csv"}, ExitCode::configuration, fragments);
}

TEST(BadModel, LacksAField) {
  expect_bad_model("{}", {"m.json", "transfer_function"});
  expect_bad_model(R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}]}})",
                   {"m.json", "denominator"});
  expect_bad_model(R"({"transfer_function": {"numerator": [{"order": 0}],
                       "denominator": [{"coefficient": 1, "order": 1}]}})",
                   {"m.json", "numerator", "coefficient"});
}

TEST(BadModel, HasANegativeOrder) {
  expect_bad_model(R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": -0.5}],
                       "denominator": [{"coefficient": 1, "order": 1}]}})",
                   {"m.json", "order", "-0.5"});
}

TEST(BadModel, HasAZeroDenominator) {
  expect_bad_model(R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
                       "denominator": [{"coefficient": 0, "order": 1}]}})",
                   {"m.json", "denominator"});
}

TEST(BadModel, IsNoJson) {
  expect_bad_model("{\"transfer_function\": ", {"m.json"});
  expect_bad_model("", {"m.json"});
  expect_bad_model(std::string("\0\1\2", 3), {"m.json"});
}

TEST(BadModel, IsUnstableForAnExactSimulation) {
  expect_bad_model(R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
                       "denominator": [{"coefficient": 1, "order": 1}, {"coefficient": -1, "order": 0}]}})",
                   {"m.json", "unstable"});
}

TEST(BadModel, IsMissing) {
  const TemporaryFolder folder;
  folder.write("u.csv", kInput);
  expect_refused(folder, {"simulate", "none.json", "u.csv"}, ExitCode::io, {"none.json", "No such file"});
  expect_refused(folder, {"simulate", ".", "u.csv"}, ExitCode::io, {"directory"});
}

TEST(BadInput, IsNoInput) {
  const TemporaryFolder folder;
  folder.write("m.json", R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
                             "denominator": [{"coefficient": 1, "order": 1}, {"coefficient": 1, "order": 0}]}})");
  folder.write("one_column.csv", "time_s\n0\n1\n");
  expect_refused(folder, {"simulate", "m.json", "one_column.csv"}, ExitCode::bad_data,
                 {"one_column.csv", "no column of inputs", "time_s"});
  folder.write("one_row.csv", "time_s,voltage_V\n0,1\n");
  expect_refused(folder, {"simulate", "m.json", "one_row.csv"}, ExitCode::bad_data, {"one_row.csv:2", "one row"});
  expect_refused(folder, {"simulate", "m.json", "."}, ExitCode::io, {"directory"});
}

}  // namespace
}  // namespace eha::test
