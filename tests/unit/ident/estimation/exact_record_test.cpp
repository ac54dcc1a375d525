// SPDX-License-Identifier: GPL-3.0-or-later
// Fits of records whose truth another program computed. Minutes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/identify/thread_executor.hpp"
#include "daemon/importer/import.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "tests/unit/shared_data.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::ident {
namespace {

constexpr int kSeeds = 50;
constexpr double kNoiseShare = 0.01;

struct System {
  std::string name;
  std::string arguments;  ///< of exact_record.py
  bool delay_free = false;
  bool numerator_order_free = false;
};

const std::vector<System>& systems() {
  static const std::vector<System> all = {
      {"base", "--num 0.6:0 --den 0.8:1.75 1.3:0.9 0.05:0"},
      {"bias_and_position", "--num 0.6:0 --den 0.8:1.75 1.3:0.9 0.05:0 --bias 0.2 --start 3.9"},
      {"slow", "--num 1:0 --den 14994:1.31 6009.5:0.97 1.69:0"},
      {"oscillating", "--num 1:0 --den 0.8:2.2 0.5:0.9 1:0"},
      {"stiff", "--num 1:0 --den 0.02:1.6 1:0.8 0.5:0"},
      {"non_commensurate", "--num 0.5:0 --den 0.3:1.63 1:0.71 0.4:0 --bias -0.1 --start 1"},
      {"near_integrating", "--num 0.25:0 --den 0.15:1.9 1:0.98 0.002:0 --bias 0.2 --start 2.9"},
      {"delay", "--num 0.6:0 --den 0.8:1.75 1.3:0.9 0.05:0 --delay 0.0337", true, false},
      {"numerator_order", "--num 0.6:0.25 --den 0.8:1.75 1.3:0.9 0.3:0", false, true},
      {"integer_orders", "--num 1:0 --den 0.5:2 1:1 0.4:0"}};
  return all;
}

struct Exact {
  Record record;
  std::vector<std::pair<std::string, double>> truth;  ///< normalised, in the model file's names
};

double after(const std::string& arguments, const std::string& option) {
  const std::size_t at = arguments.find(option + " ");
  return at == std::string::npos ? 0.0 : std::stod(arguments.substr(at + option.size()));
}

std::vector<Term> terms_after(const std::string& arguments, const std::string& option) {
  std::vector<Term> terms;
  std::size_t at = arguments.find(option) + option.size();
  while (at < arguments.size() && arguments.compare(at, 3, " --") != 0) {
    std::size_t used = 0;
    const double coefficient = std::stod(arguments.substr(at), &used);
    at += used + 1;
    terms.push_back({coefficient, std::stod(arguments.substr(at), &used)});
    at += used;
  }
  return terms;
}

bool has_mpmath() { return std::system("/usr/bin/python3 -c 'import mpmath' 2>/dev/null") == 0; }

Exact exact_record(const System& system, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / (system.name + ".csv");
  const std::string command = "/usr/bin/python3 " + test::shared("tools/exact_record.py").string() + " " +
                              file.string() + " " + system.arguments + " >/dev/null";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
  Exact exact;
  exact.record = importer::import_record(file.string(), {}).record;
  const std::vector<Term> numerator = terms_after(system.arguments, "--num");
  const std::vector<Term> denominator = terms_after(system.arguments, "--den");
  const double a1 = denominator[1].coefficient;
  exact.truth = {{"a2", denominator[0].coefficient / a1},
                 {"n2", denominator[0].order},
                 {"n1", denominator[1].order},
                 {"a0", denominator[2].coefficient / a1},
                 {"K", numerator[0].coefficient / a1},
                 {"input_bias", after(system.arguments, "--bias")},
                 {"initial_output", after(system.arguments, "--start")}};
  if (system.delay_free) exact.truth.emplace_back("delay_s", after(system.arguments, "--delay"));
  if (system.numerator_order_free) exact.truth.emplace_back("b0", numerator[0].order);
  return exact;
}

/// The default procedure from its own starts, all of the record estimating.
Model fit_of(const System& system, const Record& record) {
  StructureOptions structure;
  structure.structure = structures::fo();
  structure.name = "fo";
  if (system.delay_free) structure.structure.delay.freedom = Freedom::free;
  if (system.numerator_order_free) structure.parameters.push_back({"b0", false, {}, {}, {}});
  FitOptions options;
  options.decimation = 40;
  options.split = 1.0;
  return fit(record, structure, options, identify::thread_executor()).model;
}

const ParameterEstimate& parameter(const Model& model, const std::string& name) {
  return *std::find_if(model.parameters.begin(), model.parameters.end(),
                       [&](const ParameterEstimate& p) { return p.name == name; });
}

class ExactRecord : public testing::TestWithParam<System> {};

TEST_P(ExactRecord, GivesItsTruthBack) {
  EHA_REQUIRE_SHARED(test::shared("tools/exact_record.py"));
  if (!has_mpmath()) GTEST_SKIP() << "tools/exact_record.py needs mpmath: apt-get install python3-mpmath";
  const test::TemporaryFolder folder;
  const Exact exact = exact_record(GetParam(), folder.path());
  const Model model = fit_of(GetParam(), exact.record);
  std::printf("%-18s", GetParam().name.c_str());
  for (const auto& [name, truth] : exact.truth) {
    const double error = parameter(model, name).value - truth;
    const bool is_order = name == "n2" || name == "n1" || name == "b0";
    const bool is_coefficient = name == "a2" || name == "a0" || name == "K";
    std::printf(" %s %.1e", name.c_str(), is_coefficient ? error / truth : error);
    EXPECT_LE(std::abs(error), is_order ? 2e-5 : (is_coefficient ? 1e-4 * std::abs(truth) : 1e-4)) << name;
  }
  std::printf("\n");
}

INSTANTIATE_TEST_SUITE_P(Systems, ExactRecord, testing::ValuesIn(systems()),
                         [](const auto& tested) { return tested.param.name; });

TEST(NoisyRecords, AreWithinThreeStandardErrorsOfTheirTruth) {
  EHA_REQUIRE_SHARED(test::shared("tools/exact_record.py"));
  if (!has_mpmath()) GTEST_SKIP() << "tools/exact_record.py needs mpmath: apt-get install python3-mpmath";
  const test::TemporaryFolder folder;
  int parameters = 0;
  int within = 0;
  for (const System& system : systems()) {
    const Exact exact = exact_record(system, folder.path());
    const Eigen::VectorXd& y = exact.record.output;
    const double level = kNoiseShare * std::sqrt((y.array() - y.mean()).square().mean());
    Record noisy = exact.record;
    int outside = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      PortableDraw draw(static_cast<std::uint64_t>(seed));
      for (Eigen::Index k = 0; k < y.size(); ++k) noisy.output[k] = y[k] + level * draw.normal();
      const Model model = fit_of(system, noisy);
      for (const auto& [name, truth] : exact.truth) {
        const ParameterEstimate& p = parameter(model, name);
        ++parameters;
        if (std::abs(p.value - truth) <= 3.0 * p.std) {
          ++within;
        } else {
          ++outside;
          std::printf("  %s seed %d: %s = %g, truth %g, std %g\n", system.name.c_str(), seed, name.c_str(), p.value,
                      truth, p.std);
        }
      }
    }
    std::printf("%-18s %d of %zu outside\n", system.name.c_str(), outside, kSeeds * exact.truth.size());
    std::fflush(stdout);
  }
  EXPECT_GE(within, 0.99 * parameters);
  std::printf("%.2f %% of %d within 3 standard errors\n", 100.0 * within / parameters, parameters);
}

}  // namespace
}  // namespace eha::ident
