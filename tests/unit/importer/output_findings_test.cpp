// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/output_findings.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/importer/lone_rows.hpp"
#include "tests/unit/shared_data.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kRodRows = 3000;
constexpr double kRodStep_s = 0.01;

/// A rod that integrates a sine and noise of 0.02 mm.
struct Rod {
  std::vector<double> input;
  std::vector<double> output;
};

Rod rod() {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.02);
  Rod made;
  double place = 60.0;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    const double t = kRodStep_s * static_cast<double>(k);
    made.input.push_back(std::sin(1.3 * t) + 0.5 * std::sin(7.0 * t));
    place += 15.0 * made.input.back() * kRodStep_s;
    made.output.push_back(place + noise(random));
  }
  return made;
}

std::string csv_of(const Rod& rod, const std::function<double(std::size_t)>& time) {
  std::string text = "time_s,valve_V,rod_mm\n";
  for (std::size_t k = 0; k < kRodRows; ++k) text += fmt::format("{},{},{}\n", time(k), rod.input[k], rod.output[k]);
  return text;
}

double even_time(std::size_t k) { return std::round(100.0 * kRodStep_s * static_cast<double>(k)) / 100.0; }

/// The message of a refusal; empty where the file is read.
std::string refused_with(const std::filesystem::path& path, const Options& options = {}) {
  try {
    static_cast<void>(import_record(path, options));
    return "";
  } catch (const DataError& error) {
    return error.what();
  }
}

TEST(LoneRows, AreThoseThatARodCannotReach) {
  Rod r = rod();
  EXPECT_TRUE(lone_rows(r.input, r.output).empty());
  for (const std::size_t k : {700U, 1800U, 1801U, 2500U}) r.output[k] = 0.0;
  EXPECT_EQ(lone_rows(r.input, r.output), (std::vector<std::size_t>{700, 1800, 1801, 2500}));
}

TEST(LoneRows, AreSoManyAtOnceAsHoldAValueInThePlaceOfReadings) {
  Rod r = rod();
  std::vector<std::size_t> expected;
  for (std::size_t k = 700; k < 720; ++k) {
    r.output[k] = 9999.0;
    expected.push_back(k);
  }
  EXPECT_EQ(lone_rows(r.input, r.output), expected);
  for (std::size_t k = 700; k < 700 + kRodRows / 50; ++k) r.output[k] = 9999.0;
  EXPECT_TRUE(lone_rows(r.input, r.output).empty()) << "a fiftieth of the rows at once";
  // A valve that opens for a while, and a plant that answers at once.
  std::vector<double> input(kRodRows, 0.0);
  std::vector<double> output(kRodRows, 1.0);
  for (std::size_t k = 0; k < kRodRows; ++k) output[k] += 0.01 * static_cast<double>(k % 7);
  for (std::size_t k = 900; k < 920; ++k) {
    input[k] = 5.0;
    output[k + 1] = 30.0;
  }
  EXPECT_TRUE(lone_rows(input, output).empty());
}

TEST(LoneRows, AreNoneWhereTheInputHasAPulseOrTheSignalIsSuch) {
  std::vector<double> input(kRodRows, 0.0);
  std::vector<double> output(kRodRows, 1.0);
  input[900] = 5.0;
  output[901] = 3.0;
  EXPECT_TRUE(lone_rows(input, output).empty()) << "the answer to a pulse";
  Rod r = rod();
  for (std::size_t k = 5; k < kRodRows; k += 10) r.output[k] = 0.0;
  EXPECT_TRUE(lone_rows(r.input, r.output).empty()) << "a tenth of the rows";
  // A step of the rod's place is no row alone.
  Rod stepped = rod();
  for (std::size_t k = 1500; k < kRodRows; ++k) stepped.output[k] += 20.0;
  EXPECT_TRUE(lone_rows(stepped.input, stepped.output).empty());
}

/// Answers of plants to a coarsely recorded input of steps.
Rod stepped(const std::function<double(std::size_t)>& input, double pole, double pair, double washed_out) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.002);
  Rod made;
  double lag = 0.0;
  double before = 0.0;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    const double u = input(k);
    made.input.push_back(u);
    made.output.push_back(5.0 * (lag - washed_out * u) + noise(random));
    const double next = (pole + pair) * lag - pole * pair * before + (1.0 - pole) * (1.0 - pair) * u;
    before = lag;
    lag = next;
  }
  return made;
}

