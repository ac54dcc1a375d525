// SPDX-License-Identifier: GPL-3.0-or-later
// Records as other programs write them give the model that the record in eha's own format gives.
#include "tests/system/foreign_files.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "ident/excitation/portable_draw.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

constexpr std::size_t kRows = 1500;

std::string own_format(const Measured& record) {
  std::string text = "time_s,voltage_V,displacement_in\n";
  for (std::size_t k = 0; k < record.time_s.size(); ++k) {
    text += fmt::format("{},{},{}\n", record.time_s[k], record.input_V[k], record.output_in[k]);
  }
  return text;
}

/// The numbers of a fitted model: coefficients, bias, offset.
std::vector<double> numbers_of(const json& model) {
  std::vector<double> numbers;
  for (const char* part : {"numerator", "denominator"}) {
    for (const json& term : model.at("transfer_function").at(part)) numbers.push_back(term.at("coefficient"));
  }
  numbers.push_back(model.at("input_bias"));
  numbers.push_back(model.at("initial_output"));
  return numbers;
}

/// The command between the first back quotes of a message, without its `eha`.
std::string offered_command(const std::string& message) {
  const std::size_t begin = message.find("`eha ");
  if (begin == std::string::npos) return {};
  return message.substr(begin + 5, message.find('`', begin + 1) - begin - 5);
}

/// What `eha fit FILE` gives, or the command that its refusal offers.
json fitted(const std::string& file, const TemporaryFolder& folder, std::string& said) {
  Ended ended = run_eha({"fit", file, "--model", "io", "--poles", "1", "--json"}, folder.path());
  said = ended.err;
  if (ended.code == 10) {
    const std::string command = offered_command(ended.err);
    if (command.empty()) return {};
    ended.out = output_of_shell(fmt::format("cd '{}' && '{}' {} 2>&1", folder.path().string(), EHA_PROGRAM, command));
    said += ended.out.substr(0, ended.out.find('{'));
    ended.out.erase(0, ended.out.find('{'));
  }
  const json document = json::parse(ended.out, nullptr, false);
  return document.is_discarded() ? json() : document.at("models").at(0);
}

TEST(ForeignFiles, GiveTheSameModelOrAreRefusedWithACommandThatDoes) {
  const TemporaryFolder folder;
  const Measured record = measured(kRows);
  folder.write("own.csv", own_format(record));
  std::string said;
  const json own = fitted("own.csv", folder, said);
  EXPECT_EQ(said, "") << "a record in eha's own format needs no guess";
  const std::vector<double> expected = numbers_of(own);
  const std::vector<ForeignFile> files = write_foreign_files(record, folder.path());
  EXPECT_GE(files.size(), 20U);
  for (const ForeignFile& file : files) {
    SCOPED_TRACE(file.made_by + ": " + file.name);
    const json model = fitted(file.name, folder, said);
    ASSERT_FALSE(model.is_null()) << said;
    const std::vector<double> numbers = numbers_of(model);
    ASSERT_EQ(numbers.size(), expected.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      EXPECT_NEAR(numbers[i], expected[i], 1e-9 * std::max(1.0, std::abs(expected[i]))) << said;
    }
  }
}

TEST(ForeignFiles, AreWrittenAsRecordsThatReadBackToTheSameNumbers) {
  const TemporaryFolder folder;
  const Measured record = measured(kRows);
  static_cast<void>(write_foreign_files(record, folder.path()));
  for (const char* name : {"excel_de.csv", "struct73.mat", "datasets.h5"}) {
    const Ended ended = run_eha({"import", name, "-o", "record.csv", "--json"}, folder.path());
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(json::parse(ended.out).at("rows"), kRows);
    std::string written = content_of(folder.path() / "record.csv");
    written.erase(0, written.find('\n'));
    // Times are written with the same number of decimals, the rest as short as possible.
    std::string expected;
    for (std::size_t k = 0; k < kRows; ++k) {
      expected += fmt::format("\n{:.2f},{},{}", record.time_s[k], record.input_V[k], record.output_in[k]);
    }
    EXPECT_EQ(written, expected + "\n") << name;
  }
}

