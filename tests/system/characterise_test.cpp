// SPDX-License-Identifier: GPL-3.0-or-later
// The valve sheet and the sensor's calibration, as a user gets them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// One run for all cases.
class Characterise : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    ended_ = new Ended(run_eha({"characterise", "--local", "--fast", "--rig", rig(), "-o", "runs"}, folder_->path()));
    for (const auto& entry : fs::directory_iterator(folder_->path() / "runs")) run_ = entry.path();
  }
  static void TearDownTestSuite() {
    delete ended_;
    delete folder_;
  }
  static std::string rig() { return source_file("config/rigs/sim.toml"); }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* ended_ = nullptr;
  static inline fs::path run_;
};

TEST_F(Characterise, PrintsASheetThatFitsTheTerminalAndTheRig) {
  ASSERT_EQ(ended_->code, 0) << ended_->err;
  std::istringstream text(ended_->out);
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("Next: ")) continue;
    EXPECT_LE(line.size(), 80U) << line;
  }
  const Json sheet = Json::parse(content_of(run_ / "valve_sheet.json"));
  EXPECT_NEAR(sheet.at("null_V").at("value").get<double>(), -0.2, 0.01);
  EXPECT_NEAR(sheet.at("dead_band_V").at("value").get<double>(), 0.15, 0.01);
  EXPECT_NEAR(sheet.at("gain_positive_in_per_V_s").at("value").get<double>(), 0.148, 0.005);
  EXPECT_NEAR(sheet.at("gain_negative_in_per_V_s").at("value").get<double>(), 0.130, 0.005);
  EXPECT_TRUE(sheet.at("hysteresis_V").is_null());
  EXPECT_TRUE(sheet.at("natural_frequency_Hz").is_null()) << "40 Hz, and 12 Hz were played";
  EXPECT_NE(content_of(run_ / "report.html").find("Flow curve"), std::string::npos);
}

TEST_F(Characterise, IsReportedAsASheetByTheReportToo) {
  const Ended ended = run_eha({"report", run_.string()}, folder_->path());
  EXPECT_EQ(ended.code, 0) << ended.err;
  const std::string page = content_of(run_ / "report.html");
  EXPECT_NE(page.find("Flow curve"), std::string::npos);
  EXPECT_EQ(page.find("No model in this run"), std::string::npos);
}

TEST_F(Characterise, IsARunOfAtMostThreeMinutesWithinTheTravel) {
  const Json manifest = Json::parse(content_of(run_ / "run.json"));
  EXPECT_EQ(manifest.at("outcome"), "completed");
  EXPECT_EQ(manifest.at("experiment").at("characterises"), true);
  EXPECT_LT(manifest.at("report").at("counters").at("ticks").get<double>() * 0.001, 180.0);
  bool lists_sheet = false;
  for (const Json& file : manifest.at("files")) lists_sheet = lists_sheet || file.at("path") == "valve_sheet.json";
  EXPECT_TRUE(lists_sheet);
  EXPECT_TRUE(fs::exists(run_ / "raw.h5"));
  EXPECT_TRUE(fs::is_empty(run_ / "models")) << "nothing is fitted";
}

TEST_F(Characterise, GivesLinesThatTheRigFileTakes) {
  const std::string out = ended_->out;
  const std::size_t first = out.find("[following]");
  ASSERT_NE(first, std::string::npos);
  const std::string lines = out.substr(first, out.find("For experiment files") - first);
  std::string text = content_of(rig());
  const std::size_t old = text.find("[following]");
  text.replace(old, text.find("# How ticks are kept.") - old, lines);
  folder_->write("rig.toml", text);
  const Ended checked = run_eha({"check", "rig.toml"}, folder_->path());
  EXPECT_EQ(checked.code, 0) << checked.err;
}

TEST_F(Characterise, WritesTheRigFileInOneGoAndOverwritesNone) {
  const Ended ended = run_eha({"characterise", run_.string(), "-o", "new.toml"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out.find("[following]"), std::string::npos) << ended.out;
  const std::string text = content_of(folder_->path() / "new.toml");
  const std::string old = content_of(rig());
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), std::count(old.begin(), old.end(), '\n') + 2)
      << "comments stay, the two sums are added";
  EXPECT_NE(text, old);
  EXPECT_EQ(run_eha({"check", "new.toml"}, folder_->path()).code, 0);
  const Ended again = run_eha({"characterise", run_.string(), "-o", "new.toml"}, folder_->path());
  EXPECT_EQ(again.code, static_cast<int>(ExitCode::usage)) << again.err;
  EXPECT_NE(again.err.find("no rig file is overwritten"), std::string::npos) << again.err;
}