TEST(LoneRows, AreNoneOfAPlantThatAnswersSteps) {
  const auto pulses = [](std::size_t k) { return k % 104 < 4 ? 1.0 + 0.5 * static_cast<double>(k / 104 % 3) : 0.0; };
  const auto levels = [](std::size_t k) {
    const std::size_t level = k / 50;
    return std::sin(2.7 * static_cast<double>(level) + 1.0);
  };
  for (double pole = 0.0; pole < 0.95; pole += 0.02) {
    const Rod lag = stepped(pulses, pole, 0.0, 0.0);
    EXPECT_TRUE(lone_rows(lag.input, lag.output).empty()) << "a lag after pulses of four rows, pole " << pole;
    const Rod washout = stepped(levels, pole, 0.0, 1.0);
    EXPECT_TRUE(lone_rows(washout.input, washout.output).empty()) << "what answers to changes alone, pole " << pole;
    const Rod ringing = stepped(levels, -pole, 0.0, 0.0);
    EXPECT_TRUE(lone_rows(ringing.input, ringing.output).empty()) << "it overshoots, pole " << -pole;
  }
  std::vector<double> step(400, 0.0);
  std::vector<double> answer(400, 0.0);
  for (std::size_t k = 200; k < 400; ++k) step[k] = 2.0;
  answer[201] = 3.0;
  answer[202] = 2.9;
  EXPECT_TRUE(lone_rows(step, answer).empty()) << "one step";
}

TEST(LoneRows, AreNoneInTheNoiseBeforeASensorFroze) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  Rod r = rod();
  for (double& y : r.output) y += noise(random);
  for (std::size_t k = kRodRows / 3; k < kRodRows; ++k) r.output[k] = r.output[kRodRows / 3];
  EXPECT_TRUE(lone_rows(r.input, r.output).empty());
  r.output[700] = 0.0;
  EXPECT_EQ(lone_rows(r.input, r.output), std::vector<std::size_t>{700});
}

TEST(LoneRows, AreFoundBesideStepsThatDoNotMoveTheRodSoFar) {
  const auto levels = [](std::size_t k) {
    const std::size_t level = k / 50;
    return std::sin(2.7 * static_cast<double>(level) + 1.0);
  };
  Rod r = stepped(levels, 0.9, 0.0, 0.0);
  for (const std::size_t k : {702U, 1830U, 1831U, 2525U}) r.output[k] = 60.0;
  EXPECT_EQ(lone_rows(r.input, r.output), (std::vector<std::size_t>{702, 1830, 1831, 2525}));
}

TEST(LoneRows, AreFoundAtSomeStepsBesideMany) {
  const auto levels = [](std::size_t k) {
    const std::size_t level = k / 50;
    return std::sin(2.7 * static_cast<double>(level) + 1.0);
  };
  Rod r = stepped(levels, 0.9, 0.0, 0.0);
  std::vector<std::size_t> disturbed;
  for (const std::size_t step : {700U, 1450U, 2500U}) {
    for (std::size_t k = step; k < step + 3; ++k) {
      r.output[k] = 60.0;
      disturbed.push_back(k);
    }
  }
  EXPECT_EQ(lone_rows(r.input, r.output), disturbed);
}

TEST(Units, OfAnOptionReplaceThoseOfTheFile) {
  const test::TemporaryFolder folder;
  std::string text = "time,u,y [in]\n";
  for (int k = 0; k < 100; ++k) text += fmt::format("{},{},{}\n", 0.01 * k, k % 20, 50 + k % 30);
  const auto path = folder.write("bare.csv", text);
  EXPECT_EQ(import_record(path, {}).record.input_channel.unit, "");
  const ident::Record record = import_record(path, {.input_unit = "mV", .output_unit = "mm"}).record;
  EXPECT_EQ(record.input_channel.unit, "mV");
  EXPECT_EQ(record.output_channel.unit, "mm");
  EXPECT_EQ(record.output[0], 50.0) << "numbers stay as they are";
}

