// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <ctime>
#include <sstream>
#include <string>

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

TEST(EndTimes, FollowOneAnotherFromTheStartOfTheRun) {
  setenv("TZ", "UTC", 1);
  tzset();
  const Json entries{{{"state", "over"}, {"duration_s", 120.0}, {"run", "20261123T100000Z-goto"}},
                     {{"state", "running"}, {"duration_s", 600.0}, {"run", "20261123T235500Z-paper"}},
                     {{"state", "waiting"}, {"duration_s", 120.0}, {"run", ""}},
                     {{"state", "held"}, {"duration_s", 120.0}, {"run", ""}},
                     {{"state", "waiting"}, {"duration_s", 60.0}, {"run", ""}, {"fast", true}},
                     {{"state", "waiting"}, {"duration_s", 180.0}, {"run", ""}}};
  EXPECT_EQ(end_times(entries), (std::vector<std::string>{"", "00:05", "00:07", "", "", "00:10"}));
}

TEST(EndTimes, AreABoundWhileTheRodIsExploredAndCountThePreparationAfterwards) {
  setenv("TZ", "UTC", 1);
  tzset();
  Json entries{{{"state", "running"}, {"duration_s", 120.0}, {"run", "20261123T235500Z-characterise"}},
               {{"state", "waiting"}, {"duration_s", 60.0}, {"run", ""}}};
  entries[0]["preparing_s"] = 200.0;
  EXPECT_EQ(end_times(entries), (std::vector<std::string>{"00:00", "00:01"}));
  entries[0]["exploring_at_most_s"] = 900.0;
  EXPECT_EQ(end_times(entries), (std::vector<std::string>{"by 00:12", "by 00:13"}));
}

TEST(EndTimes, AreUnknownWhereNothingIsPlayed) {
  const Json entries{{{"state", "waiting"}, {"duration_s", 120.0}, {"run", ""}}};
  EXPECT_EQ(end_times(entries), std::vector<std::string>{""});
}

TEST(EndTimes, AreUnknownOfAPlacingWhoseLengthIsItsTimeOut) {
  const Json entries{
      {{"state", "running"}, {"duration_s", 120.0}, {"run", "20261123T235500Z-goto"}, {"only_places", true}},
      {{"state", "waiting"}, {"duration_s", 120.0}, {"run", ""}}};
  EXPECT_EQ(end_times(entries), (std::vector<std::string>{"", ""}));
}

TEST(VerdictText, SaysNothingTwice) {
  EXPECT_EQ(verdict_text({{"outcome", "interrupted"}, {"note", "interrupted by a stop request"}}),
            "interrupted by a stop request");
  EXPECT_EQ(verdict_text({{"outcome", "faulted"}, {"note", "no_motion at 1 s"}}), "faulted: no_motion at 1 s");
}

TEST(QueueTable, LeavesWhatToDoAfterAFaultToItsRun) {
  const Json faulted{{"entry", 3},
                     {"name", "paper"},
                     {"state", "over"},
                     {"outcome", "faulted"},
                     {"run", "20261123T100000Z-paper"},
                     {"note",
                      "travel_limit at 34.038 s: the rod is at, or would not stop before, 146.008 mm, the "
                      "limit is 146.000 mm; lower the excitation or start further from the end"}};
  const std::string table = queue_table(Json::array({faulted}));
  EXPECT_EQ(table.find("lower the excitation"), std::string::npos) << table;
  EXPECT_NE(table.find("20261123T100000Z-paper"), std::string::npos) << table;
  EXPECT_NE(table.find("says more"), std::string::npos) << table;
}

TEST(QueueTable, SaysWhyOnesWereCancelledAndWrapsLongResults) {
  const auto entry = [](int number, const char* state, const std::string& note) {
    return Json{{"entry", number}, {"name", "e"}, {"state", state}, {"outcome", "faulted"}, {"note", note}};
  };
  const std::string why =
      "no_motion at 0.370 s: the rod moved 0.001 in where [following] expects 0.213 in, as where the pressure is off, "
      "a wire is loose or the valve is stuck; `eha read` shows whether the sensor follows the rod";
  Json cancelled = entry(2, "cancelled", "cancelled by anna before it began");
  cancelled["outcome"] = "";
  const std::string table = queue_table({entry(1, "over", why), cancelled, entry(3, "over", "M\xC3\xA4rz")});
  EXPECT_NE(table.find("\n     1  e"), std::string::npos) << table;
  EXPECT_NE(table.find("cancelled  -        cancelled by anna before it began\n"), std::string::npos) << table;
  EXPECT_EQ(table.find("..."), std::string::npos) << table;
  std::string whole = table.substr(table.find("faulted: no_motion"));
  for (std::size_t at = whole.find("\n        "); at != std::string::npos; at = whole.find("\n        ")) {
    whole.replace(at, 9, " ");
  }
  EXPECT_TRUE(whole.starts_with("faulted: " + why + "\n     2  e")) << table;
  EXPECT_NE(table.find("M\xC3\xA4rz"), std::string::npos) << table;
}

