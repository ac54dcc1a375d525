// SPDX-License-Identifier: GPL-3.0-or-later
// What headers and the lines above them say of the time and of the columns' roles.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/importer/imported_file.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

/// 300 rows of "time,u,y" whose clock stands at start + (k step, rounded).
std::string counted(const char* header, double step, double start = 0.0) {
  std::string text = std::string(header) + "\n";
  for (int k = 0; k < 300; ++k) {
    text += fmt::format("{:.0f},{:.4f},{:.4f}\n", start + std::round(step * k), std::sin(0.05 * k),
                        2.0 + std::sin(0.05 * k - 0.5));
  }
  return text;
}

TEST(TimeUnit, ReadsATimeColumnNamedAfterItsUnit) {
  const test::TemporaryFolder folder;
  for (const char* header : {"ms,u_V,y_mm", "millis,cmd,pos", "msec,u,y", "Millisekunden,u,y", "Time ms,u,y"}) {
    EXPECT_NEAR(import_record(folder.write("r.csv", counted(header, 10.0)), {}).record.step_s, 0.01, 1e-9) << header;
  }
  for (const char* header : {"micros,u,y", "usec,u,y"}) {
    const auto path = folder.write("r.csv", counted(header, 1e4, 4.2e9));
    EXPECT_NEAR(import_record(path, {}).record.step_s, 0.01, 1e-9) << header;
  }
  EXPECT_NEAR(import_record(folder.write("r.csv", counted("Time ms,Valve V,Rod mm", 10.0)), {}).record.step_s, 0.01,
              1e-9);
  EXPECT_NEAR(import_record(folder.write("r.csv", counted("min,u,y", 1.0)), {}).record.step_s, 60.0, 1e-9);
}

TEST(TimeUnit, AsksForTheUnitOfAClockOfUnevenCounts) {
  const test::TemporaryFolder folder;
  for (const double step : {10.4, 2.5, 0.7}) {
    const auto path = folder.write("r.csv", counted("t,u,y", step));
    for (const Options& options : {Options{}, Options{.resample = true}, Options{.time = "t", .resample = true}}) {
      try {
        FAIL() << import_record(path, options).guess;
      } catch (const DataError& error) {
        const std::string refusal = error.what();
        if (step < 1.0) continue;  // rows alike: the coarse clock is told
        EXPECT_NE(refusal.find("has no unit; if in seconds: `"), std::string::npos) << refusal;
        EXPECT_NE(refusal.find(
                      fmt::format("; if in milliseconds: `eha import {} --period {:.9g}`", path.string(), 1e-3 * step)),
                  std::string::npos)
            << refusal;
      }
    }
  }
}

}  // namespace
}  // namespace eha::importer