TEST_F(Characterise, ShowsWhatARunTellsThatLateTicksEndedAndWritesNoRigFileOfIt) {
  const fs::path cut = folder_->path() / "cut";
  fs::copy(run_, cut, fs::copy_options::recursive);
  Json manifest = Json::parse(content_of(cut / "run.json"));
  manifest["outcome"] = "deadline";
  std::ofstream(cut / "run.json") << manifest.dump();
  const Ended ended = run_eha({"characterise", "cut", "--json"}, folder_->path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json sheet = Json::parse(ended.out);
  EXPECT_NEAR(sheet.at("null_V").at("value").get<double>(), -0.2, 0.01);
  EXPECT_GT(sheet.at("cut_at_s").get<double>(), 100.0);
  EXPECT_FALSE(sheet.contains("following"));
  const Ended shown = run_eha({"characterise", "cut"}, folder_->path());
  EXPECT_NE(shown.out.find("PARTIAL"), std::string::npos) << shown.out;
  EXPECT_EQ(shown.out.find("[following]"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("Next: eha doctor"), std::string::npos) << shown.out;
  const Ended refused = run_eha({"characterise", "cut", "-o", "cut.toml"}, folder_->path());
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::bad_data)) << refused.err;
  EXPECT_FALSE(fs::exists(folder_->path() / "cut.toml"));
}

TEST_F(Characterise, NoLongerCountsAsMeasuredAfterACalibrationOfAnotherScale) {
  ASSERT_EQ(run_eha({"characterise", run_.string(), "-o", "measured.toml"}, folder_->path()).code, 0);
  const auto calibrated = [&](const char* middle, const char* high, const char* made) {
    return run_eha({"calibrate", "--rig", "measured.toml", "--at", "0.6in=1", "--at", middle, "--at", high, "-o", made},
                   folder_->path());
  };
  const Ended near = calibrated("3in=5", "5.4in=9", "near.toml");
  ASSERT_EQ(near.code, 0) << near.err;
  EXPECT_EQ(near.err.find("no longer counts as measured"), std::string::npos) << near.err;
  const auto refused = [&](const char* middle, const char* high, const char* made) {
    const Ended ended = calibrated(middle, high, made);
    EXPECT_EQ(ended.code, static_cast<int>(ExitCode::bad_data)) << ended.err;
    EXPECT_FALSE(fs::exists(folder_->path() / made));
    const std::size_t at = ended.err.find("eha calibrate --rig ");
    EXPECT_NE(at, std::string::npos) << ended.err;
    std::istringstream line(ended.err.substr(at, ended.err.find('\n', at) - at));
    std::vector<std::string> again{std::istream_iterator<std::string>(line), {}};
    EXPECT_EQ(again.back(), "--sensor-moved");
    again.erase(again.begin());
    return run_eha(again, folder_->path());
  };
  const Ended elsewhere = refused("3.5in=5", "6.4in=9", "elsewhere.toml");
  ASSERT_EQ(elsewhere.code, 0) << elsewhere.err;
  EXPECT_NE(elsewhere.err.find("where measured.toml has"), std::string::npos) << elsewhere.err;
  EXPECT_EQ(elsewhere.err.find("no longer counts as measured"), std::string::npos) << elsewhere.err;
  const Ended far = refused("3in=3.5", "5.4in=6", "far.toml");
  ASSERT_EQ(far.code, 0) << far.err;
  EXPECT_NE(far.err.find("no longer counts as measured"), std::string::npos) << far.err;
  EXPECT_NE(far.err.find("eha characterise --without-following -o rig-bare.toml --local --fast --rig far.toml`"),
            std::string::npos)
      << far.err;
}

/// The limits of the run's own file may be old.
TEST_F(Characterise, WritesItsNumbersIntoTheRigFileThatIsNamed) {
  std::string narrow = content_of(rig());
  const std::string travel = "travel_max_in = 5.75";
  narrow.replace(narrow.find(travel), travel.size(), "travel_max_in = 4.0 ");
  folder_->write("narrow.toml", narrow);
  const auto written_into = [&](const std::string& named, const std::string& made) {
    return run_eha({"characterise", run_.string(), "-o", made, "--local", "--rig", named}, folder_->path());
  };
  const Ended ended = written_into("narrow.toml", "narrow-new.toml");
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.err.find("narrow.toml has changed since this run"), std::string::npos) << ended.err;
  EXPECT_NE(content_of(folder_->path() / "narrow-new.toml").find("travel_max_in = 4.0 "), std::string::npos);
  narrow.replace(narrow.find("name = \""), 8, "name = \"other ");
  folder_->write("other.toml", narrow);
  const Ended refused = written_into("other.toml", "other-new.toml");
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::usage)) << refused.err;
  EXPECT_NE(refused.err.find("--rig other.toml: it is of the rig"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(folder_->path() / "other-new.toml"));
}

