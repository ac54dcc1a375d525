// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "config/measured_check.hpp"
#include "config/valve_estimate.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "ident/valve/supply.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::sheet {
namespace {

RunSheet example() {
  RunSheet run;
  run.rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  run.rig.limits.following->pressure_delay_s = 0.4;
  ident::ValveSheet& sheet = run.sheet;
  sheet.null_V = {-0.21, 0.006};
  sheet.dead_band_V = {0.16, 0.007};
  sheet.gain_positive_in_per_V_s = {0.15, 0.0015};
  sheet.gain_negative_in_per_V_s = {0.12, 0.0024};
  sheet.hysteresis_V = {0.002, 0.004};
  sheet.noise_in = 0.0006;
  sheet.lag_s = 0.007;
  sheet.highest_Hz = 11.5;
  sheet.responses = {{.percent = 5.0,
                      .amplitude_V = 0.25,
                      .points = {{.frequency_Hz = 0.8}, {.frequency_Hz = 11.5, .gain_dB = -4.0, .phase_deg = -100.0}},
                      .minus_3dB_Hz = ident::Measured{9.0, 0.3},
                      .minus_90deg_Hz = ident::Measured{10.1, 0.2},
                      .is_played = true},
                     {.percent = 10.0, .amplitude_V = 0.5, .is_played = true},
                     {.percent = 25.0}};
  sheet.block_V = Eigen::Vector4d(-1.0, -0.3, 0.0, 1.0);
  sheet.block_in_per_s = Eigen::Vector4d(-0.08, 0.0, 0.01, 0.15);
  return run;
}

TEST(ValveSheetText, FitsAnOrdinaryTerminalAndSaysWhatWasNotObserved) {
  for (const char* unit : {"", "mm"}) {
    std::istringstream text(sheet_text(example(), DisplayUnit(unit)));
    for (std::string line; std::getline(text, line);) EXPECT_LE(line.size(), 80U) << line;
  }
  const std::string text = sheet_text(example(), DisplayUnit("in"));
  EXPECT_NE(text.find("-0.2100 +- 0.0060 V"), std::string::npos) << text;
  EXPECT_NE(text.find("none found above 0.0100 V"), std::string::npos) << text;
  EXPECT_NE(text.find("-3 dB 9.00 +- 0.30 Hz, -90 deg 10.10 +- 0.20 Hz"), std::string::npos) << text;
  EXPECT_NE(text.find("not observed: the sines entered the dead band"), std::string::npos) << text;
  EXPECT_NE(text.find("not played"), std::string::npos) << text;
  EXPECT_NE(text.find("not observed up to 11.50 Hz"), std::string::npos) << text;
  EXPECT_NE(sheet_text(example(), DisplayUnit("mm")).find("3.81000 +- 0.03810 mm/(V s)"), std::string::npos);
}

TEST(ValveSheetText, NamesWhatTheRigFileSaysOtherwise) {
  RunSheet run = example();
  run.rig.limits.following->null_V = -0.2;
  run.rig.limits.following->null_uncertainty_V.reset();
  run.rig.limits.following->dead_band_V = 0.148 + config::kDeadBandSpare_V;
  run.rig.limits.following->dead_band_uncertainty_V = 0.01;
  std::string text = sheet_text(run, DisplayUnit("in"));
  EXPECT_NE(text.find("-0.2100 +- 0.0060 V\n                             (file: -0.2000 V, CHANGED)\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("0.1600 +- 0.0070 V\n                             (file: 0.1480 +- 0.0100 V, as before)\n"),
            std::string::npos)
      << text;
  std::vector<std::string> missing;
  const std::string html = sheet_page(run, DisplayUnit("in"), missing);
  EXPECT_NE(html.find("-0.2000 V, outside the joint interval"), std::string::npos);
  EXPECT_NE(html.find(">0.1480 ± 0.0100 V<"), std::string::npos);
  run.rig.limits.following = following_of(run);
  EXPECT_NE(sheet_page(run, DisplayUnit("in"), missing).find("<h2>The valve is as the rig file says</h2>"),
            std::string::npos);
  run.rig.limits.following->null_V = -0.2;
  EXPECT_NE(sheet_page(run, DisplayUnit("in"), missing).find("<h2>Not as the rig file says: null</h2>"),
            std::string::npos);
  run.rig.limits.following.reset();
  text = sheet_text(run, DisplayUnit("in"));
  EXPECT_EQ(text.find("file: "), std::string::npos) << text;
  EXPECT_EQ(sheet_page(run, DisplayUnit("in"), missing).find("by [following] as used"), std::string::npos);
}

TEST(ValveSheetText, NamesNoFrequencyWhereNoneWasMeasured) {
  RunSheet run = example();
  run.sheet.responses.clear();
  run.sheet.highest_Hz = 0.0;
  const std::string text = sheet_text(run, DisplayUnit("in"));
  EXPECT_EQ(text.find("0.00 Hz"), std::string::npos) << text;
  std::vector<std::string> missing;
  const std::string html = sheet_page(run, DisplayUnit("in"), missing);
  EXPECT_EQ(html.find("0.00 Hz"), std::string::npos);
  EXPECT_EQ(html.find("Measured points"), std::string::npos) << "a table without rows";
}

TEST(ValveSheetText, ClaimsHysteresisThatThereIs) {
  RunSheet run = example();
  run.sheet.hysteresis_V = {0.045, 0.004};
  run.sheet.has_hysteresis = true;
  EXPECT_NE(sheet_text(run, DisplayUnit()).find("0.0450 +- 0.0040 V"), std::string::npos);
  EXPECT_EQ(to_json(run).at("hysteresis_V").at("value"), 0.045);
  EXPECT_TRUE(to_json(example()).at("hysteresis_V").is_null());
}

TEST(ValveSheetPage, WarnsOfANullThatIsHardlyKnown) {
  RunSheet run = example();
  EXPECT_EQ(warning_of(run, DisplayUnit("in")), "");
  run.sheet.null_V.half_width = 0.072;
  EXPECT_NE(warning_of(run, DisplayUnit("in")).find("+-0.072 V only"), std::string::npos);
  std::vector<std::string> missing;
  EXPECT_NE(sheet_page(run, DisplayUnit("in"), missing).find("repair the seal or the sensor"), std::string::npos);
}

TEST(ValveSheetPage, NamesALeakWhereTheRodCreepsWithinTheDeadBand) {
  RunSheet run = example();
  std::vector<std::string> missing;
  run.sheet.creep_in_per_s = ident::Measured{0.0011, 0.0001};
  EXPECT_FALSE(ident::leak_of(run.sheet));
  EXPECT_NE(sheet_page(run, DisplayUnit("in"), missing).find("the rod hardly moves: at 0.0011 in/s"),
            std::string::npos);
  run.sheet.creep_in_per_s = ident::Measured{0.0001, 0.0002};
  EXPECT_NE(sheet_page(run, DisplayUnit("in"), missing).find("The rod stands from"), std::string::npos);
  run.sheet.creep_in_per_s = ident::Measured{-0.0171, 0.0001};
  const std::string leak = "the rod creeps at 0.017 in/s within the dead band, as 0.14 V of command would move it";
  const auto found = ident::leak_of(run.sheet);
  ASSERT_TRUE(found);
  EXPECT_EQ(ident::leak_text(*found, DisplayUnit("in")).rfind(leak, 0), 0U);
  EXPECT_EQ(ident::leak_text(*found, DisplayUnit("mm")).rfind("the rod creeps at 0.43 mm/s", 0), 0U);
  EXPECT_NE(warning_of(run, DisplayUnit("in")).find("repair the leak"), std::string::npos);
  EXPECT_EQ(ident::leak_finding(*found, DisplayUnit("in"))
                .rfind("Oil leaks past the piston or through the valve: by the valve sheet " + leak, 0),
            0U)
      << "the finding first";
  EXPECT_NE(ident::leak_finding(*found, DisplayUnit("in")).find("repair the leak first"), std::string::npos);
  const std::string html = sheet_page(run, DisplayUnit("in"), missing);
  EXPECT_EQ(html.find("The rod stands from"), std::string::npos);
  EXPECT_NE(html.find("but " + leak), std::string::npos);
  EXPECT_EQ(html.find("Points on the line on both sides, except"), std::string::npos);
  const std::size_t box = html.find("<section class=\"verdict none\"><h2>The rig leaks</h2>");
  ASSERT_NE(box, std::string::npos);
  EXPECT_LT(box, html.find("Warning: ")) << "a warning stands in its box";
  EXPECT_NE(html.find("Next: repair the leak first"), std::string::npos);
  EXPECT_EQ(html.find("-o rig-new.toml</code> writes them"), std::string::npos);
}

TEST(ValveSheetPage, AsksForTheSupplyFirstWhereBothGainsHaveChangedAlike) {
  RunSheet run = example();
  run.rig.limits.following = following_of(run);
  run.written = WrittenRig{"rig-new.toml", "eha check rig-new.toml && eha disarm && cp rig-new.toml rig.toml"};
  run.sheet.gain_positive_in_per_V_s.value *= 0.57;
  run.sheet.gain_negative_in_per_V_s.value *= 0.56;
  ASSERT_TRUE(supply_factor(run));
  EXPECT_NE(warning_of(run, DisplayUnit()).find(ident::kSupplyFirst), std::string::npos);
  EXPECT_EQ(next_of(run, {}).find("eha disarm"), std::string::npos) << next_of(run, {});
  run.sheet.gain_negative_in_per_V_s.value /= 0.56;
  EXPECT_FALSE(supply_factor(run)) << "one gain alone is the valve's";
  run.sheet.gain_negative_in_per_V_s.value *= 0.56;
  run.rig.limits.following->gain_uncertainty_percent.reset();
  EXPECT_FALSE(supply_factor(run)) << "of an estimate";
}

TEST(ValveSheetPage, BeginsWithItsQuantitiesAsATable) {
  std::vector<std::string> missing;
  const std::string html = sheet_page(example(), DisplayUnit("in"), missing);
  const std::size_t row = html.find("<td>null</td><td>-0.2100 ± 0.0060 V</td>");
  ASSERT_NE(row, std::string::npos) << "a phone shows a table, not lines of 80 columns";
  EXPECT_LT(row, html.find("<svg"));
  EXPECT_EQ(html.find("+- 0.0060"), std::string::npos);
}

TEST(ValveSheetPage, AsksForTheLinesUntilTheRigFileHasThem) {
  RunSheet run = example();
  std::vector<std::string> missing;
  const std::string asks = "Put the lines below into the rig file.";
  EXPECT_NE(sheet_page(run, DisplayUnit(), missing).find(asks), std::string::npos);
  run.folder = "/runs/sheet";
  EXPECT_NE(
      sheet_page(run, DisplayUnit(), missing).find("Next: <code>eha characterise /runs/sheet -o rig-new.toml</code>"),
      std::string::npos);
  run.rig.limits.following = following_of(run);
  EXPECT_TRUE(is_in_rig_file(run));
  EXPECT_EQ(sheet_page(run, DisplayUnit(), missing).find(asks), std::string::npos);
  EXPECT_NE(sheet_page(run, DisplayUnit(), missing).find("The rig file as used had values within"), std::string::npos);
  EXPECT_EQ(sheet_page(run, DisplayUnit(), missing).find("0 dB and 0 deg"), std::string::npos)
      << "the phase is not relative";
  run.sheet.null_V.value += 0.01;
  EXPECT_NE(sheet_page(run, DisplayUnit(), missing).find(asks), std::string::npos);
}

TEST(ValveSheetPage, SaysThatTheRigFileHasTheNumbersThatWereWrittenAfterTheRun) {
  const test::TemporaryFolder folder;
  RunSheet run = example();
  run.rig.limits.following = following_of(run);
  run.rig.limits.following->dead_band_V += 0.001;  // within the interval, and not the sheet's
  std::vector<std::string> missing;
  const std::string before = sheet_page(run, DisplayUnit(), missing);
  EXPECT_NE(before.find("The rig file as used had values within these intervals"), std::string::npos);
  const std::string text = run.rig.text;
  const std::size_t first = text.find("[following]");
  const std::size_t end = text.find("# How ticks are kept.");
  run.access.rig_file = folder.write("rig.toml", text).string();
  EXPECT_FALSE(is_written_since(run));
  folder.write("rig.toml", text.substr(0, first) + rig_lines(run) + text.substr(end));
  EXPECT_TRUE(is_written_since(run));
  EXPECT_NE(sheet_page(run, DisplayUnit(), missing).find(run.access.rig_file + " has these numbers."),
            std::string::npos);
  folder.write("rig.toml", "no rig");
  EXPECT_FALSE(is_written_since(run));
}

TEST(ValveSheetPage, NamesTheRigFileThatWasWrittenAndTheCommandAsTheTerminalDoes) {
  RunSheet run = example();
  run.rig.limits.following = following_of(run);
  run.written = WrittenRig{"rig-new.toml", "eha check rig-new.toml"};
  std::vector<std::string> missing;
  const std::string html = sheet_page(run, DisplayUnit(), missing);
  EXPECT_NE(
      html.find("Next: <code>eha check rig-new.toml</code> checks rig-new.toml, the rig file with these numbers."),
      std::string::npos)
      << html.substr(0, 8000);
  EXPECT_EQ(html.find("nothing to do"), std::string::npos);
  EXPECT_EQ(html.find("The rig file as used"), std::string::npos);
}

TEST(RigLines, AreReadBackAsTheSheet) {
  const RunSheet run = example();
  const std::string text = run.rig.text;
  const std::size_t first = text.find("[following]");
  const std::size_t end = text.find("# How ticks are kept.");
  const config::RigConfig changed =
      config::parse_rig(text.substr(0, first) + rig_lines(run) + text.substr(end), "changed.toml");
  const config::ValveEstimate valve = config::valve_estimate(changed.limits.following.value());
  EXPECT_NEAR(valve.null_V, -0.21, 1e-9);
  EXPECT_NEAR(valve.dead_band_V, 0.16, 1e-9);
  EXPECT_NEAR(valve.gain_positive_in_per_V_s, 0.15, 1e-9);
  EXPECT_NEAR(valve.gain_negative_in_per_V_s, 0.12, 1e-9);
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(*changed.limits.following);
  EXPECT_NEAR(uncertainty.null_V, 0.006 / 1.96, 1e-9);
  EXPECT_NEAR(uncertainty.dead_band_V, 0.007 / 1.96, 1e-9);
  EXPECT_NEAR(uncertainty.gain_share, 0.02 / 1.96, 1e-9);
  EXPECT_EQ(changed.limits.following->pressure_delay_s, 0.4) << "kept";
  EXPECT_TRUE(config::is_as_measured(changed));
}

TEST(RigLines, AreInMillimetresForARigThatIs) {
  RunSheet run = example();
  run.rig.units = "mm";
  const std::string lines = rig_lines(run);
  EXPECT_EQ(lines.find("_in_"), std::string::npos) << lines;
  EXPECT_EQ(lines.find("_in "), std::string::npos) << lines;
  const std::string text = run.rig.text;
  const std::size_t first = text.find("[following]");
  const std::size_t end = text.find("# How ticks are kept.");
  const config::RigConfig changed = config::parse_rig(text.substr(0, first) + lines + text.substr(end), "changed.toml");
  const config::ValveEstimate valve = config::valve_estimate(changed.limits.following.value());
  EXPECT_NEAR(valve.gain_positive_in_per_V_s, 0.15, 1e-4);
  EXPECT_NEAR(valve.gain_negative_in_per_V_s, 0.12, 1e-4);
  EXPECT_NEAR(changed.limits.following->limit_in, sheet::following_of(run).limit_in, 1e-6);
  EXPECT_TRUE(config::is_as_measured(changed));
  EXPECT_NE(experiment_lines(run).find("displacement_mm = "), std::string::npos);
}

TEST(RigLines, CarryASumThatAnotherDigitBreaks) {
  RunSheet run = example();
  // Values that a file rounds, in inches and in millimetres.
  run.sheet.gain_positive_in_per_V_s = {0.123456, 0.00123456};
  run.sheet.gain_negative_in_per_V_s = {0.0987654, 0.00123456};
  run.sheet.null_V = {-0.0000123, 0.0123456};
  run.sheet.dead_band_V = {0.123456, 0.00987654};
  for (const char* units : {"in", "mm"}) {
    run.rig.units = units;
    const std::string lines = rig_lines(run);
    const std::string text = run.rig.text;
    const auto read = [&](const std::string& following) {
      const std::size_t first = text.find("[following]");
      const std::size_t end = text.find("# How ticks are kept.");
      return config::parse_rig(text.substr(0, first) + following + text.substr(end), "r.toml");
    };
    EXPECT_TRUE(config::is_as_measured(read(lines))) << lines;
    for (const char* key :
         {"gain_positive_", "gain_negative_", "null_V", "dead_band_V", "null_uncertainty_V", "dead_band_uncertainty_V",
          "gain_uncertainty_percent", "measured_check", "measured_rig_check"}) {
      const std::size_t value = lines.find(" = ", lines.find(key)) + 3;
      for (std::size_t at = value; lines[at] != ' ' && lines[at] != '\n'; ++at) {
        if (lines[at] < '0' || lines[at] > '8') continue;
        std::string slipped = lines;
        ++slipped[at];
        if (slipped[value] == '0' && slipped[value + 1] != '.') continue;  // no TOML
        EXPECT_FALSE(config::is_as_measured(read(slipped))) << key << '\n' << slipped;
      }
    }
    std::string without = lines;
    without.erase(without.find("measured_check"));
    EXPECT_FALSE(config::is_as_measured(read(without)));
  }
}

TEST(ValveSheetPage, HoldsTheSheetAndItsFigures) {
  std::vector<std::string> missing;
  const std::string page = sheet_page(example(), DisplayUnit("in"), missing);
  EXPECT_NE(page.find("Flow curve"), std::string::npos);
  EXPECT_NE(page.find("null_uncertainty_V = 0.006"), std::string::npos);
  EXPECT_EQ(page.find("http"), page.find("http://www.w3.org")) << "nothing from the network";
}

}  // namespace
}  // namespace eha::sheet