TEST(LoneRows, AreRefusedWithTheCommandsThatFillOrKeepThem) {
  const test::TemporaryFolder folder;
  const Rod clean = rod();
  Rod r = clean;
  r.output[1501] = 0.0;
  const auto path = folder.write("rod.csv", csv_of(r, even_time));
  const std::string refusal = refused_with(path);
  EXPECT_NE(refusal.find("1 row of the output stands alone, the first at 15.01 s: 0 between"), std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find("rod.csv:1503: "), std::string::npos) << "the line";
  EXPECT_NE(refusal.find("--resample`"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("if they were measured so, to take them as they are: `eha import "), std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find(" --keep-lone-rows`"), std::string::npos) << refusal;
  const Imported kept = import_record(path, {.keep_lone_rows = true});
  EXPECT_EQ(kept.record.output[1501], 0.0);
  EXPECT_TRUE(kept.record.unmeasured.empty());
  const Imported filled = import_record(path, {.resample = true});
  EXPECT_EQ(filled.record.unmeasured, std::vector<std::size_t>{1501});
  EXPECT_NEAR(filled.record.output[1501], clean.output[1501], 0.2);
  ASSERT_FALSE(filled.repairs.empty());
  EXPECT_NE(filled.repairs.front().find("taken as not measured"), std::string::npos) << filled.repairs.front();
}

TEST(LoneRows, OfAnInputLieFarBeyondItsRange) {
  Rod r = rod();
  EXPECT_TRUE(lone_inputs(r.input).empty());
  r.input[1501] = 43.1;
  EXPECT_EQ(lone_inputs(r.input), std::vector<std::size_t>{1501});
  std::vector<double> pulses(kRodRows, 0.0);
  pulses[900] = 5.0;
  EXPECT_TRUE(lone_inputs(pulses).empty()) << "an excitation of pulses";
  const test::TemporaryFolder folder;
  const auto path = folder.write("rod.csv", csv_of(r, even_time));
  const std::string refusal = refused_with(path);
  EXPECT_NE(refusal.find("1 row of the input stands alone, the first at 15.01 s: 43.1 between"), std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find("--resample`"), std::string::npos) << refusal;
  EXPECT_EQ(import_record(path, {.resample = true}).record.unmeasured, std::vector<std::size_t>{1501});
  EXPECT_EQ(import_record(path, {.keep_lone_rows = true}).record.input[1501], 43.1);
}

TEST(Numbers, OfAMistypedDecimalSignAreNoThousands) {
  const test::TemporaryFolder folder;
  std::string text = "Zeit [s];Ventil [V];Weg [mm]\n";
  for (int k = 0; k < 100; ++k)
    text += fmt::format("{},{:02};{};75,{}\n", k / 50, k % 50 * 2, k == 40 ? "0.431" : "0,431", k);
  const std::string refusal = refused_with(folder.write("r.csv", text));
  EXPECT_NE(refusal.find("got \"0.431\"; the decimal sign of the others is a comma: correct the cell"),
            std::string::npos)
      << refusal;
  EXPECT_EQ(refusal.find("--thousands"), std::string::npos) << refusal;
}

TEST(OutputRemarks, NameAClippedSensorAndTheLongestPartWithout) {
  Rod r = rod();
  double greatest = 0.0;
  for (const double y : r.output) greatest = std::max(greatest, y);
  EXPECT_TRUE(findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks.empty());
  const double end = greatest - 4.0;
  std::size_t first = kRodRows;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    if (r.output[k] < end) continue;
    r.output[k] = end;
    first = std::min(first, k);
  }
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks;
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_NE(remarks.front().find("its greatest value"), std::string::npos) << remarks.front();
  // The part that is named has no clipped row.
  const auto value = [&](const char* option, double otherwise) {
    const std::size_t at = remarks.front().find(option);
    return at == std::string::npos ? otherwise
                                   : std::strtod(remarks.front().c_str() + at + std::strlen(option), nullptr);
  };
  const double from_s = value("--from ", 0.0);
  const double to_s = value("--to ", kRodStep_s * kRodRows);
  EXPECT_GT(to_s - from_s, 1.0) << remarks.front();
  for (std::size_t k = 0; k < kRodRows; ++k) {
    const double t = kRodStep_s * static_cast<double>(k);
    if (t > from_s + 0.1 && t < to_s - 0.1) {
      EXPECT_LT(r.output[k], end) << t;
    }
  }
}