TEST(ForeignFiles, MaySelectATimeSpanAndColumnsByNameFieldAndNumber) {
  const TemporaryFolder folder;
  const Measured record = measured(kRows);
  static_cast<void>(write_foreign_files(record, folder.path()));
  const auto imported = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"import"};
    words.insert(words.end(), options.begin(), options.end());
    words.emplace_back("--json");
    const Ended ended = run_eha(words, folder.path());
    EXPECT_EQ(ended.code, 0) << ended.err;
    return ended.code == 0 ? json::parse(ended.out) : json();
  };
  json document = imported({"more_columns.csv", "--from", "2", "--to", "4"});
  EXPECT_EQ(document.at("rows"), 201);
  EXPECT_DOUBLE_EQ(document.at("start_s").get<double>(), 2.0);
  document = imported({"struct5.mat", "--time", "rec.t", "--input", "rec.y", "--output", "rec.u"});
  EXPECT_NEAR(document.at("input").at("min").get<double>(),
              *std::min_element(record.output_in.begin(), record.output_in.end()), 1e-12);
  document = imported({"more_columns.csv", "--input", "Pressure A [bar]", "--output", "4", "--period", "0.02"});
  EXPECT_EQ(document.at("input").at("unit"), "bar");
  EXPECT_DOUBLE_EQ(document.at("step_s").get<double>(), 0.02);
}

