// SPDX-License-Identifier: GPL-3.0-or-later
// Exported models against exact simulation: in this process, in Octave, in Python and in C.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/code_text.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "ident/export/model_formats.hpp"
#include "ident/export/vector_fitting.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/model_output.hpp"
#include "tests/unit/ident/synthetic_record.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::ident {
namespace {

using synthetic::uniform;

Eigen::VectorXd step_input(Eigen::Index rows) { return Eigen::VectorXd::Constant(rows, 1.5); }

double difference(const Model& model, const Eigen::VectorXd& input, double step_s) {
  const Eigen::VectorXd exact = simulate(model, input, step_s);
  const Eigen::VectorXd simulated = simulate(exported(model, {}), input, step_s);
  return (simulated - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
}

Model of(std::vector<Term> numerator, std::vector<Term> denominator, double delay_s = 0.0) {
  Model model;
  model.name = "model";
  model.transfer_function = {std::move(numerator), std::move(denominator), delay_s};
  model.input_bias = 0.2;
  model.initial_output = 2.5;
  return model;
}

std::vector<Model> models_of_whole_orders() {
  std::vector<Model> models{
      of({{0.13, 0}}, {{0.013, 2}, {1, 1}, {0.0028, 0}}),
      of({{0.13, 0}}, {{0.013, 2}, {1, 1}}),                 // an integrator
      of({{1, 0}}, {{1, 2}, {2, 1}, {1, 0}}),                // a double pole
      of({{1, 0}}, {{1, 3}, {3, 2}, {3, 1}, {1, 0}}),        // a triple pole
      of({{1, 0}}, {{1, 2}, {2.0002, 1}, {1.0002, 0}}),      // two almost equal poles
      of({{1, 0}}, {{1e-4, 2}, {4e-4, 1}, {1, 0}}, 0.0123),  // a resonance behind a delay
      of({{0.2, 1}, {1, 0}}, {{0.02, 3}, {0.3, 2}, {1, 1}, {0.1, 0}}, 0.04),
      of({{0.5, 1}, {1, 0}}, {{1, 1}, {2, 0}}, 0.0505),  // with a direct part
      of({{0.13, 0}}, {{1e-6, 2}, {1, 1}, {1e-4, 0}}),   // poles ten decades apart
      of({{3, 0}}, {{1, 0}}),                            // a gain alone
      of({{1, 0}}, {{0.1, 4}, {1, 3}, {4, 2}, {3, 1}}),
  };
  models[0].initial_state = {0.4};
  models[2].initial_state = {0.4, -0.3};
  models[6].input_map = ValveMap{-0.2, 0.15, 0.88};
  models[6].input_bias = 0.0;
  return models;
}

TEST(Export, OfWholeOrdersEqualsTheExactSimulation) {
  for (const Model& model : models_of_whole_orders()) {
    const std::string what = notes(exported(model, {}))[1];
    EXPECT_LT(difference(model, synthetic::excitation(0.04), 0.04), 1e-9) << what;
    EXPECT_LT(difference(model, synthetic::excitation(0.001), 0.001), 1e-9) << what;
    EXPECT_LT(difference(model, step_input(3000), 0.01), 1e-9) << what;
  }
}

TEST(Export, GivesTheTransferFunctionAsStateSpace) {
  for (const Model& model : models_of_whole_orders()) {
    const StateSpace s = state_space(exported(model, {}).sections);
    for (const double w : {0.01, 0.3, 7.0, 200.0}) {
      const std::complex<double> jw(0.0, w);
      TransferFunction g = model.transfer_function;
      g.delay_s = 0.0;
      const Eigen::MatrixXcd resolvent =
          (jw * Eigen::MatrixXcd::Identity(s.a.rows(), s.a.rows()) - s.a.cast<std::complex<double>>());
      std::complex<double> value = s.d;
      if (s.b.size() > 0) {
        value += (s.c.transpose().cast<std::complex<double>>() *
                  resolvent.partialPivLu().solve(s.b.cast<std::complex<double>>()))(0, 0);
      }
      const std::complex<double> exact = frequency_response(g, jw);
      EXPECT_LT(std::abs(value - exact), 1e-10 * std::abs(exact)) << notes(exported(model, {}))[1] << " at " << w;
    }
  }
}

/// Stable, with orders and corners as of plants of every kind.
Model random_fractional(std::mt19937_64& generator) {
  const auto between = [&](double a, double b) { return a + (b - a) * uniform(generator); };
  while (true) {
    const double n1 = between(0.4, 1.2);
    const double n2 = n1 + between(0.3, 1.2);
    const double corner = std::pow(10.0, between(-1.5, 1.5));
    Model model = of({{std::pow(10.0, between(-1, 1)), uniform(generator) < 0.3 ? between(0.0, 0.5) : 0.0}},
                     {{1.0 / std::pow(corner, n2 - n1), n2},
                      {1.0, n1},
                      {uniform(generator) < 0.2 ? 0.0 : std::pow(corner * std::pow(10.0, between(-3, 0)), n1), 0}});
    model.bode = BodeCurve{{0.02, 12.5}, {}, {}, {}, {}};
    if (uniform(generator) < 0.3) model.transfer_function.delay_s = between(0.0, 0.1);
    if (!grows(model.transfer_function)) return model;
  }
}

TEST(Export, OfFractionalOrdersKeepsTheStatedErrorOnTwentyRandomModels) {
  std::mt19937_64 generator(7);
  for (int i = 0; i < 20; ++i) {
    const Model model = random_fractional(generator);
    const ExportedModel out = exported(model, {});
    const std::string what = std::to_string(i) + ": " + notes(out)[1] + "\n" + notes(out)[4];
    ASSERT_TRUE(out.error) << what;
    EXPECT_LE(out.error->gain_percent, 1.0) << what;
    EXPECT_LE(out.error->phase_deg, 1.0) << what;
    // Frequencies between those that were fitted.
    std::vector<double> frequencies;
    for (int k = 0; k <= 1000; ++k) frequencies.push_back(2.0 * std::numbers::pi * 0.02 * std::pow(625.0, k * 1e-3));
    const FrequencyDeviation over = deviation(out.sections, model.transfer_function, frequencies);
    EXPECT_LE(over.gain_percent, 1.0) << what;
    EXPECT_LE(over.phase_deg, 1.0) << what;
    for (const Section& section : out.sections.list) {
      for (const double d : section.denominator) EXPECT_GE(d, 0.0) << "a pole in the right half plane; " << what;
    }
    const double step = 100.0 * difference(model, step_input(5000), 0.01);
    const double multisine = 100.0 * difference(model, synthetic::excitation(0.01), 0.01);
    EXPECT_LE(step, 1.0) << what;
    EXPECT_LE(multisine, 1.0) << what;
  }
}

TEST(Export, OfFractionalOrdersKeepsThePastInput) {
  Model model = of({{0.13, 0}}, {{0.02, 1.8}, {1, 0.95}, {0.1, 0}});
  model.past_input = {{-0.5, 0.0, 1.2}, {-4.0, -0.5, -0.7}};
  EXPECT_LT(difference(model, step_input(2000), 0.01), 2e-3);
}

TEST(Export, RefusesWhatItCannotKeep) {
  const Model unstable = of({{1, 0}}, {{1, 1.8}, {-1, 0.9}, {1, 0}});
  EXPECT_THROW(static_cast<void>(exported(unstable, {})), ConfigError);
  Model state = of({{1, 0}}, {{1, 1.8}, {1, 0.9}, {1, 0}});
  state.initial_state = {1.0};
  EXPECT_THROW(static_cast<void>(exported(state, {})), ConfigError);
}

TEST(Export, WritesTheLinesOfTheToolboxes) {
  const TransferFunction g{{{0.46, 0}}, {{0.61, 1.75}, {1, 0.9}, {0.04, 0}}, 0.02};
  EXPECT_EQ(fomcon_line(g), "fotf([0.61 1 0.04], [1.75 0.9 0], [0.46], [0], 0.02)");
  EXPECT_EQ(crone_line(g), "frac_tf(frac_poly_exp([0.46], [0]), frac_poly_exp([0.61 1 0.04], [1.75 0.9 0]))");
}

/// The exported texts run by their languages, on the multisine and on a step, beside the exact simulation.
class ForeignExport : public testing::Test {
 protected:
  struct Case {
    std::string function;
    Model model;
    double allowed;  ///< relative to the greatest output
  };

  static std::vector<Case> cases() {
    std::vector<Case> all;
    for (const Model& model : models_of_whole_orders()) {
      all.push_back({"whole" + std::to_string(all.size()), model, 1e-9});
    }
    std::mt19937_64 generator(3);
    for (int i = 0; i < 3; ++i) {
      const Model model = random_fractional(generator);
      all.push_back({"fractional" + std::to_string(i), model, 0.01});
    }
    return all;
  }

  void write(const std::string& name, const std::string& text) {
    os::write_file_atomically(folder_.path() / name, text);
  }

  void write_numbers(const std::string& name, const Eigen::VectorXd& values) {
    std::ostringstream text;
    text.precision(17);
    for (const double v : values) text << v << '\n';
    write(name, text.str());
  }

  [[nodiscard]] Eigen::VectorXd numbers(const std::string& name) const {
    std::istringstream text(os::read_file(folder_.path() / name));
    std::vector<double> values;
    for (double v = 0.0; text >> v;) values.push_back(v);
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }

  static bool succeeds(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

  /// Runs a command line in the folder; a failure shows what it printed.
  void run(const std::string& command) {
    const std::string at = "cd '" + folder_.path().string() + "' && ";
    ASSERT_EQ(std::system((at + command + " >log 2>&1").c_str()), 0) << os::read_file(folder_.path() / "log");
  }

  void expect_equal(const Case& c, const std::string& file, const Eigen::VectorXd& input) {
    const Eigen::VectorXd exact = simulate(c.model, input, kStep_s);
    const Eigen::VectorXd found = numbers(file);
    ASSERT_EQ(found.size(), exact.size()) << c.function << " " << file;
    EXPECT_LT((found - exact).cwiseAbs().maxCoeff(), c.allowed * exact.cwiseAbs().maxCoeff())
        << c.function << " " << file;
  }

  void expect_all_equal() {
    for (const Case& c : cases()) {
      expect_equal(c, c.function + ".multisine", multisine_);
      expect_equal(c, c.function + ".step", step_);
    }
  }

  void SetUp() override {
    write_numbers("multisine", multisine_);
    write_numbers("step", step_);
  }

  static constexpr double kStep_s = 0.04;
  const Eigen::VectorXd multisine_ = synthetic::excitation(kStep_s);
  const Eigen::VectorXd step_ = step_input(700);
  test::TemporaryFolder folder_;
};

TEST_F(ForeignExport, RunsInOctave) {
  if (!succeeds("command -v octave-cli")) GTEST_SKIP() << "octave-cli is not installed";
  std::string script = "for w = {'multisine', 'step'}\n  u = load(w{1});\n";
  for (const Case& c : cases()) {
    const ExportedModel out = exported(c.model, {});
    write(c.function + ".m", octave_text(out, c.function));
    write("ss_" + c.function + ".m", state_space_text(out, c.function));
    script += "  y = " + c.function + "(u, 0.04); f = fopen(['" + c.function +
              ".' w{1}], 'w'); fprintf(f, '%.17g\\n', y); fclose(f);\n";
  }
  script += "end\nu = load('multisine');\n";
  for (const Case& c : cases()) {
    if (c.model.transfer_function.delay_s > 0.0) continue;
    script += "ss_" + c.function + "; n = rows(A); E = expm([A B; zeros(1, n + 1)] * 0.04); x = x0; y = 0 * u;\n" +
              (c.model.input_map
                   ? "v = max(u - (null + dead_band), 0) + negative_gain_ratio * min(u - (null - dead_band), 0);"
                   : "v = u + input_bias;") +
              "\nfor k = 1:numel(u)\n  y(k) = initial_output + C * x; if k > 1, y(k) = y(k) + D * v(k - 1); end\n" +
              "  x = E(1:n, 1:n) * x + E(1:n, n + 1) * v(k);\nend\nf = fopen('" + c.function +
              ".ss', 'w'); fprintf(f, '%.17g\\n', y); fclose(f);\n";
  }
  write("run_all.m", script);
  ASSERT_NO_FATAL_FAILURE(run("octave-cli --no-init-file run_all.m"));
  expect_all_equal();
  for (const Case& c : cases()) {
    if (c.model.transfer_function.delay_s <= 0.0) expect_equal(c, c.function + ".ss", multisine_);
  }
}

TEST_F(ForeignExport, RunsInPythonWithNumPyAlone) {
  std::string python;
  for (const char* program : {"python3", "/usr/bin/python3"}) {
    if (python.empty() && succeeds(std::string(program) + " -c 'import numpy'")) python = program;
  }
  if (python.empty()) GTEST_SKIP() << "python3-numpy is not installed";
  std::string script = "import numpy as np\n";
  for (const Case& c : cases()) {
    write(c.function + ".py", python_text(exported(c.model, {}), c.function));
    script += "from " + c.function + " import " + c.function + "\n";
    script += "for w in ('multisine', 'step'):\n    np.savetxt('" + c.function + ".' + w, " + c.function +
              "(np.loadtxt(w), 0.04), fmt='%.17g')\n";
  }
  write("run_all.py", script);
  ASSERT_NO_FATAL_FAILURE(run(python + " run_all.py"));
  expect_all_equal();
}

TEST_F(ForeignExport, RunsInCWithoutAWarningOrAMemoryError) {
  if (!succeeds("command -v gcc")) GTEST_SKIP() << "gcc is not installed";
  const bool valgrind = succeeds("command -v valgrind");
  for (const Case& c : cases()) {
    write(c.function + ".c", c_text(exported(c.model, {}), c.function));
    write("main.c", "#include <stdio.h>\n#include \"" + c.function + ".c\"\nstatic " + c.function +
                        "_model m;\nint main(void) {\n  double u;\n  if (" + c.function + "_init(&m, -1.0) != -1 || " +
                        c.function +
                        "_init(&m, 0.04) != 0) return 1;\n  while (scanf(\"%lf\", &u) == 1) printf(\"%.17g\\n\", " +
                        c.function + "_step(&m, u));\n  return 0;\n}\n");
    ASSERT_NO_FATAL_FAILURE(
        run("gcc -std=c99 -O1 -g -Wall -Wextra -Wconversion -Wpedantic -Werror main.c -o main -lm"));
    ASSERT_NO_FATAL_FAILURE(run("sh -c './main <multisine >" + c.function + ".multisine'"));
    const std::string program = valgrind ? "valgrind -q --error-exitcode=9 --leak-check=full ./main" : "./main";
    ASSERT_NO_FATAL_FAILURE(run("sh -c '" + program + " <step >" + c.function + ".step'"));
  }
  expect_all_equal();
  if (!valgrind) GTEST_SKIP() << "the outputs agree; valgrind is not installed";
}

}  // namespace
}  // namespace eha::ident
