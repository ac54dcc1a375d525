// SPDX-License-Identifier: GPL-3.0-or-later
// Exported controllers against the one in this process: 10^5 ticks in C, Python, Octave and structured text.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "ident/export/controller_formats.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::ident {
namespace {

constexpr int kTicks = 100000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

AxisSettings settings(FeedbackKind kind) {
  AxisSettings s;
  s.tick_s = 0.001;
  s.kind = kind;
  s.feedback = {.kp = 15.0, .filter_s = 0.005};
  if (integrates(kind)) s.feedback.ki = 60.0;
  if (differentiates(kind)) s.feedback.kd = 0.1;
  if (kind == FeedbackKind::fopid) {
    s.feedback.integral_order = 0.85;
    s.feedback.derivative_order = 1.1;
  }
  s.rest_error = 0.002;
  s.tracking_s = 0.25;
  s.most_speed = 0.6;
  s.inverse = {.null = -0.2, .dead_band = 0.15, .gain_positive = 0.15, .gain_negative = 0.13, .smoothing = 0.03};
  s.feed_forward = {.position_rate = 0.01, .rest = 2.9, .acceleration_s = 0.007};
  s.reference = {.lowest = 0.15, .highest = 5.75, .velocity = 0.4, .acceleration = 1.0, .jerk = 25.0};
  s.command_min = -5.0;
  s.command_max = 5.0;
  s.slew_per_s = 20.0;
  return s;
}

bool succeeds(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

class ControllerExport : public ::testing::TestWithParam<FeedbackKind> {
 protected:
  ControllerExport() {
    // A rod that follows with a lag and noise, set points that jump and glide; readings that are missing, from the
    // start on, and some in counts.
    std::mt19937_64 random(17);
    const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
    AxisController controller(controller_.coefficients);
    controller.start(kNaN, 0.1);
    double rod = 2.0;
    double set_point = 2.0;
    std::ofstream input(folder_.path() / "input");
    input.precision(17);
    for (int i = 0; i < kTicks; ++i) {
      if (i % 3000 == 0) set_point = 0.5 + 4.5 * uniform();
      if (i % 3000 > 2000) set_point += 0.0002;
      const double measured = rod + 0.002 * (uniform() - 0.5);
      const double reading = i < 3 || i % 7919 == 7000 ? kNaN : i % 2473 == 2000 ? 65535.0 : measured;
      input << set_point << ' ';
      if (std::isfinite(reading)) input << reading << '\n';
      if (!std::isfinite(reading)) input << "NaN\n";
      const AxisOutput out = controller.step(set_point, reading);
      expected_.push_back(out.command);
      rod += 0.001 * 0.12 * (std::abs(out.command + 0.25) > 0.1 ? out.command + 0.25 : 0.0);
    }
  }

  void expect_equal(double allowed = 1e-9, int ticks = kTicks) {
    std::ifstream output(folder_.path() / "output");
    double worst = 0.0;
    for (int i = 0; i < ticks; ++i) {
      double value = 0.0;
      ASSERT_TRUE(output >> value) << "row " << i;
      worst = std::max(worst, std::abs(value - expected_[static_cast<std::size_t>(i)]));
    }
    EXPECT_LT(worst, allowed);
  }

  void run(const std::string& command) {
    ASSERT_EQ(std::system(("cd '" + folder_.path().string() + "' && " + command + " >log 2>&1").c_str()), 0)
        << command << "\n"
        << test::content_of(folder_.path() / "log");
  }

  ExportedController controller_{
      coefficients(settings(GetParam())),
      controller_notes(coefficients(settings(GetParam())), "test */ (* \"\"\" *) name", "in")};
  std::vector<double> expected_;
  test::TemporaryFolder folder_;
};

TEST_P(ControllerExport, RunsInCWithoutAWarning) {
  if (!succeeds("command -v gcc")) GTEST_SKIP() << "gcc is not installed";
  folder_.write("axis.c", controller_c_text(controller_, "axis"));
  folder_.write(
      "main.c",
      "#include <stdio.h>\n#include \"axis.c\"\nstatic axis_controller c;\nint main(void) {\n"
      "  double r, y;\n  axis_start(&c, NAN, 0.1);\n"
      "  while (scanf(\"%lf %lf\", &r, &y) == 2) printf(\"%.17g\\n\", axis_step(&c, r, y));\n  return 0;\n}\n");
  ASSERT_NO_FATAL_FAILURE(run("gcc -std=c99 -O1 -Wall -Wextra -Wconversion -Wpedantic -Werror main.c -o main -lm"));
  ASSERT_NO_FATAL_FAILURE(run("sh -c './main <input >output'"));
  expect_equal();
}

TEST_P(ControllerExport, GivesTheSameVoltsForMillimetres) {
  ExportedController in_mm;
  in_mm.coefficients = coefficients(in_length_unit(controller_.coefficients.settings, 25.4));
  in_mm.notes = controller_notes(in_mm.coefficients, "axis", "mm");
  in_mm.length_unit = "mm";
  AxisController in_inches(controller_.coefficients);
  AxisController same(in_mm.coefficients);
  in_inches.start(2.0, 0.1);
  same.start(2.0 * 25.4, 0.1);
  for (int k = 0; k < 3000; ++k) {
    const double r = k < 1000 ? 2.0 : 3.5;
    const double y = 2.0 + 0.0004 * k;
    ASSERT_NEAR(same.step(25.4 * r, 25.4 * y).command, in_inches.step(r, y).command, 1e-9) << k;
  }
  EXPECT_NE(in_mm.notes[1].find("Position in mm, command in V"), std::string::npos) << in_mm.notes[1];
  EXPECT_NE(
      controller_c_text(in_mm, "axis").find("axis_step(axis_controller *c, double set_point_mm, double position_mm)"),
      std::string::npos);
  EXPECT_NE(controller_python_text(in_mm, "axis").find("def step(self, set_point_mm, position_mm):"),
            std::string::npos);
  EXPECT_NE(controller_octave_text(in_mm, "axis").find("function [command_V, c] = axis(c, set_point_mm, position_mm)"),
            std::string::npos);
  EXPECT_NE(controller_simulink_text(in_mm, "axis")
                .find("[command_V, reference_mm, is_limited] = axis(set_point_mm, "
                      "position_mm, command_at_start_V)"),
            std::string::npos);
  EXPECT_NE(controller_st_text(in_mm, "axis").find("  SetPoint_mm : LREAL;\n  Actual_mm : LREAL;"), std::string::npos);
}

TEST_P(ControllerExport, RunsInPython) {
  if (!succeeds("command -v python3")) GTEST_SKIP() << "python3 is not installed";
  folder_.write("axis.py", controller_python_text(controller_, "axis"));
  folder_.write("main.py",
                "from axis import axis\nc = axis(float('nan'), 0.1)\nwith open('output', 'w') as out:\n"
                "    for line in open('input'):\n        r, y = map(float, line.split())\n"
                "        out.write('%.17g\\n' % c.step(r, y))\n");
  ASSERT_NO_FATAL_FAILURE(run("python3 main.py"));
  expect_equal();
}

TEST_P(ControllerExport, RunsInOctave) {
  if (!succeeds("command -v octave-cli")) GTEST_SKIP() << "octave-cli is not installed";
  // Octave takes 0.15 ms a tick. EHA_ALL_TICKS: all of them.
  const int ticks = std::getenv("EHA_ALL_TICKS") != nullptr ? kTicks : kTicks / 10;
  folder_.write("axis.m", controller_octave_text(controller_, "axis"));
  folder_.write("block.m", controller_simulink_text(controller_, "block"));
  folder_.write("main.m", "in = load('input'); in = in(1:" + std::to_string(ticks) +
                              ", :); c = axis('start', NaN, 0.1); u = zeros(rows(in), 2);\n"
                              "for k = 1:rows(in)\n  [u(k, 1), c] = axis(c, in(k, 1), in(k, 2));\n"
                              "  if k <= 5000, u(k, 2) = block(in(k, 1), in(k, 2), c.command); end\nend\n"
                              "f = fopen('output', 'w'); fprintf(f, '%.17g\\n', u(:, 1)); fclose(f);\n");
  ASSERT_NO_FATAL_FAILURE(run("octave-cli --no-init-file main.m"));
  expect_equal(1e-9, ticks);
}

TEST_P(ControllerExport, RunsAsStructuredText) {
  // matiec, the compiler of structured text of the Beremiz project: iec2c in PATH, its folder lib in MATIEC_INCLUDE.
  if (!succeeds("command -v iec2c")) GTEST_SKIP() << "matiec's iec2c is not installed";
  const char* include = std::getenv("MATIEC_INCLUDE");
  const std::string library = include != nullptr ? include : "/usr/share/matiec/lib";
  folder_.write("axis.st", controller_st_text(controller_, "axis"));
  ASSERT_NO_FATAL_FAILURE(run("iec2c -I '" + library + "' axis.st"));
  folder_.write(
      "main.c",
      "#include <math.h>\n#include <stdio.h>\n#include \"iec_std_lib.h\"\nTIME __CURRENT_TIME;\nBOOL __DEBUG;\n"
      "#include \"POUS.h\"\n#include \"POUS.c\"\nstatic AXIS block;\nint main(void) {\n"
      "  double r, y;\n  AXIS_init__(&block, 0);\n  block.EN.value = 1;\n"
      "  block.MANUAL.value = 1;\n  block.ACTUAL_IN.value = NAN;\n  block.MANUALCOMMAND_V.value = 0.1;\n"
      "  AXIS_body__(&block);\n  block.MANUAL.value = 0;\n"
      "  while (scanf(\"%lf %lf\", &r, &y) == 2) {\n    block.SETPOINT_IN.value = r;\n"
      "    block.ACTUAL_IN.value = y;\n    AXIS_body__(&block);\n"
      "    printf(\"%.17g\\n\", (double)block.COMMAND_V.value);\n  }\n  return 0;\n}\n");
  ASSERT_NO_FATAL_FAILURE(run("gcc -w -O1 -I '" + library + "/C' main.c -o main -lm"));
  ASSERT_NO_FATAL_FAILURE(run("sh -c './main <input >output'"));
  expect_equal(1e-6);
}

/// Function blocks of the standard, whose names no variable may have, in any case.
TEST_P(ControllerExport, DeclaresEveryVariableOfItsStructuredTextOnce) {
  const std::string st = controller_st_text(controller_, "axis");
  EXPECT_EQ(st.find('@'), std::string::npos);
  for (const char* reserved : {"\n  Integral :", "\n  Derivative :", "\n  PID :", "\n  Ramp :", "\n  Hysteresis :"}) {
    EXPECT_EQ(st.find(reserved), std::string::npos) << reserved;
  }
  // One comment at the head: nothing of the name ends it early.
  EXPECT_EQ(st.find("*)"), st.find("*)\nFUNCTION_BLOCK axis"));
  for (const ControllerFormat& format : controller_formats()) {
    EXPECT_EQ(format.text(controller_, "axis").find('@'), std::string::npos) << format.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ControllerExport,
                         ::testing::Values(FeedbackKind::p, FeedbackKind::pid, FeedbackKind::fopid),
                         [](const auto& kind) { return std::string(text(kind.param)); });

}  // namespace
}  // namespace eha::ident