TEST(Resampling, ListsMarksAndCountsWhatItFills) {
  const TemporaryFolder folder;
  const Measured record = measured(kRows);
  std::string text = "time_s,voltage_V,displacement_in\n";
  for (std::size_t k = 0; k < kRows; ++k) {
    if (k >= 500 && k < 503) continue;
    const double jitter_s = k == 700 ? 0.003 : 0.0;
    text += fmt::format("{:.3f},{},{}\n", record.time_s[k] + jitter_s, record.input_V[k],
                        k == 900 ? "NaN" : fmt::format("{}", record.output_in[k]));
  }
  folder.write("gaps.csv", text);
  const Ended refused = run_eha({"fit", "gaps.csv"}, folder.path());
  EXPECT_EQ(refused.code, 10);
  EXPECT_NE(refused.err.find("gaps.csv:899: displacement_in: expected a finite number"), std::string::npos)
      << refused.err;
  EXPECT_NE(refused.err.find("`eha fit gaps.csv --resample`"), std::string::npos) << refused.err;
  const Ended ended = run_eha({"import", "gaps.csv", "--resample", "-o", "record.csv", "--json"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("rows"), kRows);
  EXPECT_EQ(document.at("filled_rows"), 4);
  EXPECT_EQ(document.at("repairs").size(), 3U);
  EXPECT_EQ(document.at("repairs").at(0), "gaps.csv:502: 5 to 5.02 s: nothing measured, 3 rows filled");
  const std::string written = content_of(folder.path() / "record.csv");
  EXPECT_EQ(written.substr(0, written.find('\n')), "time_s,voltage_V,displacement_in,filled");
  const double middle_V = 0.5 * (record.input_V[499] + record.input_V[503]);
  EXPECT_NE(written.find(fmt::format("\n5.01,{:.6g}", middle_V)), std::string::npos) << "the input is straight";
  // The marks are read back: the fit knows what was not measured.
  const Ended fit = run_eha({"fit", "record.csv", "--model", "io", "--poles", "1"}, folder.path());
  EXPECT_NE(fit.err.find("4 of 1500 rows (0.267 %) were not measured"), std::string::npos) << fit.err;
}

TEST(SimulatedInput, IsPickedByTheModelsUnitAndRefusedInAnother) {
  const TemporaryFolder folder;
  const Measured record = measured(kRows);
  folder.write("own.csv", own_format(record));
  ASSERT_NE(run_eha({"fit", "own.csv", "--model", "io", "--poles", "1", "-o", "m"}, folder.path()).code, 2);
  std::string more = "Time [s];Pressure [bar];Command [V];Rod [mm]\n";
  std::string other = "time_s,force_kN\n";
  for (std::size_t k = 0; k < kRows; ++k) {
    more += fmt::format("{};{};{};1\n", record.time_s[k], k % 5, record.input_V[k]);
    other += fmt::format("{},{}\n", record.time_s[k], record.input_V[k]);
  }
  folder.write("more.csv", more);
  folder.write("other.csv", other);
  const auto model = std::filesystem::exists(folder.path() / "m/io.json") ? "m/io.json" : "m/rejected/io.json";
  const Ended own = run_eha({"simulate", model, "own.csv"}, folder.path());
  const Ended picked = run_eha({"simulate", model, "more.csv"}, folder.path());
  EXPECT_EQ(own.code, 0) << own.err;
  EXPECT_EQ(picked.out, own.out);
  const Ended refused = run_eha({"simulate", model, "other.csv", "-o", "out.csv"}, folder.path());
  EXPECT_EQ(refused.code, 10);
  EXPECT_NE(refused.err.find("is in kN, the model's input is in V"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.csv"));
}

/// Every 40th row of a lag of 0.3 s that is driven by tones every millisecond.
std::string every_40th_row() {
  const double decay = std::exp(-0.001 / 0.3);
  std::string text = "time_s,voltage_V,displacement_mm\n";
  double y = 0.0;
  for (int k = 0; k < 40'000; ++k) {
    const double t = 2.0 * std::numbers::pi * 0.001 * k;
    const double u = 2.0 * std::cos(0.11 * t) + 1.5 * std::sin(0.37 * t) + std::cos(0.83 * t);
    // A converter's steps.
    if (k % 40 == 0) text += fmt::format("{:.2f},{:.6f},{:.3f}\n", 0.001 * k, u, y);
    y = decay * y + (1.0 - decay) * 20.0 * u;
  }
  return text;
}

TEST(SampledInput, IsNoticedAndTakenAsStraightLines) {
  const TemporaryFolder folder;
  folder.write("r.csv", every_40th_row());
  std::vector<std::string> words{"fit", "r.csv", "--model", "io", "--poles", "1", "--json"};
  const auto lag_s = [](const nlohmann::json& document) {
    return document.at("models").at(0).at("transfer_function").at("denominator").at(0).at("coefficient").get<double>() /
           document.at("models").at(0).at("transfer_function").at("denominator").at(1).at("coefficient").get<double>();
  };
  const Ended straight = run_eha(words, folder.path());
  EXPECT_NE(straight.err.find("it is taken so (--intersample zoh: as held)"), std::string::npos) << straight.err;
  const auto document = nlohmann::json::parse(straight.out);
  EXPECT_NEAR(lag_s(document), 0.3, 0.002);
  EXPECT_EQ(document.at("models").at(0).at("provenance").at("intersample"),
            "straight (foh): 8 rows for each of the record's");
  words.insert(words.end(), {"--intersample", "zoh"});
  const Ended held = run_eha(words, folder.path());
  EXPECT_NE(held.err.find("within half a row the input moves by"), std::string::npos) << held.err;
  EXPECT_NE(held.err.find("--intersample foh"), std::string::npos) << held.err;
  EXPECT_GT(std::abs(lag_s(nlohmann::json::parse(held.out)) - 0.3), 0.01) << "half a row of delay is somewhere";
}

/// Every 40th row of an integrator with a lag of 40 ms and a dead time of 15 ms, driven by tones every millisecond.
std::string every_40th_row_behind_a_dead_time() {
  ident::PortableDraw draw(3);
  const double decay = std::exp(-0.001 / 0.04);
  std::string text = "time_s,voltage_V,displacement_mm\n";
  double y = 0.0;
  double speed = 0.0;
  const auto volts = [](int k) {
    const double t = 2.0 * std::numbers::pi * 0.001 * k;
    return k < 0 ? 0.0 : 2.0 * std::sin(0.11 * t) + 1.5 * std::sin(0.53 * t) + std::sin(2.3 * t);
  };
  for (int k = 0; k < 40'000; ++k) {
    if (k % 40 == 0) text += fmt::format("{:.2f},{:.6f},{:.4f}\n", 0.001 * k, volts(k), y + 0.02 * draw.normal());
    y += 0.001 * speed;
    speed = decay * speed + (1.0 - decay) * 12.0 * volts(k - 15);
  }
  return text;
}

TEST(SampledInput, IsNoticedWhereALagHasTakenTheDeadTime) {
  const TemporaryFolder folder;
  folder.write("r.csv", every_40th_row_behind_a_dead_time());
  const Ended held = run_eha({"fit", "r.csv", "--model", "integrator_lag", "--json"}, folder.path());
  EXPECT_NE(held.err.find("--intersample foh"), std::string::npos) << held.err;
}

TEST(ForeignFiles, WithAGapAreCutBehindItByTheNextStep) {
  const TemporaryFolder folder;
  Measured record = measured(kRows);
  std::string text = "time_s,voltage_V,displacement_in\n";
  const auto gap = [&](std::size_t k) { return k >= 500 && k < 560; };
  for (std::size_t k = 0; k < kRows; ++k) {
    if (!gap(k)) text += fmt::format("{},{},{}\n", record.time_s[k], record.input_V[k], record.output_in[k]);
  }
  folder.write("gap.csv", text);
  const Ended ended = run_eha({"fit", "gap.csv", "--resample", "--model", "io"}, folder.path());
  EXPECT_EQ(ended.code, 3) << ended.out << ended.err;
  const std::string next =
      fmt::format("Next: eha fit gap.csv --resample --model io --from {:.6g} -o models", record.time_s[560]);
  EXPECT_NE((ended.out + ended.err).find(next), std::string::npos) << ended.out << ended.err;
}

}  // namespace
}  // namespace eha::test
