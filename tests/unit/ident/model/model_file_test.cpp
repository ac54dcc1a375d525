// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/model_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace eha::ident {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const char* const kMinimal = R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
 "denominator": [{"coefficient": 2, "order": 1.5}, {"coefficient": 1, "order": 0}]}})";

Model full_model() {
  Model model;
  model.name = "fo";
  model.transfer_function = {{{0.46, 0.0}}, {{0.61, 1.75}, {1.0, 0.9}, {0.04, 0.0}}, 0.016};
  model.input_bias = 0.25;
  model.initial_output = 3.8;
  model.initial_state = {0.1, -1.0 / 3.0};
  model.past_input = {{-0.5, 0.0, 1.0 / 3.0}, {-1.0, -0.5, -2.0}};
  model.parameters = {{"a2", 0.61, 0.01, 0.59, 0.63, false}, {"n0", 0.0, 0.0, 0.0, 0.0, true}};
  model.estimation = EstimationReport{
      {99.5, 1e-4, 93.0, 0.0, 0.0, 500},
      InformationCriteria{7, 66.5, -601.0, -599.5, -585.0, 1.2e-4, -3400.5, 1, 490, "0123456789abcdef", {{"n2", 40.5}}},
      ParameterCorrelation{{"a2", "n2"}, {{1.0, -0.3}, {-0.3, 1.0}}, {"n2"}},
      27,
      0.4,
      "converged",
      true,
      0.04,
      ResidualNoise{1e-4, 7.5e-5, {0.5}, {1.0, 0.5}, true},
      std::pair(-1.5, 2.0)};
  model.structure = StructureOptions{.name = "fo", .structure = structures::fo()};
  ValidationReport validation;
  validation.score = {99.1, 2e-4, 90.5, -0.03, 0.04, 500};
  validation.offset_reestimated = Score{99.2, 1.9e-4, 91.0, -0.02, 0.03, 500};
  validation.acf = {{0, 1}, {1.0, 0.5}, 0.0877, 0.115};
  validation.ccf = {{-1, 0, 1}, {0.1, 0.2, 0.3}, 0.2, 0.25};
  validation.ljung_box_p = 1e-17;
  validation.tests = ResidualTests{2, {20.5, 21, 0.49}, {40.5, 18, 0.0018}};
  validation.tests->nonlinearity =
      NonlinearityTest{{80.5, 30, 1e-6}, NonlinearKind::level, GainTrend::falls, NonlinearKind::position};
  validation.tests->future_input = ResidualTest{8.5, 10, 0.58};
  validation.tests->error = PredictedError{1.5, 3.5};
  validation.extrapolated_percent = 1.5;
  validation.excitation_order = 6;
  validation.input_levels = InputLevels{-1.5, 2.0};
  validation.map_error = 0.015;
  validation.end_stop = EndStop{5.9, 12.5, 11.0, OtherStop{0.1, 30.5}, 13.5, 30.25};
  model.validation = validation;
  model.stability = StabilityReport{true, "argument_principle", 0.3};
  model.verdict = Verdict{true,
                          {"The residual is not white."},
                          Grade::usable,
                          {{CriterionKind::r2, "validation", 99.1, 90.0, true},
                           {CriterionKind::residual_whiteness, "", 1e-3, 0.01, false},
                           {CriterionKind::error_over_noise, "", kNan, 3.0, false, false},
                           {CriterionKind::order_error, "n2", 0.1, 0.15, true},
                           {CriterionKind::other, "of_tomorrow", 1.0, 2.0, true}},
                          FrequencyInterval{0.05, 0.65},
                          true,
                          true,
                          "usable",
                          "io1",
                          1.25};
  model.procedure = "paper";
  model.provenance = {{"normalisation", "a1 = 1"}, {"seed", "1"}};
  return model;
}

std::string message_of(const std::string& text, const std::string& file_name = "m.json") {
  try {
    (void)model_from_text(text, file_name);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ModelFile, HoldsTheDocumentedKeysInTheDocumentedOrder) {
  const auto json = nlohmann::ordered_json::parse(to_text(full_model()));
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys,
            (std::vector<std::string>{"schema", "name", "transfer_function", "structure", "input_bias",
                                      "initial_output", "initial_state", "past_input", "units", "parameters",
                                      "estimation", "validation", "stability", "verdict", "procedure", "provenance"}));
  EXPECT_EQ(json["schema"], "eha-model/1");
  EXPECT_EQ(json["transfer_function"]["denominator"][0]["order"], 1.75);
  EXPECT_EQ(json["units"], (nlohmann::ordered_json{{"input", "V"}, {"output", "in"}, {"time", "s"}}));
  EXPECT_EQ(json["validation"]["ccf"]["lags"], (std::vector<int>{-1, 0, 1}));
  EXPECT_EQ(json["validation"]["acf"]["bound99"], 0.115);
}