TEST(QueueTable, ListsThoseThatAreOverByWhenTheyWerePlayed) {
  const auto entry = [](int number, const std::string& state, const std::string& run = "") {
    return Json{{"entry", number}, {"name", "e"}, {"state", state}, {"run", run}};
  };
  // 1 was held for long; 4 was refused, nobody knows when.
  const std::string table =
      queue_table({entry(1, "over", "20261125T120000Z-e"), entry(2, "over", "20261125T100000Z-e"), entry(3, "held"),
                   entry(4, "over"), entry(5, "over", "20261125T101000Z-e"), entry(6, "over", "20261125T102000Z-e"),
                   entry(7, "over", "20261125T103000Z-e"), entry(8, "over", "20261125T104000Z-e")});
  std::string numbers;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > 6 && line.substr(0, 5) == "     " && std::isdigit(line[5]) != 0) numbers += line[5];
  }
  EXPECT_EQ(numbers, "678143") << table;
}

TEST(QueueTable, FitsAHundredColumnsAndMarksTheOneThatIsPlayed) {
  const std::string run = "20261125T190436Z-sweeping";
  const auto entry = [](int number, const char* state) {
    return Json{{"entry", number}, {"name", "sweeping"}, {"user", "anna"}, {"state", state}, {"duration_s", 3600.0}};
  };
  Json over = entry(1, "over");
  over.update({{"run", run}, {"outcome", "faulted"}, {"note", "no_motion at 0.370 s: the rod moved 0 in where 1 in"}});
  Json fitted = entry(2, "over");
  fitted.update({{"run", run}, {"outcome", "completed"}});
  fitted["models"] = {{{"name", "io"}, {"accepted", true}}, {{"name", "fo"}, {"accepted", true}}};
  Json stopped = entry(3, "over");
  stopped.update({{"run", run}, {"outcome", "interrupted"}, {"note", "interrupted by a stop request; the command"}});
  Json running = entry(4, "running");
  running["run"] = run;
  Json held = entry(5, "held");
  held["waits_for"] = "eha arm, then eha queue release 5: the rig was disarmed before it began: by somebody else";
  const std::string table = queue_table({over, fitted, stopped, running, held});
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
  EXPECT_NE(table.find("\n   > 4  sweeping"), std::string::npos) << table;
  EXPECT_EQ(table.find('>'), table.rfind('>')) << table;
  EXPECT_NE(table.find(run + "  completed, 2 accepted\n"), std::string::npos) << table;
  EXPECT_NE(table.find("waits for eha arm, then eha queue release 5\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\n5 is held: the rig was disarmed before it began: by somebody else\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("\n        faulted: no_motion at 0.370 s: the rod moved"), std::string::npos) << table;
  EXPECT_NE(table.find("interrupted by a stop request; the command\n"), std::string::npos) << table;
}

TEST(ProgressText, SaysHowLongAFitHasRunAndWhatKeepsItBack) {
  const Json fitting{{"state", "fitting"}, {"fitting_s", 310.0}, {"fitting_cpu_s", 4.0}};
  EXPECT_EQ(
      progress_text(fitting),
      "is being fitted, for 5:10 min so far, with 4 s of processor time (other programs keep the processors busy)");
  const Json quick{{"state", "fitting"}, {"fitting_s", 30.0}, {"fitting_cpu_s", 28.0}};
  EXPECT_EQ(progress_text(quick), "is being fitted, for 30.0 s so far, with 28 s of processor time");
  EXPECT_EQ(progress_text({{"state", "fitting"}}), "waits for its fit");
  EXPECT_EQ(progress_text({{"state", "running"}}), "is being played");
  EXPECT_EQ(progress_text({{"state", "over"}}), "");
  EXPECT_EQ(progress_text(nullptr), "") << "a run that no service knows";
}

}  // namespace
}  // namespace eha::cli