TEST_F(Characterise, ShowsTheSheetOfARunAgainAndRefusesAnother) {
  const Ended again = run_eha({"characterise", run_.string(), "--json"}, folder_->path());
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(Json::parse(again.out).at("schema"), "eha-valve-sheet/1");
  const Ended fitted = run_eha({"fit", run_.string(), "--json"}, folder_->path());
  EXPECT_EQ(Json::parse(fitted.out).at("schema"), "eha-valve-sheet/1") << "what such a run is for";
  const Ended placed =
      run_eha({"goto", "3in", "--local", "--fast", "--rig", rig(), "--output", "placed", "--json"}, folder_->path());
  ASSERT_EQ(placed.code, 0) << placed.err;
  const Ended refused =
      run_eha({"characterise", Json::parse(placed.out).at("run").get<std::string>()}, folder_->path());
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::bad_data)) << refused.err;
  EXPECT_NE(refused.err.find("is no run of [characterise]"), std::string::npos) << refused.err;
}

/// The sample rig file with another null of [following] than the valve's.
std::string rig_with_null(const char* null_V) {
  std::string text = content_of(source_file("config/rigs/sim.toml"));
  const std::string sound = "\nnull_V = -0.2 ";
  return text.replace(text.find(sound), sound.size(), std::string("\nnull_V = ") + null_V + " ");
}

