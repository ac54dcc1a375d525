// SPDX-License-Identifier: GPL-3.0-or-later
// --period beside a column of times: what that contradicts, and the rows that it shows to be missing.
#include "daemon/importer/replaced_clock.hpp"

#include "ident/excitation/portable_draw.hpp"
#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

constexpr double kClockStep_s = 0.1;

/// Rows of a rig by the times of a clock. @param number  of a row of the rig
std::string rows_of(const std::string& header, const std::function<std::string(int)>& time,
                    const std::function<int(int)>& number, int count = Rig::kRows) {
  return Rig::rows(
      header,
      [&](int k) { return fmt::format("{},{:.4f},{:.4f}", time(k), Rig::volts(number(k)), Rig::place(number(k))); },
      count);
}

int itself(int k) { return k; }

std::string all(const std::vector<std::string>& sentences) { return fmt::format("{}", fmt::join(sentences, "\n")); }

TEST_F(ImportedFile, SaysThatAPeriodContradictsTheClock) {
  const auto seconds = write("s.csv", rows_of(
                                          "Time [s],Valve [V],Rod [mm]\n",
                                          [](int k) { return fmt::format("{:.1f}", kClockStep_s * k); }, itself));
  const auto ticks =
      write("ms.csv", rows_of(
                          "t,Valve [V],Rod [mm]\n", [](int k) { return fmt::format("{}", 100 * k); }, itself));
  const auto remarks = [](const std::filesystem::path& path, double period_s) {
    return all(import_record(path, {.period_s = period_s}).remarks);
  };
  for (const auto& path : {seconds}) {
    EXPECT_NE(remarks(path, 0.05).find("--period takes a row every 0.05 s"), std::string::npos) << path;
    EXPECT_NE(remarks(path, 0.12).find("--period takes a row every 0.12 s"), std::string::npos) << path;
    EXPECT_EQ(remarks(path, 0.1).find("--period"), std::string::npos) << path;
  }
  EXPECT_NE(remarks(seconds, 0.102).find("--period takes"), std::string::npos);
  EXPECT_EQ(remarks(seconds, 0.1005).find("--period takes"), std::string::npos) << "less than 1 %";
  EXPECT_EQ(remarks(ticks, 0.1).find("--period takes"), std::string::npos) << "a column of milliseconds";
  EXPECT_NE(remarks(ticks, 0.05).find("--period takes"), std::string::npos) << remarks(ticks, 0.05);
  const Imported cut = import_record(seconds, {.period_s = 0.05, .from_s = 1.0, .to_s = 3.0});
  EXPECT_NE(all(cut.remarks).find("--period takes"), std::string::npos);
  EXPECT_EQ(cut.record.input.size(), 41);
}

TEST_F(ImportedFile, TakesAClockWithoutANameForNeitherInputNorOutputBesideAPeriod) {
  const auto clock = [](int k) { return fmt::format("{:.1f}", kClockStep_s * k); };
  const auto stamps = [](int k) { return fmt::format("{:.3f}", kClockStep_s * k + 0.03 * std::sin(1.7 * k)); };
  for (const std::string& file : {rows_of("", clock, itself), rows_of("", stamps, itself),
                                  rows_of(
                                      "", [](int k) { return fmt::format("{}", 100 * k); }, itself)}) {
    const Imported imported = import_record(write("r.csv", file), {.period_s = kClockStep_s});
    EXPECT_NEAR(imported.record.input[1], Rig::volts(1), 1e-4);
    EXPECT_NEAR(imported.record.output[1], Rig::place(1), 1e-4);
    EXPECT_EQ(all(imported.remarks).find("--period takes"), std::string::npos) << all(imported.remarks);
  }
  // The command of the refusal of an uneven clock reads the same.
  const auto uneven = write("u.csv", rows_of("", stamps, itself));
  EXPECT_NEAR(answered(uneven, refusal_of(uneven)).record.output[1], Rig::place(1), 1e-4);
  // Where a column is left over, the example does not name the clock.
  const auto three = write("three.csv", Rig::rows("", [](int k) {
                             return fmt::format("{:.1f},{:.4f},{:.4f},{:.4f}", kClockStep_s * k, Rig::volts(k),
                                                Rig::place(k), Rig::place(k + 3));
                           }));
  const std::string asked = refusal_of(three, {.period_s = kClockStep_s});
  EXPECT_NE(asked.find("--input 2 --output 3`"), std::string::npos) << asked;
  // A ramp is the input where nothing else is.
  const auto ramp =
      write("ramp.csv", Rig::rows("", [](int k) { return fmt::format("{:.2f},{:.4f}", 0.05 * k, Rig::place(k)); }));
  EXPECT_NEAR(import_record(ramp, {.period_s = kClockStep_s}).record.input[1], 0.05, 1e-9);
}

TEST_F(ImportedFile, PutsRowsBehindAGapOfTheClockWhereTheyBelong) {
  for (int seed = 1; seed <= 20; ++seed) {
    ident::PortableDraw draw(seed);
    const int first = 40 + 7 * seed;
    const int missing = 1 + seed % 6;
    const bool has_gap = seed % 4 > 0;
    const auto number = [&](int k) { return !has_gap || k < first ? k : k + missing; };
    const auto path = write(
        "gap.csv",
        rows_of(
            "Time [s],Valve [V],Rod [mm]\n",
            [&](int k) { return fmt::format("{:.3f}", kClockStep_s * (number(k) + 0.15 * draw.normal())); }, number));
    const Imported imported = import_record(path, {.period_s = kClockStep_s});
    ASSERT_EQ(imported.record.input.size(), Rig::kRows + (has_gap ? missing : 0)) << "seed " << seed;
    ASSERT_EQ(imported.record.unmeasured.size(), has_gap ? static_cast<std::size_t>(missing) : 0U) << "seed " << seed;
    if (has_gap) {
      EXPECT_EQ(imported.record.unmeasured.front(), static_cast<std::size_t>(first));
      EXPECT_NE(all(imported.remarks).find(fmt::format("{} of {} rows are missing", missing, Rig::kRows + missing)),
                std::string::npos)
          << all(imported.remarks);
    }
    for (const int k : {5, first - 1, first + missing + 3, Rig::kRows - 1}) {
      EXPECT_NEAR(imported.record.output[k], Rig::place(k), 1e-3) << "seed " << seed << ", row " << k;
    }
  }
}

}  // namespace
}  // namespace eha::importer
