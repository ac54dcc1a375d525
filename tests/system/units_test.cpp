// SPDX-License-Identifier: GPL-3.0-or-later
// A rig whose file says units = "mm": nothing that its user reads, draws or exports is in inches.
// Exceptions, which keep the record's unit: records and their columns, run.json, --json, and names of keys in files.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Lines of a text in which a length in inches stands.
std::vector<std::string> lines_with_inches(const std::string& text) {
  static const std::regex inches(R"(\d\s*in\b|_in\b|\bin/s|\binch|in/\(?V)");
  // "2 in the queue", "3 in a row", "50.00 in all", "0.002 in 20 s": a number before the word. Two names of keys.
  static const std::regex word(
      R"(\d\s+in\s+(the|a|all|order|this|one|\d+ s)\b|(place\.displacement|max_abs_error)_in\b)");
  std::vector<std::string> found;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = std::regex_replace(text.substr(begin, end - begin), word, "");
    if (std::regex_search(line, inches)) found.push_back(line);
    begin = end + 1;
  }
  return found;
}

class MillimetreRig : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const std::string rig = content_of(source_file("config/rigs/sim.toml"));
    folder_->write("rig.toml", "units = \"mm\"\n" + rig);
    folder_->write("short.toml",
                   "schema = 1\nname = \"short\"\nduration_s = 20.0\n[excitation]\nkind = \"multisine\"\n"
                   "offset_V = -0.25\ntones = [ { frequency_Hz = 0.1, amplitude_V = 1.5 }, { frequency_Hz = 0.4, "
                   "amplitude_V = 1.2 } ]\n[record]\ndiscard_s = 2.0\ndecimation = 40\n");
    ran_ = new Ended(eha({"run", "short.toml", "--local", "--fast", "--rig", "rig.toml"}));
    for (const auto& entry : fs::directory_iterator(folder_->path() / "runs")) {
      if (!entry.is_symlink()) run_ = fs::path("runs") / entry.path().filename();
    }
    const json manifest = json::parse(content_of(folder_->path() / run_ / "run.json"));
    for (const auto& model : manifest.at("identification").at("models")) {
      models_.push_back((run_ / model.at("file").get<std::string>()).string());
    }
  }
  static void TearDownTestSuite() {
    delete ran_;
    delete folder_;
  }
  static Ended eha(const std::vector<std::string>& words) { return run_eha(words, folder_->path()); }

  static void expect_no_inches(const std::string& what, const std::string& text) {
    for (const std::string& line : lines_with_inches(text)) ADD_FAILURE() << what << ": " << line;
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline Ended* ran_ = nullptr;
  static inline fs::path run_;
  static inline std::vector<std::string> models_;
};

