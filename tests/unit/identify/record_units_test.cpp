// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/record_units.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "ident/model/model_output.hpp"

namespace eha::identify {
namespace {

Source source_in(const std::string& input, const std::string& output) {
  Source source;
  source.name = "record.csv";
  source.record.step_s = 0.1;
  source.record.input = Eigen::VectorXd::LinSpaced(20, 0.0, 2.0);
  source.record.input_channel.unit = input;
  source.record.output = source.record.input;
  source.record.output_channel.unit = output;
  return source;
}

ident::Model model_in_inches() {
  ident::Model model;
  model.transfer_function = {{{0.5, 0.0}}, {{1.0, 1.0}, {0.2, 0.0}}, 0.0};
  model.initial_output = 3.0;
  return model;
}

TEST(RecordUnits, ConvertALength) {
  const ident::Model model = model_in_inches();
  const Source source = source_in("V", "mm");
  const ident::Model converted = in_units_of(source, model, "model.json");
  EXPECT_EQ(converted.output_unit, "mm");
  const Eigen::VectorXd inches = ident::simulate(model, source.record.input, source.record.step_s);
  const Eigen::VectorXd millimetres = ident::simulate(converted, source.record.input, source.record.step_s);
  EXPECT_LT((millimetres - 25.4 * inches).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RecordUnits, KeepAModelWhoseUnitTheRecordHasOrDoesNotName) {
  EXPECT_EQ(in_units_of(source_in("V", "in"), model_in_inches(), "model.json").initial_output, 3.0);
  EXPECT_EQ(in_units_of(source_in("", ""), model_in_inches(), "model.json").initial_output, 3.0);
  EXPECT_EQ(unit_taken_as_same(source_in("V", "mm"), model_in_inches()), "");
  const std::string same = unit_taken_as_same(source_in("V", ""), model_in_inches());
  EXPECT_NE(same.find("say so with --output-unit"), std::string::npos) << same;
}

TEST(RecordUnits, ConvertMillivoltsAndMicrometres) {
  ident::Model model = model_in_inches();
  model.input_bias = 0.1;
  Source source = source_in("mV", "um");
  source.record.input *= 1000.0;
  const ident::Model converted = in_units_of(source, model, "model.json");
  EXPECT_EQ(converted.input_unit, "mV");
  EXPECT_EQ(converted.output_unit, "um");
  const Eigen::VectorXd inches = ident::simulate(model, source.record.input / 1000.0, source.record.step_s);
  const Eigen::VectorXd micrometres = ident::simulate(converted, source.record.input, source.record.step_s);
  EXPECT_LT((micrometres - 25400.0 * inches).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(RecordUnits, ConvertModelsAndRecordsToTheFirst) {
  ident::Model other = model_in_inches();
  other.input_unit = "mV";
  other.output_unit = "mm";
  const auto models = in_units_of_first(std::vector{model_in_inches(), other}, {"a.json", "b.json"});
  EXPECT_EQ(models[1].input_unit, "V");
  EXPECT_NEAR(models[1].transfer_function.numerator[0].coefficient, 0.5 * 1000.0 / 25.4, 1e-9);
  other.output_unit = "bar";
  EXPECT_THROW(static_cast<void>(in_units_of_first(std::vector{model_in_inches(), other}, {"a.json", "b.json"})),
               DataError);
  const auto sources = in_units_of_first(std::vector{source_in("V", "in"), source_in("mV", "mm")});
  EXPECT_NEAR(sources[1].record.input[19], 0.002, 1e-12);
  EXPECT_EQ(sources[1].record.output_channel.unit, "in");
}

TEST(RecordUnits, RefuseWhatIsOfAnotherKind) {
  EXPECT_THROW(static_cast<void>(in_units_of(source_in("V", "bar"), model_in_inches(), "model.json")), DataError);
  EXPECT_THROW(static_cast<void>(in_units_of(source_in("mA", "in"), model_in_inches(), "model.json")), DataError);
  try {
    static_cast<void>(in_units_of(source_in("V", "bar"), model_in_inches(), "model.json"));
  } catch (const DataError& error) {
    EXPECT_STREQ(
        error.what(),
        "model.json is a model from V to in, and record.csv is a record in V and bar; expected the same units, "
        "or such as can be converted: lengths, volts and mV, A and mA");
  }
}

}  // namespace
}  // namespace eha::identify