TEST(ModelFile, ReadsBackWhatItWrote) {
  const Model model = full_model();
  const Model read = model_from_text(to_text(model), "x.json");
  EXPECT_EQ(to_text(read), to_text(model));
  EXPECT_EQ(read.name, "fo");
  EXPECT_EQ(read.transfer_function.delay_s, 0.016);
  EXPECT_EQ(read.initial_state, model.initial_state);
  EXPECT_EQ(read.past_input.at(1).to_s, -0.5);
  EXPECT_TRUE(read.parameters.at(1).fixed);
  EXPECT_EQ(read.validation->offset_reestimated->samples, 500U);
  EXPECT_EQ(read.provenance, model.provenance);
  EXPECT_EQ(read.procedure, "paper");
  EXPECT_EQ(read.verdict->grade, Grade::usable);
  EXPECT_EQ(name_of(read.verdict->criteria.at(0)), "validation_r2_percent");
  EXPECT_EQ(read.verdict->criteria.at(0).kind, CriterionKind::r2);
  EXPECT_EQ(read.verdict->criteria.at(1).kind, CriterionKind::residual_whiteness);
  EXPECT_EQ(read.verdict->criteria.at(3).kind, CriterionKind::order_error);
  EXPECT_EQ(read.verdict->criteria.at(3).parameter, "n2");
  EXPECT_EQ(name_of(read.verdict->criteria.at(4)), "of_tomorrow");
  EXPECT_FALSE(read.verdict->criteria.at(1).passed);
  EXPECT_TRUE(read.verdict->criteria.at(1).judged);
  EXPECT_FALSE(read.verdict->criteria.at(2).judged);
  EXPECT_EQ(read.verdict->usable_band->highest_Hz, 0.65);
  EXPECT_TRUE(read.verdict->beside_ladder);
  EXPECT_TRUE(read.verdict->judging_part_rests);
  EXPECT_EQ(read.verdict->word, "usable");
  EXPECT_EQ(read.verdict->explained_by, "io1");
  EXPECT_EQ(read.verdict->error_over_recommended, 1.25);
  EXPECT_EQ(read.estimation->information->left_out.at(0).rise, 40.5);
  EXPECT_EQ(read.validation->tests->whiteness.degrees, 18U);
  EXPECT_EQ(read.validation->map_error, 0.015);
  EXPECT_EQ(read.validation->end_stop->other->from_s, 30.5);
  EXPECT_EQ(read.estimation->compared_step_s, 0.04);
  EXPECT_EQ(read.estimation->input_range, std::pair(-1.5, 2.0));
  EXPECT_EQ(read.estimation->noise->coefficients, std::vector<double>{0.5});
  EXPECT_TRUE(read.estimation->noise->with_parameters);
}

/// Structures of every kind: each family, forms that no family has, a map, requests.
std::vector<StructureOptions> many_structures() {
  std::vector<StructureOptions> all;
  for (const StructureFamily& family : structure_families()) {
    all.push_back({.name = std::string(family.name), .structure = family.make(Degrees{3, 1})});
  }
  all.push_back({.name = "io3", .structure = structures::io3(1)});
  all.push_back({.name = "integrator_lag", .structure = structures::integrator_lag()});
  all.back().structure.denominator.pop_back();
  all.push_back({.name = "terms",
                 .structure = structure_of_terms({.numerator = {{0.5}, {0.0}},
                                                  .denominator = {{2.1, true, {}, {}, 2.5}, {1.0}, {0.0, false, 0.4}}}),
                 .initial_state = InitialState::none});
  all.push_back({.name = "fo_valve",
                 .structure = structures::behind_valve(structures::fo()),
                 .initial_state = InitialState::estimated,
                 .parameters = {{"b0", false, 0.1, 0.0, 0.5}, {"delay_s", true, 0.02, {}, {}}}});
  all.back().structure.delay.freedom = Freedom::free;
  return all;
}