TEST_F(MillimetreRig, ShowsNoInches) {
  ASSERT_TRUE(ran_->code == 0 || ran_->code == 3) << ran_->err;
  expect_no_inches("eha run", ran_->out + ran_->err);
  ASSERT_FALSE(models_.empty()) << ran_->out << ran_->err;
  const std::string run = run_.string();
  const std::string model = models_.front();
  const std::string input = run + "/data_40ms.csv";
  const Ended tuned = eha({"tune", model, "--rig", "rig.toml", "-o", "axis.toml"});
  ASSERT_EQ(tuned.code, 0) << tuned.err;
  expect_no_inches("eha tune", tuned.out + tuned.err);
  expect_no_inches("page of eha tune", content_of(folder_->path() / "axis.html"));
  folder_->write("cycle.csv", "time_s,position_mm\n0,60\n2,60\n6,70\n9,70\n");
  const std::vector<std::vector<std::string>> commands{
      {"runs", "list"},
      {"runs", "show", run},
      {"runs", "show", run_.filename().string()},
      {"check", "rig.toml"},
      {"check", "short.toml", "--rig", "rig.toml"},
      {"check", "short.toml", "--rig", "rig.toml", "--at", "75mm"},
      {"read", "--local", "--rig", "rig.toml"},
      {"goto", "75mm", "--local", "--fast", "--rig", "rig.toml", "--output", "placed"},
      {"goto", "75", "mm", "--local", "--fast", "--rig", "rig.toml", "--output", "placed"},
      {"goto", "200mm", "--local", "--fast", "--rig", "rig.toml"},
      {"goto", "145mm", "--local", "--fast", "--rig", "rig.toml"},
      {"jog", "+5mm", "--local", "--fast", "--rig", "rig.toml", "--output", "placed"},
      {"validate", model, run},
      {"simulate", model, input},
      {"plot", model},
      {"plot", run},
      {"export", model, "--format", "octave"},
      {"export", model, "--format", "matlab"},
      {"export", model, "--format", "python"},
      {"export", model, "--format", "c"},
      {"export", model, "--format", "ss"},
      {"export", model, "--format", "tf"},
      {"export", model, "--format", "json"},
      {"fit", run, "--model", "integrator_lag", "-o", "m"},
      {"fit", run, "--model", "integrator_lag", "-o", "m", "-v"},
      {"fit", run, "--model", "io", "--input-map", "valve", "--split", "1", "-o", "m"},
      {"export", model, "--format", "fmu", "-o", "rod.fmu"},
      {"plot", run + "/fit.csv"},
      {"plot", run + "/frequency_response.csv"},
      {"plot", "axis.toml"},
      {"report", "axis.toml", "-o", "axis_again.html"},
      {"track", "axis.toml", "--local", "--fast", "--rig", "rig.toml", "--hold", "5", "-o", "tracks"},
      {"track", "axis.toml", "cycle.csv", "--local", "--fast", "--rig", "rig.toml", "-o", "cycles"},
      {"check", "axis.toml", "--rig", "rig.toml"},
      {"export", "axis.toml", "--format", "c"},
      {"export", "axis.toml", "--format", "st"},
      {"export", "axis.toml", "--format", "octave"},
      {"export", "axis.toml", "--format", "python"},
      {"export", "axis.toml", "--format", "simulink"},
      {"export", "axis.toml", "--format", "csv"},
      {"compare", run, run},
      {"compare", run, run, "-o", "changes.html"},
      {"compare", model, run},
      {"compare", model, model},
      {"report", run, "-o", "report.html"},
      {"doctor", "--rig", "rig.toml"},
      {"calibrate", "--rig", "rig.toml", "--at", "10mm=0.656", "--at", "75mm=4.921", "--at", "140mm=9.186", "-o",
       "calibrated.toml"},
      {"calibrate", "--rig", "rig.toml", "--at", "10mm=0.656", "--at", "75mm=5.121", "--at", "140mm=9.186", "-o",
       "wrong.toml"},
      {"characterise", "--local", "--fast", "--rig", "rig.toml", "-o", "sheets"},
      {"design", "short.toml", "--rig", "rig.toml"},
      {"batch", run, "-o", "batch", "--", "--model", "integrator_lag"}};
  for (const std::vector<std::string>& command : commands) {
    const Ended ended = eha(command);
    std::string name = "eha";
    for (const std::string& word : command) name += " " + word;
    EXPECT_NE(ended.code, 1) << name << ended.err;
    expect_no_inches(name, ended.out + ended.err);
  }
  for (const char* page : {"changes.html", "report.html", "axis_again.html", "batch/report.html"}) {
    expect_no_inches(page, content_of(folder_->path() / page));
  }
  for (const char* runs : {"tracks", "cycles"}) {
    const fs::path track = fs::directory_iterator(folder_->path() / runs)->path();
    expect_no_inches("report of a track", content_of(track / "report.html"));
    expect_no_inches("table of a track", content_of(track / "axis_table.csv"));
    const Ended again = eha({"track", track.string()});
    expect_no_inches("eha track RUN", again.out + again.err);
    const Ended drawn = eha({"plot", track.string()});
    expect_no_inches("eha plot of a track", drawn.out + drawn.err);
  }
  expect_no_inches("report of the run", content_of(folder_->path() / run_ / "report.html"));
}

