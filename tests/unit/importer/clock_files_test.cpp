// SPDX-License-Identifier: GPL-3.0-or-later
// Clocks: the ways in which programs write them, those that are coarser than the rows, that drift or go back. Every
// command of a refusal is followed.
#include "daemon/importer/clock_text.hpp"
#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

std::string cells(int k) { return fmt::format("{:.4f},{:.4f}", Rig::volts(k), Rig::place(k)); }

/// Rows of a clock, a voltage and a place, between commas.
std::string clock_rows(const std::function<std::string(int)>& clock, int count = Rig::kRows) {
  return Rig::rows(
      "Time,Valve (V),Rod (mm)\n", [&](int k) { return clock(k) + "," + cells(k); }, count);
}

TEST(ClockText, KnowsHalvesOfADayMinutesAndUnits) {
  for (const auto& [early, late] :
       {std::pair("11/25/2026 11:59:59 AM", "11/25/2026 12:00:00 PM"), std::pair("12:59:59 AM", "01:00:00 AM"),
        std::pair("1:03:07 pm", "1:03:08 pm"), std::pair("00:59,3", "01:00,3"), std::pair("59:59.5", "60:00.5"),
        std::pair("0 sec", "1 sec"), std::pair("500 ms", "1500 ms"),
        std::pair("2026-11-25T14:03:07.3+01:00", "2026-11-25T14:03:08.3+01:00")}) {
    ASSERT_TRUE(clock_seconds(early) && clock_seconds(late)) << early;
    EXPECT_NEAR(*clock_seconds(late) - *clock_seconds(early), 1.0, 1e-6) << early;
  }
  EXPECT_DOUBLE_EQ(clock_quantum_s("0.01 sec"), 0.01);
  EXPECT_DOUBLE_EQ(clock_quantum_s("500 ms"), 1e-3);
  EXPECT_DOUBLE_EQ(clock_quantum_s("00:07,3"), 0.1);
  EXPECT_DOUBLE_EQ(clock_quantum_s("25.11.2026 10:00:07"), 1.0);
  for (const char* text : {"14:03:07.300 -> 0.01", "12 mm", "00:61,3", "10:00:00 Uhr"}) {
    EXPECT_FALSE(clock_seconds(text)) << text;
  }
  for (const char* text : {"14:03", "11/25/2026 2:03 PM", "25.11.26 14:03"}) {
    EXPECT_TRUE(is_clock_of_minutes(text)) << text;
  }
  for (const char* text : {"14:03:07", "14", "00:07,3"}) EXPECT_FALSE(is_clock_of_minutes(text)) << text;
}

TEST_F(ImportedFile, OffersThePeriodOfTheClocksOfOtherPrograms) {
  const std::vector<std::function<std::string(int)>> clocks{
      [](int k) { return fmt::format("11/25/2026 2:{:02}:{:02} PM", (k + 7) / 600, (k + 7) / 10 % 60); },
      [](int k) { return fmt::format("02:{:02}:{:02} PM", (k + 7) / 600, (k + 7) / 10 % 60); }};
  for (const auto& clock : clocks) {
    const auto path = write("clock.csv", clock_rows(clock));
    const std::string refusal = refusal_of(path);
    ASSERT_NE(refusal.find("--period 0.1`"), std::string::npos) << refusal;
    EXPECT_EQ(answered(path, refusal).record.input.size(), Rig::kRows);
  }
}