TEST(ModelFile, HoldsTheStructureThatWasFitted) {
  for (const StructureOptions& asked : many_structures()) {
    Model model = full_model();
    model.name = asked.name;
    model.structure = asked;
    const StructureOptions read = model_from_text(to_text(model), "x.json").structure.value();
    EXPECT_EQ(read.name, asked.name);
    EXPECT_EQ(read.structure.family, asked.structure.family);
    EXPECT_EQ(read.structure.formula, asked.structure.formula);
    EXPECT_EQ(read.structure.numerator, asked.structure.numerator) << asked.name;
    EXPECT_EQ(read.structure.denominator, asked.structure.denominator) << asked.name;
    EXPECT_EQ(read.structure.base_order, asked.structure.base_order);
    EXPECT_EQ(read.structure.delay, asked.structure.delay);
    EXPECT_EQ(read.structure.input_map.bias, asked.structure.input_map.bias);
    EXPECT_EQ(read.structure.input_map.valve.has_value(), asked.structure.input_map.valve.has_value());
    EXPECT_EQ(read.structure.degrees.has_value(), asked.structure.degrees.has_value());
    EXPECT_EQ(read.initial_state, asked.initial_state);
    ASSERT_EQ(read.parameters.size(), asked.parameters.size());
    for (std::size_t k = 0; k < read.parameters.size(); ++k) {
      EXPECT_EQ(read.parameters[k].name, asked.parameters[k].name);
      EXPECT_EQ(read.parameters[k].fixed, asked.parameters[k].fixed);
      EXPECT_EQ(read.parameters[k].upper, asked.parameters[k].upper);
    }
  }
}

/// What is read of a file of a version that wrote neither structure nor compared step nor noise.
Model earlier(Model model) {
  model.structure.reset();
  if (model.estimation) {
    model.estimation->compared_step_s.reset();
    model.estimation->noise.reset();
  }
  return model_from_text(to_text(model), "x.json");
}

TEST(ModelFile, GuessesTheStructureOfAnEarlierFile) {
  struct Case {
    const char* name;
    TransferFunction g;
    const char* family;
    std::size_t denominator_terms;
  };
  for (const Case& one : {Case{"fo_valve", {{{1, 0}}, {{1, 1.8}, {1, 0.9}, {1, 0}}}, "fo", 3},
                          Case{"mine", {{{1, 0}}, {{1, 1.8}, {1, 0.9}, {1, 0}}}, "fo", 3},
                          Case{"mine", {{{1, 0}}, {{1, 0.9}, {1, 0}}}, "lag", 2},
                          Case{"mine", {{{1, 1}, {1, 0}}, {{1, 3}, {1, 2}, {1, 1}, {1, 0}}}, "io", 4},
                          Case{"io1", {{{1, 0}}, {{1, 1}, {1, 0}}}, "io1", 2},
                          Case{"io3", {{{1, 1}, {1, 0}}, {{1, 3}, {1, 2}, {1, 1}, {1, 0}}}, "io", 4}}) {
    Model model;
    model.name = one.name;
    model.transfer_function = one.g;
    model.transfer_function.delay_s = 0.02;
    model.input_map = ValveMap{0.0, 0.1, 1.0};
    const StructureOptions guess = earlier(model).structure.value();
    EXPECT_EQ(guess.name, one.name);
    EXPECT_EQ(guess.structure.family, one.family);
    EXPECT_EQ(guess.structure.denominator.size(), one.denominator_terms);
    EXPECT_TRUE(guess.structure.input_map.valve);
    EXPECT_EQ(guess.structure.delay.value, 0.02);
    EXPECT_EQ(guess.structure.delay.freedom, Freedom::held);
  }
  Model other;
  other.transfer_function = {{{1, 0}}, {{1, 2.2}, {1, 1.5}, {1, 0.7}, {1, 0}}};
  EXPECT_FALSE(earlier(other).structure);
}