TEST_F(MillimetreRig, WritesRigFilesInItsUnit) {
  const Ended ended = eha({"characterise", "--local", "--fast", "--rig", "rig.toml", "-o", "measured.toml"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string text = content_of(folder_->path() / "measured.toml");
  const std::size_t table = text.find("\n[following]\n");
  ASSERT_NE(table, std::string::npos) << text;
  const std::string following = text.substr(table, text.find("\n[", table + 1) - table);
  EXPECT_NE(following.find("\ngain_positive_mm_per_V_s = "), std::string::npos) << following;
  EXPECT_EQ(following.find("gain_positive_in_per_V_s"), std::string::npos) << following;
  EXPECT_EQ(following.find("gain_negative_in_per_V_s"), std::string::npos) << following;
}

TEST_F(MillimetreRig, SaysLengthsInMillimetresInItsHelp) {
  for (const char* command : {"goto", "run", "status", "calibrate", "characterise"}) {
    const std::string help = eha({command, "--help"}).out;
    for (const std::string& line : lines_with_inches(help)) {
      const bool is_example = line.starts_with("  eha ");
      EXPECT_TRUE(is_example || line.find("mm") != std::string::npos) << command << ": " << line;
    }
  }
}

TEST_F(MillimetreRig, TakesARunByItsName) {
  const std::string name = run_.filename().string();
  for (const std::string& source : {name, std::string("runs/") + name}) {
    const Ended ended = eha({"plot", source});
    EXPECT_EQ(ended.code, 0) << source << ended.err;
  }
  const Ended model = eha({"plot", name + models_.front().substr(run_.string().size())});
  EXPECT_EQ(model.code, 0) << model.err;
  const Ended missing = eha({"plot", "20000101T000000Z-none"});
  EXPECT_NE(missing.code, 0);
  EXPECT_NE(missing.err.find("20000101T000000Z-none"), std::string::npos) << missing.err;
}

TEST_F(MillimetreRig, RefusesAPlaceInItsOwnUnitBeforeAnythingMoves) {
  const Ended ended = eha({"goto", "200mm", "--local", "--fast", "--rig", "rig.toml"});
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::configuration)) << ended.err;
  EXPECT_NE(ended.err.find("goto 200mm: 200 mm is beyond the travel limits of the rig, 3.81 to 146.05 mm"),
            std::string::npos)
      << ended.err;
}

TEST_F(MillimetreRig, ExportsTheGainOfItsReport) {
  const Ended octave = eha({"export", models_.front(), "--format", "octave"});
  const std::string first = octave.out.substr(0, octave.out.find("at rest"));
  EXPECT_NE(first.find("u in V, y in mm"), std::string::npos) << octave.out.substr(0, 300);
  // Simulated in mm: the rod moves about mid-travel, 75 mm.
  const Ended simulated = eha({"simulate", models_.front(), (run_ / "data_40ms.csv").string()});
  EXPECT_EQ(simulated.out.rfind("time_s,output_mm\n", 0), 0U) << simulated.out.substr(0, 60);
  const Ended in_inches = eha({"simulate", models_.front(), (run_ / "data_40ms.csv").string(), "--units", "in"});
  EXPECT_EQ(in_inches.out.rfind("time_s,output_in\n", 0), 0U) << in_inches.out.substr(0, 60);
}

TEST_F(MillimetreRig, KeepsInchesInRecordsAndTheManifest) {
  EXPECT_NE(content_of(folder_->path() / run_ / "data_40ms.csv").find("displacement_in"), std::string::npos);
  EXPECT_NE(content_of(folder_->path() / run_ / "run.json").find("travel_max_in"), std::string::npos);
}

}  // namespace
}  // namespace eha::test