TEST(OutputRemarks, CutToThePartThatMovesAndNotToALongRest) {
  constexpr std::size_t kRest = 900;
  Rod r = rod();
  double greatest = 0.0;
  for (std::size_t k = 0; k < kRest; ++k) greatest = std::max(greatest, r.output[k]);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  for (std::size_t k = 0; k < kRodRows; ++k) {
    r.output[k] = k < kRest ? std::min(r.output[k], greatest - 4.0) : greatest - 8.0 + noise(random);
  }
  const OutputFindings found = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s);
  ASSERT_FALSE(found.remarks.empty());
  ASSERT_FALSE(found.cut.keeps_all()) << found.remarks.back();
  EXPECT_FALSE(found.cut.keeps(20.0)) << found.remarks.back();
  EXPECT_NE(found.remarks.back().find("that moves most: --"), std::string::npos) << found.remarks.back();
}

TEST(OutputRemarks, NameNoEndStopOfAPlantThatLevelsItself) {
  // Lags of 80 and 20 ms behind levels of 1.5 and 0.75 V, at the least of which the output rests now and then.
  constexpr std::array kLevels{-1.5, -0.75, 0.75, 1.5};
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.05);
    std::uniform_int_distribution<int> level(0, 3);
    Rod made;
    double x = 0.0;
    double y = 0.0;
    double volts = 0.0;
    for (std::size_t k = 0; k < 2000; ++k) {
      if (k % 12 == 0) volts = kLevels[static_cast<std::size_t>(level(random))];
      // One long rest at the least level.
      const double held = k >= 1038 && k < 1110 ? kLevels[0] : volts;
      made.input.push_back(held);
      made.output.push_back(30.0 + y + noise(random));
      x += (1.0 - std::exp(-0.01 / 0.02)) * (5.0 * held - x);
      y += (1.0 - std::exp(-0.01 / 0.08)) * (x - y);
    }
    const OutputFindings found = findings_on_output(made.input, made.output, {}, 0.0, 0.01);
    for (const std::string& remark : found.remarks) {
      EXPECT_EQ(remark.find("end stop"), std::string::npos) << seed << ": " << remark;
    }
  }
}

TEST(OutputRemarks, NameNoCutWhereNoPartIsWithout) {
  Rod r = rod();
  for (std::size_t k = 0; k < r.output.size(); ++k) r.output[k] = k / 200 % 2 == 0 ? 1.0 : -1.0;
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks;
  ASSERT_FALSE(remarks.empty());
  EXPECT_NE(remarks.back().find("no part is without"), std::string::npos) << remarks.back();
  EXPECT_EQ(remarks.back().find("--to"), std::string::npos) << remarks.back();
}

TEST(OutputRemarks, GiveOneCutForBothEnds) {
  Rod r = rod();
  double least = r.output.front();
  double greatest = least;
  for (const double y : r.output) {
    least = std::min(least, y);
    greatest = std::max(greatest, y);
  }
  for (double& y : r.output) y = std::clamp(y, least + 4.0, greatest - 4.0);
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks;
  ASSERT_EQ(remarks.size(), 1U);
  const std::string& remark = remarks.front();
  EXPECT_NE(remark.find("its greatest value, and "), std::string::npos) << remark;
  EXPECT_NE(remark.find("its least value: "), std::string::npos) << remark;
  EXPECT_EQ(remark.find("longest"), remark.rfind("longest")) << remark;
}

TEST(OutputRemarks, NameASensorThatFrozeAndItsTime) {
  Rod r = rod();
  for (std::size_t k = 1201; k <= 1500; ++k) r.output[k] = r.output[1200];
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks;
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_NE(remarks.front().find("from 12 to 15 s, while the input moves"), std::string::npos) << remarks.front();
  EXPECT_TRUE(remarks.front().ends_with(" --from 15.01")) << remarks.front();
  // A rod that rests because nothing moves it.
  for (std::size_t k = 1200; k <= 1500; ++k) r.input[k] = 0.01;
  EXPECT_TRUE(findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks.empty());
}

TEST(OutputRemarks, NameNoEndWhereTheRodRestsAtBothPlacesUnderOneInput) {
  // Jogged out and back, read in steps of 0.05 mm: it rests at its greatest and at its least value, at 0 V.
  std::vector<double> input;
  std::vector<double> output;
  double y = 50.0;
  for (int k = 0; k < 2000; ++k) {
    const double u = k >= 200 && k < 600 ? 2.0 : k >= 1000 && k < 1400 ? -2.0 : 0.0;
    input.push_back(u);
    output.push_back(0.05 * std::round(y / 0.05));
    y += 0.02 * u;
  }
  const auto remarks = findings_on_output(input, output, {}, 0.0, 0.01).remarks;
  EXPECT_TRUE(remarks.empty()) << remarks.front();
  // Pressed on at its end it is on its end stop.
  for (int k = 600; k < 1000; ++k) input[static_cast<std::size_t>(k)] = 2.0;
  EXPECT_FALSE(findings_on_output(input, output, {}, 0.0, 0.01).remarks.empty());
}