TEST(ModelFile, GuessesTheNoiseOfAnEarlierFile) {
  Model model = full_model();
  model.bode = BodeCurve{{0.01, 12.5}, {}, {}, {}, {}};
  model.estimation->score.mse = 4.0;
  model.validation->score.samples = 500;
  model.validation->acf = {};
  for (int lag = 0; lag <= 20; ++lag) {
    model.validation->acf.lags.push_back(lag);
    model.validation->acf.values.push_back(std::pow(0.9, lag));
  }
  const EstimationReport read = earlier(model).estimation.value();
  EXPECT_DOUBLE_EQ(read.compared_step_s.value(), 0.04);
  ASSERT_EQ(read.noise.value().coefficients.size(), 1U);
  EXPECT_NEAR(read.noise->coefficients[0], 0.9, 1e-12);
  EXPECT_NEAR(read.noise->variance, 4.0 * (1.0 - 0.81), 1e-12);
  EXPECT_EQ(read.noise->power, 4.0);
  EXPECT_FALSE(read.noise->with_parameters);
  model.provenance["noise_model"] = "autoregressive";
  EXPECT_TRUE(earlier(model).estimation->noise->with_parameters);
  model.validation.reset();
  EXPECT_FALSE(earlier(model).estimation->noise);
}

TEST(ModelFile, HoldsAnInputMapOrABiasButNotBoth) {
  Model model = full_model();
  EXPECT_FALSE(nlohmann::json::parse(to_text(model)).contains("input_map"));
  model.input_bias = 0.0;
  model.input_map = ValveMap{-0.2, 0.15, 0.88};
  const auto json = nlohmann::ordered_json::parse(to_text(model));
  EXPECT_EQ(
      json["input_map"],
      (nlohmann::ordered_json{{"kind", "valve"}, {"null", -0.2}, {"dead_band", 0.15}, {"negative_gain_ratio", 0.88}}));
  const Model read = model_from_text(to_text(model), "x.json");
  EXPECT_EQ(to_text(read), to_text(model));
  const auto with = [](const std::string& fields) { return std::string(kMinimal).insert(1, fields + ", "); };
  const std::string map = R"("input_map": {"kind": "valve", "null": 0, "dead_band": 0.1, "negative_gain_ratio": 1})";
  EXPECT_EQ(message_of(with(map)), "accepted");
  EXPECT_EQ(message_of(with(map + ", \"input_bias\": 0.5")),
            "m.json: input_bias: expected 0 beside input_map, got 0.5");
  EXPECT_EQ(message_of(with(R"("input_map": {"kind": "cubic"})")),
            "m.json: input_map.kind: expected \"valve\", got \"cubic\"");
  EXPECT_EQ(message_of(with(R"("input_map": {"kind": "valve", "null": 0})")),
            "m.json: input_map.dead_band: expected a value, got no such field");
  EXPECT_EQ(message_of(with(R"("input_map": {"kind": "valve", "null": 0, "dead_band": -1, "negative_gain_ratio": 1})")),
            "m.json: input_map.dead_band: expected at least 0, got -1");
}

TEST(ModelFile, RefusesAPastThatHasGapsOrLiesAhead) {
  const auto with_past = [](const std::string& windows) {
    std::string text = kMinimal;
    return text.insert(1, "\"past_input\": [" + windows + "], ");
  };
  const auto window = [](double from_s, double to_s) {
    return "{\"from_s\": " + std::to_string(from_s) + ", \"to_s\": " + std::to_string(to_s) + ", \"value\": 1}";
  };
  EXPECT_NO_THROW(static_cast<void>(model_from_text(with_past(window(-1, 0) + ", " + window(-3, -1)), "m.json")));
  for (const std::string& windows : {window(-1, 0.5), window(0, 0), window(-1, 0) + ", " + window(-3, -2)}) {
    EXPECT_THROW(static_cast<void>(model_from_text(with_past(windows), "m.json")), ConfigError) << windows;
  }
}

TEST(ModelFile, KeepsEveryBitOfEveryNumber) {
  std::mt19937_64 draw(20160301);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int i = 0; i < 2000; ++i) {
    Model model = full_model();
    const double value = std::ldexp(static_cast<double>(draw() >> 11U) + 1.0, exponent(draw));
    model.transfer_function.numerator[0].coefficient = -value;
    model.initial_output = value;
    const Model read = model_from_text(to_text(model), "x.json");
    ASSERT_EQ(read.transfer_function.numerator[0].coefficient, -value);
    ASSERT_EQ(read.initial_output, value);
  }
}

TEST(ModelFile, WritesNullForWhatIsNotFiniteAndReadsItAsNotANumber) {
  Model model = full_model();
  model.validation->score.r2_percent = -kInfinity;
  model.parameters[0].std = kNan;
  const std::string text = to_text(model);
  const auto json = nlohmann::json::parse(text);
  EXPECT_TRUE(json["validation"]["r2_percent"].is_null());
  EXPECT_TRUE(json["parameters"][0]["std"].is_null());
  EXPECT_TRUE(std::isnan(model_from_text(text, "x.json").parameters[0].std));
}

