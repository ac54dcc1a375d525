// SPDX-License-Identifier: GPL-3.0-or-later
// `eha export` as a user meets it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

constexpr const char* kWhole = R"({"name": "io", "transfer_function": {"numerator": [{"coefficient": 0.13, "order": 0}],
  "denominator": [{"coefficient": 0.013, "order": 2}, {"coefficient": 1, "order": 1}, {"coefficient": 0.0028, "order": 0}]},
  "input_map": {"kind": "valve", "null": -0.2, "dead_band": 0.15, "negative_gain_ratio": 0.88}, "initial_output": 2.9})";
constexpr const char* kFractional =
    R"({"name": "fo", "transfer_function": {"numerator": [{"coefficient": 0.46, "order": 0}],
  "denominator": [{"coefficient": 0.61, "order": 1.75}, {"coefficient": 1, "order": 0.9}, {"coefficient": 0.04, "order": 0}]},
  "input_bias": 0.25, "initial_output": 3.8})";

std::vector<double> numbers(const std::string& text, char separator) {
  std::vector<double> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == 't') continue;
    values.push_back(std::stod(line.substr(line.rfind(separator) + 1)));
  }
  return values;
}

TEST(ExportCommand, GivesPythonWhatSimulateGives) {
  std::string python;
  for (const char* program : {"python3", "/usr/bin/python3"}) {
    if (python.empty() && output_of_shell(std::string(program) + " -c 'import numpy; print(1)' 2>/dev/null") == "1\n") {
      python = program;
    }
  }
  if (python.empty()) GTEST_SKIP() << "python3-numpy is not installed";
  const TemporaryFolder folder;
  std::string input = "time_s,voltage_V\n";
  for (int k = 0; k < 1000; ++k) input += fmt::format("{:.3f},{:.6f}\n", 0.01 * k, 2.0 * std::cos(0.07 * k) + 0.4);
  folder.write("u.csv", input);
  for (const auto& [name, content, allowed] : {std::tuple{"io", kWhole, 1e-9}, std::tuple{"fo", kFractional, 0.01}}) {
    folder.write(fmt::format("{}.json", name), content);
    const Ended exported = run_eha({"export", fmt::format("{}.json", name), "--format", "python", "-o",
                                    fmt::format("eha_{}.py", name), "--band", "0.01:10"},
                                   folder.path());
    ASSERT_EQ(exported.code, 0) << exported.err;
    const Ended simulated = run_eha({"simulate", fmt::format("{}.json", name), "u.csv"}, folder.path());
    const std::vector<double> wanted = numbers(simulated.out, ',');
    const std::vector<double> found =
        numbers(output_of_shell(fmt::format(
                    "cd '{0}' && {1} -c 'from eha_{2} import eha_{2}; import numpy as np; u = np.loadtxt(\"u.csv\", "
                    "delimiter=\",\", skiprows=1)[:, 1]; [print(repr(float(y))) for y in eha_{2}(u, 0.01)]'",
                    folder.path().string(), python, name)),
                ' ');
    ASSERT_EQ(found.size(), wanted.size()) << name;
    for (std::size_t k = 0; k < found.size(); ++k) ASSERT_NEAR(found[k], wanted[k], allowed * 10.0) << name << " " << k;
  }
}