TEST(OutputRemarks, NameNoFrozenSensorOfARodThatRestsBetweenTwoSwitches) {
  std::vector<double> input;
  std::vector<double> output;
  double y = 0.0;
  for (int k = 0; k < 3000; ++k) {
    // The input leads by the five rows of a dead time.
    const int level = (k / 200) % 4;
    input.push_back(((k + 5) / 200) % 4 - 1.5);
    y += 0.05 * (2.0 * (level - 1.5) - y);
    output.push_back(std::round(y * 10.0) / 10.0);
  }
  EXPECT_EQ(findings_on_output(input, output, {}, 0.0, 0.02).frozen, "");
}

TEST(OutputRemarks, NameTheOtherEndOfAClippedSensorThoughItIsThereForAShortWhile) {
  Rod r = rod();
  const double greatest = *std::max_element(r.output.begin(), r.output.end());
  const double least = *std::min_element(r.output.begin(), r.output.end());
  for (double& y : r.output) y = std::min(y, greatest - 4.0);
  for (std::size_t k = kRodRows - 20; k < kRodRows; ++k) r.output[k] = least - 1.0;
  const OutputFindings found = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s);
  ASSERT_EQ(found.remarks.size(), 1U);
  EXPECT_NE(found.remarks.front().find("its least value: "), std::string::npos) << found.remarks.front();
  EXPECT_FALSE(found.cut.keeps(kRodStep_s * (kRodRows - 10)));
  EXPECT_TRUE(found.remarks.front().ends_with(": " + cut_options(found.cut))) << found.remarks.front();
}

TEST(OutputRemarks, NameNoEndStopWhereTheInputAsksTheRodBackInVain) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.05);
  Rod made;
  double place = 0.0;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    // Without supply for 8 s, at the least place of the record.
    const double t = kRodStep_s * static_cast<double>(k) - 8.0;
    made.input.push_back(2.0 * std::sin(1.3 * t) + std::sin(7.0 * t));
    if (t > 0.0) place += 12.0 * made.input.back() * kRodStep_s;
    made.output.push_back(place + noise(random));
  }
  const OutputFindings found = findings_on_output(made.input, made.output, {}, 0.0, kRodStep_s);
  for (const std::string& remark : found.remarks) EXPECT_EQ(remark.find("end stop"), std::string::npos) << remark;
}

TEST(OutputRemarks, NameAnEndStopThatANoisySensorShows) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.05);
  const auto findings = [&](double stop, double push) {
    Rod made;
    double place = 120.0;
    for (std::size_t k = 0; k < kRodRows; ++k) {
      const double t = kRodStep_s * static_cast<double>(k);
      made.input.push_back(2.0 * std::sin(1.3 * t) + std::sin(7.0 * t) + (t > 10.0 && t < 16.0 ? push : 0.0));
      place = std::min(stop, place + 12.0 * made.input.back() * kRodStep_s);
      made.output.push_back(place + noise(random));
    }
    return findings_on_output(made.input, made.output, {}, 0.0, kRodStep_s);
  };
  const OutputFindings found = findings(200.0, 3.0);
  ASSERT_EQ(found.remarks.size(), 1U);
  EXPECT_NE(found.remarks.front().find("a rod is on its end stop, or the sensor at its end"), std::string::npos)
      << found.remarks.front();
  EXPECT_FALSE(found.cut.keeps(15.0)) << cut_options(found.cut);
  EXPECT_TRUE(findings(1e9, 3.0).remarks.empty()) << "it runs on";
  EXPECT_TRUE(findings(1e9, 0.0).remarks.empty());
}

TEST(OutputRemarks, NameASensorThatIsReadMoreSlowlyThanTheRows) {
  Rod r = rod();
  Rod coarse = r;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    r.output[k] = r.output[k - k % 5];
    coarse.output[k] = 0.5 * std::round(2.0 * coarse.output[k]);
  }
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s).remarks;
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_NE(remarks.front().find("changes only every 5 rows, 0.05 s"), std::string::npos) << remarks.front();
  EXPECT_TRUE(findings_on_output(coarse.input, coarse.output, {}, 0.0, kRodStep_s).remarks.empty())
      << "a coarse converter";
}