TEST(ModelFile, NeedsNothingButTheTransferFunction) {
  const Model model = model_from_text(kMinimal, "somewhere/lag.json");
  EXPECT_EQ(model.name, "lag");
  EXPECT_EQ(model.transfer_function.denominator.at(0).order, 1.5);
  EXPECT_EQ(model.transfer_function.delay_s, 0.0);
  EXPECT_EQ(model.input_bias, 0.0);
  EXPECT_EQ(model.input_unit, "V");
  EXPECT_FALSE(model.validation.has_value());
}

TEST(ModelFile, AcceptsEmptyCorrelations) {
  Model model = full_model();
  auto json = nlohmann::json::parse(to_text(model));
  json["validation"]["acf"] = nlohmann::json::object();
  EXPECT_TRUE(model_from_text(json.dump(), "x.json").validation->acf.lags.empty());
}

struct Fault {
  std::string pointer;  ///< JSON pointer of what is replaced
  std::string value;    ///< JSON text; empty removes the field
  std::string message;
};

/// Names the case in test listings.
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.pointer << " = " << fault.value; }

class FaultyModelFile : public testing::TestWithParam<Fault> {};

TEST_P(FaultyModelFile, IsRefusedNamingTheFileAndThePath) {
  auto json = nlohmann::json::parse(to_text(full_model()));
  const nlohmann::json::json_pointer pointer(GetParam().pointer);
  if (GetParam().value.empty()) {
    auto& parent = json[pointer.parent_pointer()];
    ASSERT_EQ(parent.erase(pointer.back()), 1U);
  } else {
    json[pointer] = nlohmann::json::parse(GetParam().value);
  }
  EXPECT_EQ(message_of(json.dump(2)), "m.json: " + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Each, FaultyModelFile,
    testing::Values(
        Fault{"/transfer_function", "", "transfer_function: expected a value, got no such field"},
        Fault{"/transfer_function/denominator", "",
              "transfer_function.denominator: expected a value, got no such field"},
        Fault{"/transfer_function/numerator/0/order", "",
              "transfer_function.numerator[0].order: expected a value, got no such field"},
        Fault{"/transfer_function/denominator/1/order", "-1",
              "transfer_function.denominator[1].order: expected an order of 0 to 100, got -1.000000"},
        Fault{"/transfer_function/denominator", R"([{"coefficient": 0, "order": 1}])",
              "transfer_function.denominator: expected a coefficient other than 0, all are 0"},
        Fault{"/transfer_function/denominator", "[]",
              "transfer_function.denominator: expected at least one term, got none"},
        Fault{"/transfer_function/numerator/0/coefficient", "\"0.46\"",
              "transfer_function.numerator[0].coefficient: expected a number, got \"0.46\""},
        Fault{"/transfer_function/numerator/0/coefficient", "null",
              "transfer_function.numerator[0].coefficient: expected a number, got null"},
        Fault{"/transfer_function/numerator", "3", "transfer_function.numerator: expected an array, got 3"},
        Fault{"/transfer_function", "[1]", "transfer_function: expected an object, got an array"},
        Fault{"/transfer_function/delay_s", "-0.1",
              "transfer_function.delay_s: expected a finite delay of at least 0 s"},
        Fault{"/transfer_function/delay", "1",
              "transfer_function.delay: expected a known field (did you mean \"delay_s\"?), got an unknown one"},
        Fault{"/input_bais", "1",
              "input_bais: expected a known field (did you mean \"input_bias\"?), got an unknown one"},
        Fault{"/schema", "\"eha-model/2\"", "schema: expected \"eha-model/1\", got \"eha-model/2\""},
        Fault{"/units/time", "\"ms\"", "units.time: expected \"s\", got \"ms\""},
        Fault{"/input_bias", "true", "input_bias: expected a number, got true"},
        Fault{"/initial_output", "null", "initial_output: expected a number, got null"},
        Fault{"/validation/acf/lags/1", "1.5", "validation.acf.lags[1]: expected a whole number, got 1.5"},
        Fault{"/validation/acf/lags/1", "1e300", "validation.acf.lags[1]: expected a whole number, got 1e+300"},
        Fault{"/validation/acf/values", "[1]", "validation.acf: expected as many values as lags, got 1 and 2"},
        Fault{"/estimation/samples", "-3", "estimation.samples: expected a whole number of at least 0, got -3"},
        Fault{"/structure/family", "", "structure.family: expected a value, got no such field"},
        Fault{"/structure/delay/freedom", "\"loose\"",
              "structure.delay.freedom: expected one of \"constant\", \"held\", \"free\", got \"loose\""},
        Fault{"/structure/denominator", "[]", "structure.denominator: expected 1 to 24 terms, got an array"},
        Fault{"/structure/denominator/1/order/lower", "4",
              "structure.denominator[1].order: expected lower at most upper, got an object"},
        Fault{"/estimation/compared_step_s", "0", "estimation.compared_step_s: expected more than 0, got 0"},
        Fault{"/estimation/input_range", "[2, 1]", "estimation.input_range: expected two rising values, got an array"},
        Fault{"/estimation/noise/coefficients", "[]",
              "estimation.noise: expected one autocorrelation more than coefficients, got 2 and 0"},
        Fault{"/verdict/reasons/0", "7", "verdict.reasons[0]: expected a string, got 7"},
        Fault{"/verdict/usable_band_Hz/0", "0.7",
              "verdict.usable_band_Hz: expected two rising frequencies above 0, got an array"},
        Fault{"/stability/stable", "\"yes\"", "stability.stable: expected true or false, got \"yes\""},
        Fault{"/parameters/0/name", "", "parameters[0].name: expected a value, got no such field"},
        Fault{"/provenance", "1", "provenance: expected an object, got 1"}));

TEST(ModelFile, NamesLineAndColumnOfASyntaxError) {
  EXPECT_EQ(message_of("{\n  \"name\": \"io\",\n  \"transfer_function\": ?\n}"),
            "m.json:3:24: expected a model in JSON, got a syntax error while parsing value - invalid literal");
  EXPECT_EQ(message_of(std::string(kMinimal).substr(0, 40)).rfind("m.json:1:41: expected a model in JSON", 0), 0U)
      << message_of(std::string(kMinimal).substr(0, 40));
}

TEST(ModelFile, RefusesWhatIsNoJsonObject) {
  EXPECT_EQ(message_of(""), "m.json: expected a model in JSON, got an empty file");
  EXPECT_EQ(message_of(" \n\n"), "m.json: expected a model in JSON, got an empty file");
  EXPECT_EQ(message_of(std::string("\x7f"
                                   "ELF\0\0",
                                   6)),
            "m.json: expected a model in JSON, got a binary file");
  EXPECT_EQ(message_of("[]"), "m.json: model: expected an object, got an array");
  EXPECT_NE(message_of("{\"name\": 1e999}"), "accepted");
}

TEST(ModelFile, SurvivesDeepNesting) {
  EXPECT_EQ(message_of(std::string(10'000'000, '[')), "m.json: expected a model at most 32 levels deep, got more");
  std::string objects;
  for (int i = 0; i < 1'000'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(message_of(objects), "m.json: expected a model at most 32 levels deep, got more");
}

TEST(ModelFile, SurvivesTenMegabytesOfGarbageWithAShortMessage) {
  std::mt19937_64 draw(7);
  std::string garbage(10'000'000, ' ');
  for (char& c : garbage) c = static_cast<char>(1 + draw() % 255);
  const std::string quoted = "{\"" + std::string(10'000'000, 'a') + "\xff";
  std::string keys = "{";
  for (int i = 0; i < 400'000; ++i) keys += "\"key" + std::to_string(i) + "\": 1,\n";
  keys += "\"last\": 1}";
  for (const std::string& text : {garbage, quoted, keys, "{\"" + std::string(10'000'000, 'k') + "\": 1}"}) {
    const std::string message = message_of(text);
    EXPECT_EQ(message.rfind("m.json:", 0), 0U);
    EXPECT_LT(message.size(), 600U) << message.substr(0, 1000);
  }
}

TEST(ModelFile, NeverCrashesOnAModelWithOneByteChanged) {
  const std::string text = to_text(full_model());
  int accepted = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char byte : {'\0', '"', '}', ']', '-', '9', 'e', '\xff'}) {
      std::string changed = text;
      changed[i] = byte;
      if (message_of(changed) == "accepted") ++accepted;
    }
  }
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace eha::ident
