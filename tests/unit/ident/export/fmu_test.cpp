// SPDX-License-Identifier: GPL-3.0-or-later
// The functional mock-up unit against the standard's schema, and its sources against the model's simulation.
#include "ident/export/fmu.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "ident/export/model_formats.hpp"
#include "ident/model/model_output.hpp"
#include "tests/unit/ident/synthetic_record.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::ident {
namespace {

bool succeeds(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

Model model(double delay_s) {
  Model m;
  m.name = "rod";
  m.transfer_function = {{{0.15, 0}}, {{0.0065, 2}, {1, 1}, {0.01, 0}}, delay_s};
  m.input_map = ValveMap{-0.2, 0.15, 0.88};
  m.initial_output = 2.95;
  m.initial_state = {0.1};
  m.output_unit = "\"<in>&";
  return m;
}

class Fmu : public ::testing::TestWithParam<double> {
 protected:
  void run(const std::string& command) {
    ASSERT_EQ(std::system(("cd '" + folder_.path().string() + "' && " + command + " >log 2>&1").c_str()), 0)
        << command << "\n"
        << test::content_of(folder_.path() / "log");
  }
  test::TemporaryFolder folder_;
};

TEST_P(Fmu, HasADescriptionThatTheSchemaTakes) {
  if (!succeeds("command -v xmllint")) GTEST_SKIP() << "xmllint is not installed";
  folder_.write("modelDescription.xml", fmu_files(exported(model(GetParam()), {}), "rod").front().content);
  ASSERT_NO_FATAL_FAILURE(run("xmllint --noout --schema " EHA_SOURCE_DIR
                              "/tests/unit/ident/export/fmi_schema/fmi2ModelDescription.xsd modelDescription.xml"));
}

TEST_P(Fmu, BuiltByGccGivesWhatTheModelGives) {
  if (!succeeds("command -v gcc")) GTEST_SKIP() << "gcc is not installed";
  const Model m = model(GetParam());
  for (const ArchivedFile& file : fmu_files(exported(m, {}), "rod")) {
    std::filesystem::create_directories((folder_.path() / file.name).parent_path());
    folder_.write(file.name, file.content);
  }
  const std::string description = test::content_of(folder_.path() / "modelDescription.xml");
  const std::size_t at = description.find("guid=\"") + 6;
  const std::string guid = description.substr(at, description.find('"', at) - at);
  folder_.write("main.c", R"(#include <stdio.h>
#include <dlfcn.h>
#include "sources/fmi2Functions.h"
int main(void) {
  const fmi2ValueReference in = 0, out = 1;
  double u, y;
  fmi2Component c = fmi2Instantiate("a", fmi2CoSimulation, ")" +
                              guid +
                              R"(", "", 0, fmi2False, fmi2False);
  if (c == 0 || fmi2Instantiate("a", fmi2CoSimulation, "other", "", 0, 0, 0) != 0) return 1;
  if (fmi2Instantiate("a", fmi2ModelExchange, "", "", 0, 0, 0) != 0) return 2;
  fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
  fmi2EnterInitializationMode(c);
  fmi2ExitInitializationMode(c);
  while (scanf("%lf", &u) == 1) {
    if (fmi2GetReal(c, &out, 1, &y) != fmi2OK) return 3;
    printf("%.17g\n", y);
    if (fmi2SetReal(c, &in, 1, &u) != fmi2OK || fmi2DoStep(c, 0.0, 0.01, fmi2True) != fmi2OK) return 4;
  }
  fmi2Terminate(c);
  fmi2FreeInstance(c);
  return 0;
}
)");
  const Eigen::VectorXd input = synthetic::excitation(0.01);
  std::ofstream rows(folder_.path() / "input");
  rows.precision(17);
  for (const double u : input) rows << u << '\n';
  rows.close();
  ASSERT_NO_FATAL_FAILURE(
      run("gcc -std=c99 -O1 -Wall -Wextra -Werror -fPIC -shared -Isources sources/fmu.c -o rod.so -lm"));
  // Every function of the standard is there, under its own name.
  ASSERT_NO_FATAL_FAILURE(run("sh -c 'test $(nm -D --defined-only rod.so | grep -c \" T fmi2\") -eq 44'"));
  ASSERT_NO_FATAL_FAILURE(run("gcc -std=c99 -O1 main.c sources/fmu.c -Isources -o main -lm"));
  ASSERT_NO_FATAL_FAILURE(run("sh -c './main <input >output'"));
  std::ifstream output(folder_.path() / "output");
  const Eigen::VectorXd expected = simulate(m, input, 0.01);
  for (Eigen::Index k = 0; k < expected.size(); ++k) {
    double y = 0.0;
    ASSERT_TRUE(output >> y) << k;
    ASSERT_NEAR(y, expected[k], 1e-9) << k;
  }
}

TEST_P(Fmu, IsAnArchiveThatOthersOpen) {
  if (!succeeds("command -v python3")) GTEST_SKIP() << "python3 is not installed";
  const std::string bytes = fmu_bytes(exported(model(GetParam()), {}), "rod");
  EXPECT_EQ(bytes, fmu_bytes(exported(model(GetParam()), {}), "rod"));
  folder_.write("rod.fmu", bytes);
  ASSERT_NO_FATAL_FAILURE(
      run("python3 -c \"import zipfile; z = zipfile.ZipFile('rod.fmu'); assert z.testzip() is None; assert "
          "'modelDescription.xml' in z.namelist() and 'sources/fmi2Functions.h' in z.namelist()\""));
}

TEST_P(Fmu, IsValidForFmpy) {
  if (!succeeds("python3 -c 'import fmpy.validation'")) GTEST_SKIP() << "FMPy is not installed";
  folder_.write("rod.fmu", fmu_bytes(exported(model(GetParam()), {}), "rod"));
  ASSERT_NO_FATAL_FAILURE(
      run("python3 -c \"from fmpy.validation import validate_fmu; found = validate_fmu('rod.fmu'); print(found); "
          "assert not found\""));
}

INSTANTIATE_TEST_SUITE_P(Delays, Fmu, ::testing::Values(0.0, 0.034),
                         [](const auto& delay) { return delay.param > 0.0 ? "Delayed" : "Direct"; });

TEST(TfText, NamesThePolesThatTheRecordDoesNotShow) {
  Model m = model(0.0);
  m.transfer_function.denominator = {{0.0065, 2}, {1, 1}, {0.01, 0}};  // poles at 24.5 Hz and at 0.0016 Hz
  EXPECT_EQ(tf_text(exported(m, {}), "rod").find("% A pole at"), std::string::npos) << "no band is known";
  m.verdict = Verdict{true, {}, Grade::good, {}, FrequencyInterval{0.02, 3.0}};
  const std::string text = tf_text(exported(m, {}), "rod");
  EXPECT_NE(text.find("% A pole at 24.5 Hz is above the band that the record shows, up to 3 Hz"), std::string::npos)
      << text;
  EXPECT_NE(text.find("delay of 0.0065 s"), std::string::npos) << text;
  EXPECT_NE(text.find("% A pole at 0.00159 Hz is below the band that the record shows, from 0.02 Hz"),
            std::string::npos)
      << text;
  m.transfer_function.denominator = {{1, 1}, {0, 0}};
  EXPECT_EQ(tf_text(exported(m, {}), "rod").find("% A pole at"), std::string::npos) << "an integrator alone";
  m.transfer_function.denominator = {{0.0065, 2}, {1, 1}, {0.01, 0}};
  m.verdict->usable_band = FrequencyInterval{0.001, 30.0};
  EXPECT_EQ(tf_text(exported(m, {}), "rod").find("% A pole at"), std::string::npos) << "the record shows both";
}

TEST(TfText, HasGainAndLagOfTheModel) {
  Model m = model(0.02);
  m.transfer_function.denominator = {{0.0065, 2}, {1, 1}};
  const std::string text = tf_text(exported(m, {}), "rod");
  EXPECT_NE(text.find("num = [0.15];\nden = [0.0065 1 0];\nrod = tf(num, den, 'InputDelay', 0.02);\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("K = 0.15;  % gain of the integrator\nT = 0.0065;"), std::string::npos) << text;
}

TEST(TfText, HasFrequencyAndDampingOfAPairAndEachLag) {
  Model m = model(0.0);
  const double w = 2.0 * std::numbers::pi * 5.0;
  m.transfer_function.denominator = {{1.0 / (w * w), 2}, {2.0 * 0.2 / w, 1}, {1, 0}};
  const std::string pair = tf_text(exported(m, {}), "rod");
  EXPECT_NE(pair.find("f0 = 5; D = 0.2;"), std::string::npos) << pair;
  EXPECT_EQ(pair.find("\nT = "), std::string::npos) << pair;
  m.transfer_function.denominator = {{0.3 * 0.08, 2}, {0.38, 1}, {1, 0}};
  const std::string lags = tf_text(exported(m, {}), "rod");
  for (const char* lag : {"T1 = 0.", "T2 = 0.", " = 0.3;", " = 0.08;"}) {
    EXPECT_NE(lags.find(lag), std::string::npos) << lags;
  }
}

}  // namespace
}  // namespace eha::ident