TEST(Columns, SeemExchangedWhereTheInputIsTheSmootherOne) {
  const Rod r = rod();
  EXPECT_EQ(why_exchanged(r.input, r.output), "");
  EXPECT_NE(why_exchanged(r.output, r.input), "");
  const test::TemporaryFolder folder;
  std::string text = "Time,CH1,CH2\n";
  for (std::size_t k = 0; k < kRodRows; ++k) text += fmt::format("{},{},{}\n", even_time(k), r.output[k], r.input[k]);
  const auto path = folder.write("scope.csv", text);
  const Imported imported = import_record(path, {.command = "eha fit scope.csv"});
  EXPECT_EQ(imported.guess.find('\n'), std::string::npos) << imported.guess;
  ASSERT_EQ(imported.remarks.size(), 1U);
  const std::string& remark = imported.remarks.front();
  EXPECT_NE(remark.find("may be exchanged"), std::string::npos) << remark;
  text.replace(0, 4, "time_s");
  const Imported plain = import_record(folder.write("plain.csv", text), {.command = "eha fit plain.csv"});
  ASSERT_FALSE(plain.remarks.empty()) << "a plain record without units";
  EXPECT_NE(plain.remarks.front().find("may be exchanged"), std::string::npos) << plain.remarks.front();
  EXPECT_NE(remark.find("`eha fit scope.csv --input 3 --output 2`"), std::string::npos) << remark;
  EXPECT_TRUE(import_record(path, {.input = "3", .output = "2"}).remarks.empty());
}

TEST(Columns, SeemExchangedWhereTheOutputComesBeforeTheInput) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  // Tones through a lag of 0.4 s, read by a noisy sensor.
  std::vector<double> input;
  std::vector<double> output;
  double state = 0.0;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    const double t = kRodStep_s * static_cast<double>(k);
    input.push_back(std::sin(2.0 * t) + std::sin(9.1 * t + 1.0));
    state += kRodStep_s / 0.4 * (input.back() - state);
    output.push_back(state + 0.25 * normal(random));
  }
  EXPECT_EQ(why_exchanged(input, output), "");
  // The other way round the sensor's noise makes the input as rough as the output.
  const std::string why = why_exchanged(output, input);
  EXPECT_NE(why.find("the output comes before the input"), std::string::npos) << why;
}

TEST(Columns, AreNotSaidToBeExchangedWhereNobodyCanTell) {
  std::vector<double> input;
  std::vector<double> output;
  for (std::size_t k = 0; k < kRodRows; ++k) {
    const double t = kRodStep_s * static_cast<double>(k);
    input.push_back(std::sin(2.0 * t));
    output.push_back(std::sin(2.0 * t - 2.4));
  }
  EXPECT_EQ(why_exchanged(input, output), "");
  EXPECT_EQ(why_exchanged(output, input), "") << "one tone: a lag of more than half a turn may be a lead";
}

TEST(Columns, OfPublishedRecordsAreNotSaidToBeExchanged) {
  for (const char* name : {"eha_pump.csv", "hair_dryer.csv", "servohydraulic_mts.csv"}) {
    const std::filesystem::path path = test::shared(std::string("data/") + name);
    EHA_REQUIRE_SHARED(path);
    const ident::Record record = import_record(path, {.input = "2", .output = "3", .resample = true}).record;
    const std::vector<double> input(record.input.begin(), record.input.end());
    const std::vector<double> output(record.output.begin(), record.output.end());
    EXPECT_EQ(why_exchanged(input, output), "") << name;
  }
}

TEST(Columns, OfOurOwnFormatThatAreExchangedAreAskedAbout) {
  const Rod r = rod();
  const test::TemporaryFolder folder;
  std::string text = "time_s,displacement_mm,voltage_V\n";
  for (std::size_t k = 0; k < kRodRows; ++k) text += fmt::format("{},{},{}\n", even_time(k), r.output[k], r.input[k]);
  const auto path = folder.write("own.csv", text);
  const std::string refusal = refused_with(path, {.command = "eha fit own.csv"});
  EXPECT_NE(refusal.find("`eha fit own.csv --input 3 --output 2`"), std::string::npos) << refusal;
  EXPECT_EQ(refused_with(path, {.input = "3", .output = "2"}), "");
  EXPECT_EQ(refused_with(path, {.input = "2", .output = "3"}), "");
}