TEST_F(ImportedFile, IsReadByAClockThatTellsItsRowsApart) {
  const auto at = [](int k, char sign) {
    return fmt::format("14:{:02}:{:02}{}{:03}", k / 6000, k / 100 % 60, sign, k % 100 * 10);
  };
  const std::vector<std::pair<double, std::function<std::string(int)>>> clocks{
      {0.01, [&](int k) { return at(k + 5990, '.'); }},
      {0.01, [&](int k) { return at(k, ':'); }},
      {0.01, [&](int k) { return "\"2026-03-01 " + at(k, ',') + "\""; }},
      {0.01, [&](int k) { return "2026-03-01T" + at(k, '.') + "000Z"; }},
      {0.1, [](int k) { return fmt::format("\"00:{:02},{}\"", k / 10, k % 10); }},
      {0.1, [](int k) { return fmt::format("{:g} sec", 0.1 * k); }},
      {1.0, [](int k) { return fmt::format("11/25/2026 2:{:02}:{:02} PM", k / 60, k % 60); }},
      // Over midnight.
      {0.1, [](int k) {
         const int tenth = (863'900 + k) % 864'000;
         return fmt::format("{:02}:{:02}:{:02}.{}", tenth / 36'000, tenth / 600 % 60, tenth / 10 % 60, tenth % 10);
       }}};
  for (const auto& [step_s, clock] : clocks) {
    const Imported imported = import_record(write("clock.csv", clock_rows(clock)), {});
    EXPECT_DOUBLE_EQ(imported.record.step_s, step_s) << clock(0);
    EXPECT_DOUBLE_EQ(imported.record.start_s, 0.0);
    EXPECT_EQ(imported.record.input.size(), Rig::kRows);
    EXPECT_NE(imported.guess.find("time 1 \"Time\" (a clock, in seconds from its first row)"), std::string::npos)
        << imported.guess;
  }
}

TEST_F(ImportedFile, JoinsAClockThatItsOwnCommaParts) {
  const auto path = write(
      "log.csv", clock_rows([](int k) { return fmt::format("2026-03-01 14:03:{:02},{:03}", k / 100, k % 100 * 10); }));
  const Imported imported = import_record(path, {});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01) << imported.guess;
  EXPECT_EQ(imported.record.input.size(), Rig::kRows);
  EXPECT_NEAR(imported.record.output[5], Rig::place(5), 1e-4);
  EXPECT_NE(imported.guess.find("time 1 \"Time\" (a clock"), std::string::npos) << imported.guess;
}

TEST_F(ImportedFile, IsCutByTheSecondsOfItsClock) {
  const auto path = write("clock.csv", clock_rows([](int k) { return fmt::format("10:00:{:02}.{}", k / 10, k % 10); }));
  const Imported part = import_record(path, {.time = "Time", .from_s = 2.0, .to_s = 5.0});
  EXPECT_DOUBLE_EQ(part.record.start_s, 2.0);
  ASSERT_EQ(part.record.input.size(), 31);
  EXPECT_NEAR(part.record.input[0], Rig::volts(20), 1e-4);
}

TEST_F(ImportedFile, AsksAboutAClockWhoseStepsDiffer) {
  const auto gap = write("gap.csv", clock_rows([](int k) {
                           const int tenth = k < 200 ? k : k + 7;
                           return fmt::format("10:00:{:02}.{}", tenth / 10, tenth % 10);
                         }));
  const std::string refusal = refusal_of(gap);
  ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
  EXPECT_EQ(answered(gap, refusal, 0).record.input.size(), 200) << refusal;
  EXPECT_EQ(answered(gap, refusal, 1).record.input.size(), Rig::kRows + 7) << refusal;
  const auto uneven = write("uneven.csv", clock_rows([](int k) {
                              return fmt::format("10:00:{:02}.{:03}", k / 100, k % 100 * 10 + k * (k + 1) % 3);
                            }));
  EXPECT_NE(refusal_of(uneven).find("--period 0.01`"), std::string::npos) << refusal_of(uneven);
}

TEST_F(ImportedFile, SaysThatAClockShowsMinutesOnly) {
  for (const char* clock : {"25.11.2026 14:03", "11/25/2026 2:03 PM", "14:03"}) {
    const std::string refusal = refusal_of(write("minutes.csv", clock_rows([&](int) { return clock; })));
    EXPECT_NE(refusal.find("shows minutes only"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("--period SECONDS`"), std::string::npos) << refusal;
  }
}

TEST_F(ImportedFile, OffersThePeriodOfAClockOfMinutes) {
  const auto of_day = [](int k) { return fmt::format("{:02}:{:02}", (20 + k / 60) % 24, k % 60); };
  const std::string dated = refusal_of(write(
      "dated.csv", clock_rows([&](int k) { return fmt::format("{}.11.2026 {}", k < 240 ? 25 : 26, of_day(k)); })));
  ASSERT_EQ(commands_of(dated).size(), 1U) << dated;
  const Imported by_minutes = answered(folder_.path() / "dated.csv", dated);
  EXPECT_DOUBLE_EQ(by_minutes.record.step_s, 60.0);
  EXPECT_EQ(by_minutes.record.input.size(), Rig::kRows) << dated;
  const std::string bare = refusal_of(write("bare.csv", clock_rows(of_day)));
  ASSERT_EQ(commands_of(bare).size(), 2U) << bare;
  EXPECT_DOUBLE_EQ(answered(folder_.path() / "bare.csv", bare, 0).record.step_s, 60.0);
  EXPECT_DOUBLE_EQ(answered(folder_.path() / "bare.csv", bare, 1).record.step_s, 1.0);
}

TEST_F(ImportedFile, TurnsRowsRoundOfWhichTheNewestIsTheFirst) {
  const int last = Rig::kRows - 1;
  const auto turned = [&](const std::string& header, const std::function<std::string(int)>& clock) {
    return Rig::rows(header, [&](int k) { return clock(last - k) + "," + cells(last - k); });
  };
  const std::string header = "Time,Valve (V),Rod (mm)\n";
  const std::vector<std::pair<double, std::string>> texts{
      {0.01, turned("Time [s],Valve (V),Rod (mm)\n", [](int k) { return fmt::format("{:.2f}", 0.01 * k); })},
      {0.01, turned("time_s,valve_V,rod_mm\n", [](int k) { return fmt::format("{:.2f}", 0.01 * k); })},
      {0.01, turned(header, [](int k) { return fmt::format("2026-03-01T10:00:0{}.{:02}0Z", k / 100, k % 100); })},
      {60.0, turned(header, [](int k) { return fmt::format("{:02}:{:02}:00", (20 + k / 60) % 24, k % 60); })}};
  for (const auto& [step_s, text] : texts) {
    const auto path = write("turned.csv", text);
    const Imported imported = import_record(path, {});
    EXPECT_DOUBLE_EQ(imported.record.step_s, step_s);
    EXPECT_DOUBLE_EQ(imported.record.start_s, 0.0);
    ASSERT_EQ(imported.record.input.size(), Rig::kRows);
    EXPECT_NEAR(imported.record.input[7], Rig::volts(7), 1e-4);
    EXPECT_NEAR(imported.record.output[last], Rig::place(last), 1e-4);
    EXPECT_NE(imported.guess.find("the newest row first, turned round"), std::string::npos) << imported.guess;
    const Imported part = import_record(path, {.from_s = 5 * step_s, .to_s = 9 * step_s});
    ASSERT_EQ(part.record.input.size(), 5);
    EXPECT_NEAR(part.record.input[0], Rig::volts(5), 1e-4);
    EXPECT_NEAR(import_record(path, {.period_s = 0.5}).record.input[7], Rig::volts(7), 1e-4)
        << "a period replaces the times, not their order";
  }
}

TEST_F(ImportedFile, OffersThePeriodOfAllRowsWhereTimesRepeat) {
  for (const double begin_s : {0.0, 0.037}) {
    const auto path =
        write("coarse.csv", clock_rows([&](int k) { return fmt::format("{:.1f}", begin_s + 0.01 * k); }, 3000));
    const std::string refusal = refusal_of(path);
    EXPECT_EQ(refusal.find("--resample"), std::string::npos) << "it would lose nine rows in ten: " << refusal;
    const Imported imported = answered(path, refusal);
    EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
    EXPECT_EQ(imported.record.input.size(), 3000);
  }
  // One row that was written twice is something else.
  const std::string once = refusal_of(
      write("twice.csv", clock_rows([](int k) { return fmt::format("{:.2f}", 0.01 * (k < 100 ? k : k - 1)); })));
  EXPECT_NE(once.find("--resample`"), std::string::npos) << once;
}

TEST_F(ImportedFile, OffersTheMeanStepOfAClockThatDrifts) {
  float time_s = 0.0F;
  const auto path = write("single.csv", clock_rows(
                                            [&](int) {
                                              const float now_s = time_s;
                                              time_s += 0.001F;
                                              return fmt::format("{:.9g}", now_s);
                                            },
                                            40'000));
  const std::string refusal = refusal_of(path);
  ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
  EXPECT_TRUE(options_of(commands_of(refusal)[0]).resample) << refusal;
  const Imported imported = answered(path, refusal, 1);
  EXPECT_EQ(imported.record.input.size(), 40'000);
  EXPECT_NEAR(imported.record.step_s, 0.001, 2e-6);
}

TEST_F(ImportedFile, CutsBeforeTheSecondInWhichRowsAreMissing) {
  // A hundred rows a second, of which forty are missing somewhere within the 21st.
  const auto path = write("gap.csv", clock_rows(
                                         [](int k) {
                                           const int second = (k < 2030 ? k : k + 40) / 100;
                                           return fmt::format("10:00:{:02}", second);
                                         },
                                         3500));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("rows are missing within the 1 s before row 2061"), std::string::npos) << refusal;
  const Imported imported = answered(path, refusal);
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01) << refusal;
  EXPECT_EQ(imported.record.input.size(), 2000) << refusal;
}

TEST_F(ImportedFile, HasACommandForEachOfItsRecords) {
  const auto path = write("three.csv", clock_rows([](int k) {
                            return fmt::format("{:.2f}", 0.01 * (k < 120 ? k : k < 210 ? k - 120 : k - 210));
                          }));
  const std::string refusal = refusal_of(path);
  EXPECT_NE(refusal.find("3 in all"), std::string::npos) << refusal;
  ASSERT_EQ(commands_of(refusal).size(), 3U) << refusal;
  const int begins[] = {0, 120, 210, 300};
  for (std::size_t i = 0; i < 3; ++i) {
    const Imported part = answered(path, refusal, i);
    ASSERT_EQ(part.record.input.size(), begins[i + 1] - begins[i]);
    EXPECT_NEAR(part.record.input[0], Rig::volts(begins[i]), 1e-4);
  }
}

TEST_F(ImportedFile, KeepsAColumnOfTimesApartThatAPeriodReplaces) {
  const auto path = write("numbered.csv", Rig::rows("", [](int k) { return fmt::format("{},{}", k, cells(k)); }));
  const Imported imported = import_record(path, {.time = "1", .period_s = 0.01});
  EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
  EXPECT_NEAR(imported.record.output[3], Rig::place(3), 1e-4);
}

TEST_F(ImportedFile, IsOfTheMonitorOfASerialPort) {
  const auto path =
      write("serial.txt",
            Rig::rows("", [](int k) { return fmt::format("14:03:{:02}.{}00 -> {}", k / 10, k % 10, cells(k)); }));
  const std::string refusal = refusal_of(path);
  ASSERT_FALSE(commands_of(refusal).empty()) << refusal;
  ASSERT_TRUE(shell(commands_of(refusal)[0])) << refusal;
  const auto columns = folder_.path() / "serial-columns.txt";
  EXPECT_NEAR(import_record(columns, {}).record.output[5], Rig::place(5), 1e-4);
}

}  // namespace
}  // namespace eha::importer