TEST(ExportCommand, WritesJsonWithTheStatedError) {
  const TemporaryFolder folder;
  folder.write("fo.json", kFractional);
  const Ended ended = run_eha({"export", "fo.json", "--format", "json"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_LE(document.at("approximation").at("gain_percent").get<double>(), 1.0);
  EXPECT_LE(document.at("approximation").at("phase_deg").get<double>(), 1.0);
  EXPECT_EQ(document.at("state_space").at("A").size(), document.at("state_space").at("B").size());
  EXPECT_EQ(document.at("fomcon"), "fotf([0.61 1 0.04], [1.75 0.9 0], [0.46], [0], 0)");
}

TEST(ExportCommand, WritesARecordInEveryForm) {
  const TemporaryFolder folder;
  folder.write("r.csv", "time_s,voltage_V,displacement_in\n0,0.5,2.951\n0.001,0.51,2.9525\n0.002,0.5,3\n");
  const Ended csv = run_eha({"export", "r.csv", "--format", "csv"}, folder.path());
  ASSERT_EQ(csv.code, 0) << csv.err;
  EXPECT_EQ(csv.out, "time_s,voltage_V,displacement_in\n0,0.5,2.951\n0.001,0.51,2.9525\n0.002,0.5,3\n");
  const Ended metric = run_eha({"export", "r.csv", "--format", "csv", "--units", "mm"}, folder.path());
  EXPECT_EQ(metric.out.substr(0, metric.out.find('\n')), "time_s,voltage_V,displacement_mm") << metric.out;
  EXPECT_NE(metric.out.find("0.002,0.5,76.2"), std::string::npos) << metric.out;
  for (const char* file : {"r.mat", "r.h5"}) {
    const std::string format = std::string(file) == "r.mat" ? "mat" : "hdf5";
    const Ended ended = run_eha({"export", "r.csv", "--format", format, "-o", file}, folder.path());
    ASSERT_EQ(ended.code, 0) << ended.err;
    if (output_of_shell("command -v octave-cli").empty()) continue;
    EXPECT_EQ(output_of_shell(fmt::format("cd '{}' && octave-cli --no-init-file --eval \"s = load('{}'); "
                                          "printf('%g %g %g %g', s.time_s(3), s.voltage_V(2), s.displacement_in(2), "
                                          "s.sample_period_s)\"",
                                          folder.path().string(), file)),
              "0.002 0.51 2.9525 0.001")
        << file;
  }
}

TEST(ExportCommand, RefusesAFileThatOctaveCannotCall) {
  const TemporaryFolder folder;
  folder.write("io.json", kWhole);
  for (const auto& [file, callable] : {std::pair{"my-plant.m", "my_plant.m"}, {"2plant.m", "model_2plant.m"}}) {
    const Ended ended = run_eha({"export", "io.json", "--format", "octave", "-o", file}, folder.path());
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_NE(ended.err.find(fmt::format("-o {}\n", callable)), std::string::npos) << ended.err;
    EXPECT_EQ(run_eha({"export", "io.json", "--format", "octave", "-o", callable}, folder.path()).code, 0);
    EXPECT_EQ(run_eha({"export", "io.json", "--format", "json", "-o", file}, folder.path()).code, 0);
  }
}

TEST(ExportCommand, RefusesWhatHasNoForm) {
  const TemporaryFolder folder;
  folder.write("io.json", kWhole);
  folder.write("r.csv", "time_s,voltage_V,displacement_in\n0,0.5,2.951\n0.001,0.51,2.9525\n");
  expect_refused(folder, {"export", "io.json"}, ExitCode::usage, {"--format"});
  expect_refused(folder, {"export", "io.json", "--format", "excel"}, ExitCode::usage, {"excel", "octave"});
  expect_refused(folder, {"export", "io.json", "--format", "c", "--band", "5:1"}, ExitCode::usage, {"LOW:HIGH"});
  expect_refused(folder, {"export", "r.csv", "--format", "mat"}, ExitCode::usage, {"-o NAME.mat"});
  expect_refused(folder, {"export", "r.csv", "--format", "octave"}, ExitCode::configuration, {"r.csv"});
  expect_refused(folder, {"export", ".", "--format", "octave"}, ExitCode::usage, {"name one of ./*.json"});
  folder.write("bad.json", R"({"transfer_function": {"numerator": [{"coefficient": 1, "order": 0}],
    "denominator": [{"coefficient": 1, "order": 1.8}, {"coefficient": -1, "order": 0.9}, {"coefficient": 1, "order": 0}]}})");
  expect_refused(folder, {"export", "bad.json", "--format", "c"}, ExitCode::configuration, {"bad.json", "unstable"});
}

}  // namespace
}  // namespace eha::test