TEST(CharacteriseWithAWrongNull, SaysHowTheValveIsMeasuredWithoutFollowing) {
  const TemporaryFolder folder;
  for (const char* null_V : {"0.9", "-1.2", "0.4"}) {
    folder.write("rig.toml", rig_with_null(null_V));
    const Ended ended = run_eha({"characterise", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
    EXPECT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
    EXPECT_NE(ended.err.find("a wrong [following] of rig.toml can cause this"), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("e-05"), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("the run ended before its first row"), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("the partial record is in"), std::string::npos) << "there is none: " << ended.err;
    EXPECT_EQ(ended.err.find("eha plot"), std::string::npos) << ended.err;
    const Ended placed = run_eha({"goto", "60mm", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
    const std::size_t plot = placed.err.find("`eha plot ");
    ASSERT_NE(plot, std::string::npos) << placed.err;
    const std::string run = placed.err.substr(plot + 10, placed.err.find('`', plot + 1) - plot - 10);
    EXPECT_EQ(run_eha({"plot", run, "-o", "way.svg"}, folder.path()).code, 0) << run;
    folder.write("rig-bare.toml", "");
    EXPECT_NE(run_eha({"goto", "60mm", "--local", "--fast", "--rig", "rig.toml"}, folder.path())
                  .out.find("Next: eha characterise --without-following -o rig-bare-2.toml"),
              std::string::npos);
    fs::remove(folder.path() / "rig-bare.toml");
  }
  std::string text = rig_with_null("0.9");
  const std::size_t first = text.find("[following]");
  for (std::size_t line = first; text.compare(line, 6, "# How ") != 0; line = text.find('\n', line) + 1) {
    text.insert(line, "# ");
  }
  folder.write("rig.toml", text);
  const Ended anew = run_eha({"characterise", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(anew.code, 0) << anew.err;
}

TEST(CharacteriseAndAShortRun, LeaveTheSheetInForceWhereTheRecordKnowsTheNullLessWell) {
  const TemporaryFolder folder;
  std::string text = content_of(source_file("config/experiments/paper.toml"));
  const std::string length = "duration_s = 50.0";
  folder.write("short.toml", text.replace(text.find(length), length.size(), "duration_s = 18.0"));
  const Ended ended =
      run_eha({"run", "short.toml", "--local", "--fast", "--rig", source_file("config/rigs/sim.toml")}, folder.path());
  EXPECT_NE(ended.out.find("null -0.2"), std::string::npos) << ended.out;
  EXPECT_EQ(ended.err.find("are for another valve"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.out.find("eha characterise ", ended.out.find("Next: ")), std::string::npos) << ended.out;
  EXPECT_EQ(ended.err.find("eha characterise"), std::string::npos) << ended.err;
}

TEST(CharacteriseLeaky, WarnsThatTheNullIsNotKnownWellEnough) {
  const TemporaryFolder folder;
  const Ended ended =
      run_eha({"characterise", "--local", "--fast", "--rig", source_file("config/rigs/sim-leaky.toml"), "-o", "runs"},
              folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.err.find("the following check needs 0.03 V"), std::string::npos) << ended.err;
  const Ended written = run_eha(
      {"characterise", "--local", "--fast", "--rig", source_file("config/rigs/sim-leaky.toml"), "-o", "rig-new.toml"},
      folder.path());
  EXPECT_NE(written.err.find("repair the leak"), std::string::npos) << written.err;
  EXPECT_EQ(written.out.find("Next: eha check"), std::string::npos) << "which advises another thing: " << written.out;
  EXPECT_NE(written.out.find("Next: xdg-open "), std::string::npos) << written.out;
}

TEST(Calibrate, RefusesARulerThatIsReadFromTheOtherEnd) {
  const TemporaryFolder folder;
  folder.write("rig.toml", content_of(source_file("config/rigs/sim.toml")));
  const Ended ended = run_eha({"calibrate", "--rig", "rig.toml", "--at", "5.4in=0.833", "--at", "2.95in=4.917", "--at",
                               "0.5in=9.0", "-o", "new.toml"},
                              folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::bad_data));
  EXPECT_NE(ended.err.find("opposite sign"), std::string::npos) << ended.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "new.toml"));
}

TEST(Calibrate, WritesANewRigFileBesideTheOldOne) {
  const TemporaryFolder folder;
  const std::string before = content_of(source_file("config/rigs/sim.toml"));
  folder.write("rig.toml", before);
  const Ended ended = run_eha({"calibrate", "--rig", "rig.toml", "--at", "0.51in=0.833", "--at", "2.95in=4.917", "--at",
                               "137.16mm=9.0", "-o", "new.toml", "--json"},
                              folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const Json found = Json::parse(ended.out);
  EXPECT_NEAR(found.at("scale_in_per_V").get<double>(), 0.5988, 0.001);
  EXPECT_NEAR(found.at("offset_in").get<double>(), 0.0098, 0.002);
  EXPECT_EQ(found.at("points").size(), 3U);
  EXPECT_EQ(content_of(folder.path() / "rig.toml"), before);
  EXPECT_EQ(run_eha({"check", "new.toml"}, folder.path()).code, 0);
  // Millimetres without their unit.
  const Ended inches = run_eha({"calibrate", "--rig", "rig.toml", "--at", "75=4.917", "--at", "50=3.28", "--at",
                                "110=7.218", "-o", "inches.toml"},
                               folder.path());
  EXPECT_EQ(inches.code, static_cast<int>(ExitCode::bad_data));
  EXPECT_NE(inches.err.find("beyond the travel limits"), std::string::npos) << inches.err;
  EXPECT_FALSE(fs::exists(folder.path() / "inches.toml"));
  const Ended again = run_eha({"calibrate", "--rig", "rig.toml", "--at", "0.5in=0.833", "--at", "2.95in=4.917", "--at",
                               "5.4in=9.0", "-o", "new.toml"},
                              folder.path());
  EXPECT_EQ(again.code, static_cast<int>(ExitCode::usage)) << "no rig file is overwritten";
}

TEST(Calibrate, SaysWhatItDoesNotKnowOfAnExactLineAndOfAWrongReading) {
  const TemporaryFolder folder;
  folder.write("rig.toml", content_of(source_file("config/rigs/sim.toml")));
  const Ended exact = run_eha(
      {"calibrate", "--rig", "rig.toml", "--at", "0.6in=1", "--at", "3in=5", "--at", "5.4in=9", "-o", "exact.toml"},
      folder.path());
  ASSERT_EQ(exact.code, 0) << exact.err;
  EXPECT_NE(exact.out.find("(scale +- at least 0.000"), std::string::npos) << exact.out;
  EXPECT_NE(exact.out.find("the ruler's error is not in them"), std::string::npos) << exact.out;
  const Ended wrong = run_eha({"calibrate", "--rig", "rig.toml", "--at", "0.6in=1", "--at", "3.06in=5", "--at",
                               "5.4in=9", "--tolerance", "3mm", "-o", "wrong.toml"},
                              folder.path());
  ASSERT_EQ(wrong.code, 0) << wrong.err;
  EXPECT_NE(wrong.err.find("the scale is known to +- "), std::string::npos) << wrong.err;
  EXPECT_NE(wrong.err.find("the one at 3.06 in: measure it again"), std::string::npos) << wrong.err;
  EXPECT_NE(exact.out.find("Next: eha check exact.toml"), std::string::npos) << exact.out;
  EXPECT_EQ(wrong.out.find("eha check"), std::string::npos) << "it is not to be put in force: " << wrong.out;
  EXPECT_NE(wrong.out.find("Next: eha calibrate --rig rig.toml --tolerance 3mm -o wrong-2.toml"), std::string::npos)
      << wrong.out;
}

TEST(Calibrate, TakesACsvRefusesABadPositionAndTooFew) {
  const TemporaryFolder folder;
  folder.write("rig.toml", content_of(source_file("config/rigs/sim.toml")));
  folder.write("pairs.csv", "position_in,voltage_V\n0.5,0.833\n1.7,2.833\n2.99,4.917\n4.2,7.0\n5.4,9.0\n");
  const auto written = [&] {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
      files += entry.path().filename().string().starts_with("rig-20") ? 1 : 0;
    }
    return files;
  };
  const Ended refused = run_eha({"calibrate", "--rig", "rig.toml", "--pairs", "pairs.csv"}, folder.path());
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::bad_data)) << refused.err;
  EXPECT_NE(refused.err.find("nothing is written: 2.99 in is 0.04 in off the line through the others"),
            std::string::npos)
      << refused.err;
  EXPECT_EQ(refused.out.find("Next:"), std::string::npos) << refused.out;
  EXPECT_EQ(written(), 0U);
  const Ended allowed =
      run_eha({"calibrate", "--rig", "rig.toml", "--pairs", "pairs.csv", "--tolerance", "2mm"}, folder.path());
  EXPECT_EQ(allowed.code, 0) << allowed.err;
  EXPECT_EQ(written(), 1U) << "beside the old one, with the date in its name";
  const Ended few = run_eha({"calibrate", "--rig", "rig.toml", "--at", "1in=1", "--at", "2in=2"}, folder.path());
  EXPECT_EQ(few.code, static_cast<int>(ExitCode::bad_data));
  EXPECT_NE(few.err.find("at least 3"), std::string::npos) << few.err;
  EXPECT_EQ(run_eha({"calibrate", "--rig", "rig.toml", "--at", "far=1"}, folder.path()).code,
            static_cast<int>(ExitCode::usage));
}

TEST(Calibrate, TakesNumbersAloneInTheUnitsOfTheRigAndWritesThem) {
  const TemporaryFolder folder;
  folder.write("rig.toml", "units = \"mm\"\n" + content_of(source_file("config/rigs/sim.toml")));
  const Ended ended = run_eha({"calibrate", "--rig", "rig.toml", "--at", "10=0.656", "--at", "75=4.921", "--at",
                               "140 mm=9.186", "--tolerance", "0.1", "-o", "new.toml", "--json"},
                              folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NEAR(Json::parse(ended.out).at("scale_in_per_V").get<double>(), 0.6, 0.001);
  const std::string text = content_of(folder.path() / "new.toml");
  EXPECT_NE(text.find("scale_mm_per_V = 15.2"), std::string::npos) << text;
  EXPECT_EQ(text.find("scale_in_per_V ="), std::string::npos) << text;
  EXPECT_EQ(run_eha({"check", "new.toml"}, folder.path()).code, 0);
  const Ended comma = run_eha({"calibrate", "--rig", "rig.toml", "--at", "10=0,656", "--at", "74,989mm=4,9205V", "--at",
                               "14,0 cm=9,186", "-o", "comma.toml", "--json"},
                              folder.path());
  ASSERT_EQ(comma.code, 0) << comma.err;
  EXPECT_NEAR(Json::parse(comma.out).at("points").at(1).at("position_in").get<double>(), 74.989 / 25.4, 1e-9);
  EXPECT_EQ(run_eha({"calibrate", "--rig", "rig.toml", "--at", "1,0,5=0,656"}, folder.path()).code,
            static_cast<int>(ExitCode::usage));
  folder.write("ruler.csv", "Lineal [cm];U [V]\n1,00;0,656\n7,50;4,921\n14,00;9,186\n");
  const Ended pairs =
      run_eha({"calibrate", "--rig", "rig.toml", "--pairs", "ruler.csv", "-o", "cm.toml", "--json"}, folder.path());
  ASSERT_EQ(pairs.code, 0) << pairs.err;
  EXPECT_NEAR(Json::parse(pairs.out).at("scale_in_per_V").get<double>(), 0.6, 0.001);
  const Ended narrow = run_eha({"calibrate", "--rig", "rig.toml", "--at", "10=0.656", "--at", "75.2=4.921", "--at",
                                "140=9.186", "--tolerance", "0.1"},
                               folder.path());
  EXPECT_EQ(narrow.code, static_cast<int>(ExitCode::bad_data)) << "0.1 mm, not 0.1 in: " << narrow.err;
}

}  // namespace
}  // namespace eha::test
