// SPDX-License-Identifier: GPL-3.0-or-later
// MAT-files in which the names and units of signals stand beside the numbers, as ControlDesk and Simulink write them.
#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kSignalRows = 300;

std::vector<double> signal(double (*of)(double)) {
  std::vector<double> values;
  for (std::size_t k = 0; k < kSignalRows; ++k) values.push_back(of(0.001 * static_cast<double>(k)));
  return values;
}

matvar_t* number_array(std::vector<double> values) {
  std::array<std::size_t, 2> size{1, values.size()};
  return Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), values.data(), 0);
}

matvar_t* text_array(const char* words) {
  std::array<std::size_t, 2> size{1, std::strlen(words)};
  return Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UINT8, 2, size.data(), const_cast<char*>(words), 0);
}

/// An array of structs with a name, a unit and numbers each. @param names  of these three fields
struct Signal {
  const char* name;
  const char* unit;
  std::vector<double> values;
};
matvar_t* signal_array(const std::array<const char*, 3>& names, const std::vector<Signal>& all) {
  std::array<std::size_t, 2> size{1, all.size()};
  std::array<const char*, 3> fields = names;
  matvar_t* made = Mat_VarCreateStruct(nullptr, 2, size.data(), fields.data(), 3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Mat_VarSetStructFieldByName(made, names[0], i, text_array(all[i].name));
    Mat_VarSetStructFieldByName(made, names[1], i, text_array(all[i].unit));
    Mat_VarSetStructFieldByName(made, names[2], i, number_array(all[i].values));
  }
  return made;
}

std::filesystem::path written(const test::TemporaryFolder& folder, const char* variable, const char* first,
                              matvar_t* of_first, const char* second, matvar_t* of_second) {
  const std::filesystem::path path = folder.path() / (std::string(variable) + ".mat");
  std::array<std::size_t, 2> one{1, 1};
  std::array<const char*, 2> fields{first, second};
  matvar_t* whole = Mat_VarCreateStruct(variable, 2, one.data(), fields.data(), 2);
  Mat_VarSetStructFieldByName(whole, first, 0, of_first);
  Mat_VarSetStructFieldByName(whole, second, 0, of_second);
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  Mat_VarWrite(file, whole, MAT_COMPRESSION_NONE);
  Mat_Close(file);
  Mat_VarFree(whole);
  return path;
}

std::vector<double> valve_signal() {
  return signal([](double t) { return std::sin(30.0 * t); });
}
std::vector<double> rod_signal() {
  return signal([](double t) { return 50.0 - std::cos(30.0 * t); });
}
std::vector<double> time_signal() {
  return signal([](double t) { return t; });
}

TEST(NamedSignals, OfControlDeskHaveTheirNamesAndUnits) {
  const test::TemporaryFolder folder;
  const std::array<const char*, 3> fields{"Name", "Unit", "Data"};
  const auto path = written(folder, "rec1", "X", signal_array(fields, {{"", "s", time_signal()}}), "Y",
                            signal_array(fields, {{"Model Root/Valve/u_cmd", "V", valve_signal()},
                                                  {"Model Root/Axis/x_act", "mm", rod_signal()},
                                                  {"Model Root/Axis/p_A", "bar", valve_signal()}}));
  const Imported imported = import_record(path, {});
  EXPECT_EQ(imported.record.input_channel.name, "u_cmd") << imported.guess;
  EXPECT_EQ(imported.record.input_channel.unit, "V");
  EXPECT_EQ(imported.record.output_channel.name, "x_act");
  EXPECT_EQ(imported.record.output_channel.unit, "mm");
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.001);
}

TEST(NamedSignals, AreShownInTheQuestion) {
  const test::TemporaryFolder folder;
  const std::array<const char*, 3> fields{"Name", "Unit", "Data"};
  const auto path =
      written(folder, "rec1", "X", signal_array(fields, {{"", "s", time_signal()}}), "Y",
              signal_array(
                  fields, {{"AI 1", "V", valve_signal()}, {"AI 2", "V", rod_signal()}, {"AI 3", "V", valve_signal()}}));
  try {
    static_cast<void>(import_record(path, {}));
    FAIL() << "three columns of volts";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("2 \"rec1.AI 1\" [V], 3 \"rec1.AI 2\" [V]"), std::string::npos)
        << error.what();
  }
}

TEST(NamedSignals, OfSimulinkHaveTheirLabels) {
  const test::TemporaryFolder folder;
  const auto path =
      written(folder, "ScopeData", "time", number_array(time_signal()), "signals",
              signal_array({"label", "title", "values"}, {{"u_V", "", valve_signal()}, {"x_mm", "", rod_signal()}}));
  const Imported imported = import_record(path, {});
  EXPECT_EQ(imported.record.input_channel.unit, "V") << imported.guess;
  EXPECT_EQ(imported.record.output_channel.unit, "mm");
}

TEST(NamedSignals, OfOneNameAreToldApartInTheRecord) {
  const test::TemporaryFolder folder;
  const std::array<const char*, 3> fields{"Other", "Text", "Data"};
  const auto path = written(folder, "rec1", "X", signal_array(fields, {{"", "", time_signal()}}), "Y",
                            signal_array(fields, {{"", "", valve_signal()}, {"", "", rod_signal()}}));
  const Imported imported = import_record(path, {.time = "1", .input = "2", .output = "3"});
  EXPECT_NE(imported.record.input_channel.name, imported.record.output_channel.name);
}

}  // namespace
}  // namespace eha::importer