TEST(Clocks, OfWholeNumbersWithoutAUnitAreAskedAbout) {
  const Rod r = rod();
  const test::TemporaryFolder folder;
  const auto written = [&](const char* name, const char* header, double step) {
    std::string text = header + std::string("\n");
    for (std::size_t k = 0; k < kRodRows; ++k) {
      text += fmt::format("{},{},{}\n", 52311.0 + step * static_cast<double>(k), r.input[k], r.output[k]);
    }
    return folder.write(name, text);
  };
  const auto unknown = written("unknown.csv", "clock,valve_V,rod_mm", 5.0);
  const std::string refusal = refused_with(unknown, {.command = "eha fit unknown.csv"});
  EXPECT_NE(refusal.find("if in seconds: `eha fit unknown.csv --period 5`"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("if in milliseconds: `eha fit unknown.csv --period 0.005`"), std::string::npos) << refusal;
  EXPECT_EQ(refused_with(unknown, {.period_s = 0.005}), "");
  EXPECT_EQ(refused_with(written("named.csv", "clock (ms),valve_V,rod_mm", 5.0)), "");
  EXPECT_EQ(refused_with(written("fine.csv", "clock,valve_V,rod_mm", 0.5)), "") << "nobody counts so but in seconds";
}

TEST(OutputRemarks, NameLongFilledGaps) {
  const Rod r = rod();
  EXPECT_TRUE(findings_on_output(r.input, r.output, {100, 900, 901}, 0.0, kRodStep_s).remarks.empty()) << "short ones";
  std::vector<std::size_t> filled;
  for (std::size_t k = 1000; k < 1012; ++k) filled.push_back(k);
  const std::vector<std::string> remarks = findings_on_output(r.input, r.output, filled, 0.0, kRodStep_s).remarks;
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_TRUE(remarks.front().ends_with("--from 10.12")) << remarks.front();
}

TEST(RestartedTime, IsRefusedWithACommandForEachPart) {
  const test::TemporaryFolder folder;
  const Rod r = rod();
  const auto path = folder.write("twice.csv", csv_of(r, [](std::size_t k) { return even_time(k % 1200); }));
  const std::string refusal = refused_with(path, {.command = "eha fit twice.csv"});
  EXPECT_NE(refusal.find("the first: `eha fit twice.csv --period 0.01 --to 11.995`, the second: `eha fit twice.csv "
                         "--period 0.01 --from 11.995 --to 23.995`, the third: `eha fit twice.csv --period 0.01 --from "
                         "23.995`"),
            std::string::npos)
      << refusal;
  const Imported first = import_record(path, {.period_s = 0.01, .to_s = 11.995});
  ASSERT_EQ(first.record.output.size(), 1200);
  EXPECT_EQ(first.record.output[1199], r.output[1199]);
  const Imported second = import_record(path, {.period_s = 0.01, .from_s = 11.995, .to_s = 23.995});
  ASSERT_EQ(second.record.output.size(), 1200);
  EXPECT_EQ(second.record.output[0], r.output[1200]);
}

/// The rod seen by a sensor of coarse steps, with noise that crosses them.
Rod coarse_rod(double step_mm) {
  Rod r = rod();
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.05 * step_mm);
  for (double& y : r.output) y = std::round((y + noise(random)) / step_mm) * step_mm;
  return r;
}

TEST(CoarseSensor, HasNoLoneRowsStopsOrFrozenPartsWhereTheRodMovesWithinAStep) {
  for (const double step_mm : {0.5, 1.0, 2.0}) {
    const Rod r = coarse_rod(step_mm);
    EXPECT_TRUE(lone_rows(r.input, r.output).empty()) << step_mm;
    const OutputFindings found = findings_on_output(r.input, r.output, {}, 0.0, kRodStep_s);
    EXPECT_EQ(found.frozen, "") << step_mm;
    EXPECT_TRUE(found.cut.keeps_all()) << step_mm << (found.remarks.empty() ? "" : found.remarks.front());
    Rod spiked = r;
    spiked.output[700] += 20.0 * step_mm;
    EXPECT_EQ(lone_rows(spiked.input, spiked.output), (std::vector<std::size_t>{700})) << step_mm;
  }
}

}  // namespace
}  // namespace eha::importer
