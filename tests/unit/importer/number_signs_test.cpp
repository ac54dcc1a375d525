// SPDX-License-Identifier: GPL-3.0-or-later
// Commas and points that separate thousands: read where some number proves it, else asked about.
#include "daemon/importer/number_signs.hpp"

#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

/// "74,973" of 74973.
std::string grouped(int value, char sign) {
  const std::string digits = std::to_string(std::abs(value));
  const std::string tail = digits.size() > 3 ? sign + digits.substr(digits.size() - 3) : "";
  return (value < 0 ? "-" : "") + digits.substr(0, digits.size() - (tail.empty() ? 0 : 3)) + tail;
}

int um(int k) { return static_cast<int>(1000.0 * Rig::place(k)); }
int mV(int k) { return static_cast<int>(1000.0 * Rig::volts(k)); }

std::string signs_of(const std::vector<std::vector<std::string>>& columns, char delimiter = ';') {
  SignEvidence evidence(delimiter);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    for (const std::string& field : columns[i]) evidence.add(i, field);
  }
  if (const auto proved = evidence.proved()) {
    return std::string(1, proved->decimal) + (proved->thousands == '\0' ? "" : std::string(1, proved->thousands));
  }
  return evidence.ambiguous() ? "ambiguous" : "unknown";
}

TEST(SignEvidence, IsAnyNumberThatHasOneReading) {
  EXPECT_EQ(signs_of({{"1", "20", "1000"}}), "unknown");
  for (const char* number : {"0.123", "12.5", "-3.25", ".5", "1234.567", "00.123", "1.000e3", "0.000"}) {
    EXPECT_EQ(signs_of({{"74.973", "1.466", number}}), ".") << number;
    EXPECT_EQ(signs_of({{"74,973", "1,466", with_commas(number)}}), ",") << number;
    // One file has one decimal sign.
    EXPECT_EQ(signs_of({{"74,973"}, {number}}), ".,") << number;
  }
  EXPECT_EQ(signs_of({{"1,234.5"}}), ".,");
  EXPECT_EQ(signs_of({{"1.234.567"}}), ",.");
  EXPECT_EQ(signs_of({{"-2'144.1"}}), ".'");
  EXPECT_EQ(signs_of({{"74,973", "1,466"}}), "ambiguous");
  EXPECT_EQ(signs_of({{"74.973"}, {"1,466"}}), "ambiguous");
  EXPECT_EQ(signs_of({{"0", "10", "990"}, {"74.973"}}), "ambiguous") << "of another column";
}

TEST(SignEvidence, IsAColumnOfWholeNumbers) {
  std::vector<std::string> numbers;
  for (int k = 0; k < 12; ++k) numbers.push_back(std::to_string(900 + 9 * k));
  numbers.back() = "1,000";
  EXPECT_EQ(signs_of({numbers}), ".,");
  numbers.back() = "1.000";
  EXPECT_EQ(signs_of({numbers}), ",.");
  EXPECT_EQ(signs_of({{"0", "5", "-5", "1", "2", "3", "2.125"}}), "ambiguous") << "volts that were typed";
  EXPECT_EQ(signs_of({{"10000", "74.973"}}), ".") << "larger ones have no separator";
  EXPECT_EQ(signs_of({{"1500", "1.466"}}), ".");
  EXPECT_EQ(signs_of({{"9500", "10.250"}}), "ambiguous") << "as in Spanish";
}

TEST(SignEvidence, BetweenCommasPointsAreDecimal) {
  EXPECT_EQ(signs_of({{"74.973", "1.466"}}, ','), ".");
  EXPECT_EQ(signs_of({{"74,973", "1,466"}}, ','), "ambiguous");
}

TEST_F(ImportedFile, IsAskedAboutWhereItsNumbersMayBeThousands) {
  for (const bool is_us : {true, false}) {
    const char sign = is_us ? ',' : '.';
    const auto path = write(
        "rod.csv", Rig::rows(is_us ? "Time (ms),Valve (mV),Rod (um)\n" : "Zeit [ms];U [mV];Weg [um]\n", [&](int k) {
          const std::string rod = grouped(um(k), sign);
          return is_us ? fmt::format("{},{},\"{}\"", 10 * k, k % 7, rod) : fmt::format("{};{};{}", 10 * k, k % 7, rod);
        }));
    const std::string refusal = refusal_of(path);
    ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
    EXPECT_NE(refusal.find(fmt::format("{} or {}.{:03}", um(0), um(0) / 1000, um(0) % 1000)), std::string::npos)
        << refusal;
    const Imported thousands = answered(path, refusal, 0);
    const Imported decimal = answered(path, refusal, 1);
    for (int k = 0; k < Rig::kRows; ++k) {
      ASSERT_EQ(thousands.record.output[k], um(k)) << refusal;
      ASSERT_DOUBLE_EQ(decimal.record.output[k], 1e-3 * um(k)) << refusal;
    }
  }
}

