// SPDX-License-Identifier: GPL-3.0-or-later
// Files with several columns of times: clocks beside each other, and channels that have one each.
#include "tests/unit/importer/imported_file.hpp"

namespace eha::importer {
namespace {

using Cell = std::function<std::string(int)>;

/// Rows of two columns, a voltage and a place.
std::string rows_of(const std::string& names, const Cell& first, const Cell& second, int count = Rig::kRows) {
  return Rig::rows(
      names + ",Valve [V],Rod [mm]\n",
      [&](int k) { return fmt::format("{},{},{:.4f},{:.4f}", first(k), second(k), Rig::volts(k), Rig::place(k)); },
      count);
}

/// Rows of a time and a voltage, a time and a place.
std::string channels(const Cell& first, const Cell& second,
                     const std::string& header = "Time1 [s],u [V],Time2 [s],x [mm]\n") {
  return Rig::rows(header, [&](int k) {
    return fmt::format("{},{:.4f},{},{:.4f}", first(k), Rig::volts(k), second(k), Rig::place(k));
  });
}

std::string wall_clock(int k) { return fmt::format("14:03:{:02}.{:03}", k / 100, k % 100 * 10); }
std::string whole_seconds(int k) { return fmt::format("14:03:{:02}", k / 100); }
Cell seconds(double step_s, double start_s = 0.0) {
  return [=](int k) { return fmt::format("{:.4f}", start_s + step_s * k); };
}

TEST_F(ImportedFile, TakesTheFinerOfTwoClocksThatAgree) {
  const struct {
    const char* names;
    Cell first;
    Cell second;
    const char* said;
  } files[] = {
      {"Time,Elapsed", whole_seconds, seconds(0.01), "time 2 \"Elapsed\" (taken as seconds; 1 \"Time\" is coarser)"},
      {"Time,t [s]", wall_clock, seconds(0.01), "time 2 \"t [s]\" (1 \"Time\" agrees)"},
      {"Time [s],Elapsed [ms]", [](int k) { return fmt::format("{:.1f}", 0.01 * k); },
       [](int k) { return fmt::format("{}", 10 * k); }, "time 2 \"Elapsed [ms]\" (1 \"Time [s]\" is coarser)"},
      {"Timestamp,Elapsed", seconds(0.01, 1'772'373'792.0), seconds(0.01), "time 2 \"Elapsed\" (taken as"},
      {"Time,Elapsed [ms]", seconds(0.01), [](int k) { return fmt::format("{}", 10 * k); },
       "time 2 \"Elapsed [ms]\" (1"},
      {"Time,Elapsed", [](int k) { return fmt::format("{:.8f}", 46'082.5856 + 0.01 * k / 86'400.0); }, seconds(0.01),
       "time 2 \"Elapsed\" (taken as seconds"},
  };
  for (const auto& file : files) {
    const Imported imported = import_record(write("two.csv", rows_of(file.names, file.first, file.second)), {});
    EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01) << file.names;
    EXPECT_NE(imported.guess.find(file.said), std::string::npos) << imported.guess;
  }
}

TEST_F(ImportedFile, AsksWhichOfTwoClocksThatContradictOneAnother) {
  for (const auto& [names, first] : {std::pair<const char*, Cell>("Time,t [s]", wall_clock),
                                     {"Time [s],Elapsed [s]", seconds(0.01, 1000.0)},
                                     {"Time,Elapsed", seconds(0.01)}}) {
    const auto path = write("two.csv", rows_of(names, first, seconds(0.02)));
    const std::string refusal = refusal_of(path);
    EXPECT_NE(refusal.find("contradict one another"), std::string::npos) << refusal;
    ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
    EXPECT_NE(answered(path, refusal, 0).record.step_s, answered(path, refusal, 1).record.step_s) << refusal;
  }
}

TEST_F(ImportedFile, ReadsChannelsWithTheirOwnTimesOnOneGrid) {
  for (const double later_s : {0.0, 0.004, -0.003}) {
    const Imported imported =
        import_record(write("own.csv", channels(seconds(0.01, 1.0), seconds(0.01, 1.0 + later_s))), {});
    EXPECT_DOUBLE_EQ(imported.record.step_s, 0.01);
    EXPECT_EQ(imported.record.output_channel.name, "x");
    EXPECT_NE(imported.guess.find("time 1 \"Time1 [s]\", the grid of 3 \"Time2 [s]\" too"), std::string::npos)
        << imported.guess;
    const std::string remarks = fmt::format("{}", fmt::join(imported.remarks, "\n"));
    EXPECT_EQ(remarks.find("sampled") != std::string::npos, std::abs(later_s) > 0.0) << remarks;
    const char* said = later_s > 0.0 ? "0.004 s after 2 \"u [V]\"" : later_s < 0.0 ? "0.003 s before 2 \"u [V]\"" : "";
    EXPECT_NE(remarks.find(said), std::string::npos) << remarks;
  }
  const Imported ms = import_record(
      write("ms.csv", channels([](int k) { return fmt::format("{}", 10 * k); },
                               [](int k) { return fmt::format("{}", 10 * k); }, "Time_ms,u_V,Time_ms,x_mm\n")),
      {});
  EXPECT_DOUBLE_EQ(ms.record.step_s, 0.01);
}

TEST_F(ImportedFile, HasACommandThatPutsChannelsOnOneGrid) {
  const struct {
    Cell second;
    const char* why;
    int rows;
  } files[] = {
      {seconds(0.005), "their steps are 0.01 s and 0.005 s", 150},
      {seconds(0.02), "their steps are 0.01 s and 0.02 s", 150},
      {seconds(0.01, 1.0), "they begin 1 s apart", 200},
      {[](int k) { return fmt::format("{:.4f}", 0.01 * k + (k < 250 ? 0.0 : 0.05)); }, "they part at row 251", 300}};
  for (const auto& file : files) {
    const auto path = write("own.csv", channels(seconds(0.01), file.second));
    const std::string refusal = refusal_of(path);
    EXPECT_NE(refusal.find(file.why), std::string::npos) << refusal;
    ASSERT_EQ(commands_of(refusal).size(), 2U) << refusal;
    ASSERT_TRUE(shell("cp own.csv '" + path.string() + ".kept' && " + commands_of(refusal)[0])) << refusal;
    const Imported imported = import_record(folder_.path() / "own-columns.csv", {});
    EXPECT_NEAR(static_cast<double>(imported.record.input.size()), file.rows, 2.0) << refusal;
    EXPECT_EQ(imported.record.input_channel.unit, "V");
    EXPECT_EQ(imported.record.output_channel.unit, "mm");
  }
}

}  // namespace
}  // namespace eha::importer