TEST_F(ImportedFile, HasThousandsWhereWholeNumbersProveThem) {
  const auto path = write("ints.csv", Rig::rows("Time (ms),Valve (mV),Rod (um)\n", [](int k) {
                            return fmt::format("\"{}\",\"{}\",\"{}\"", grouped(10 * k, ','), grouped(mV(k), ','),
                                               grouped(um(k), ','));
                          }));
  const Imported imported = import_record(path, {});
  EXPECT_NE(imported.guess.find("commas between thousands"), std::string::npos) << imported.guess;
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  for (int k = 0; k < Rig::kRows; ++k) {
    ASSERT_EQ(imported.record.input[k], mV(k));
    ASSERT_EQ(imported.record.output[k], um(k));
  }
}

TEST_F(ImportedFile, HasThousandsBesideDecimalsOfTheOtherSign) {
  const auto path = write("weg.csv", Rig::rows("Zeit [s];U [mV];Weg [um]\n", [](int k) {
                            return with_commas(fmt::format("{:.2f}", 0.01 * k)) + ";" + grouped(mV(k), '.') + ";" +
                                   grouped(um(k), '.') + ",5";
                          }));
  const Imported imported = import_record(path, {});
  for (int k = 0; k < Rig::kRows; ++k) {
    ASSERT_EQ(imported.record.input[k], mV(k));
    ASSERT_EQ(imported.record.output[k], um(k) + 0.5);
  }
  const auto swiss = write("swiss.csv", Rig::rows("Zeit [s];U [mV];Weg [um]\n", [](int k) {
                             return fmt::format("{:.2f};{};{}.5", 0.01 * k, mV(k), grouped(um(k), '\''));
                           }));
  EXPECT_EQ(import_record(swiss, {}).record.output[7], um(7) + 0.5);
}

TEST_F(ImportedFile, IsNotAskedAboutForThreeDecimals) {
  const auto path =
      write("three.csv", Rig::rows("Zeit [s];U [V];Weg [mm]\n", [](int k) {
              return with_commas(fmt::format("{:.3f};{:.3f};{:.3f}", 0.01 * k, Rig::volts(k), Rig::place(k)));
            }));
  EXPECT_NEAR(import_record(path, {}).record.output[9], Rig::place(9), 1e-3);
}

TEST_F(ImportedFile, IsRefusedWhereALaterRowProvesAnotherReading) {
  // The rows that a guess is made from, and then some.
  const int rows = 3000;
  const auto path = write("late.csv", Rig::rows(
                                          "Zeit [s];U [mV];Weg [um]\n",
                                          [&](int k) {
                                            const int rod = k < 2500 ? 74'000 + k % 100 : 900 + k % 90;
                                            return fmt::format("{};{};{}", k, k % 7, grouped(rod, '.'));
                                          },
                                          rows));
  const std::string refusal = refusal_of(path, {.period_s = 0.01});
  ASSERT_NE(refusal.find("--thousands point`"), std::string::npos) << refusal;
  const Imported imported = import_record(path, {.thousands = '.', .period_s = 0.01});
  EXPECT_EQ(imported.record.output[0], 74'000);
  EXPECT_EQ(imported.record.output[rows - 1], 900 + (rows - 1) % 90);
}

TEST_F(ImportedFile, NamesTheOptionForThousandsThatBeginLate) {
  const auto path = write("late.csv", Rig::rows(
                                          "Zeit [s];U [mV];Weg [um]\n",
                                          [](int k) {
                                            return with_commas(fmt::format("{:.2f}", 0.01 * k)) + ";" +
                                                   grouped(k % 50 + (k > 2800 ? 1000 : 0), '.') + ";" +
                                                   std::to_string(k % 90);
                                          },
                                          3000));
  const std::string refusal = refusal_of(path);
  ASSERT_NE(refusal.find("a thousands separator? Then: `"), std::string::npos) << refusal;
  EXPECT_EQ(answered(path, refusal).record.input[2999], 1000 + 2999 % 50);
}

}  // namespace
}  // namespace eha::importer
