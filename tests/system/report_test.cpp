// SPDX-License-Identifier: GPL-3.0-or-later
// Reports, plots and tables as a user meets them, and the readers that docs/files.md shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMostBytes = 2'000'000;

/// One run whose models are all rejected, and one of the shipped experiment.
class Reports : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    paper_ = run({source_file("config/experiments/paper.toml")});
    std::string strict = content_of(source_file("config/experiments/paper.toml"));
    const std::string limit = "min_validation_r2_percent = 90.0";
    strict.replace(strict.find(limit), limit.size(), "min_validation_r2_percent = 99.99999");
    rejected_ = run({folder_->write("strict.toml", strict)});
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path run(const std::vector<std::string>& experiment) {
    std::vector<std::string> arguments{"run",    "--local", "--fast",
                                       "--json", "--rig",   source_file("config/rigs/sim.toml")};
    arguments.insert(arguments.end(), experiment.begin(), experiment.end());
    const Ended ended = run_eha(arguments, folder_->path());
    EXPECT_FALSE(ended.out.empty()) << ended.err;
    return folder_->path() / json::parse(ended.out).at("run").get<std::string>();
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline fs::path paper_;
  static inline fs::path rejected_;
};

TEST_F(Reports, OfARunAreInItsFolderAndListedInTheManifest) {
  for (const fs::path& run : {paper_, rejected_}) {
    ASSERT_TRUE(fs::exists(run / "report.html"));
    EXPECT_LE(fs::file_size(run / "report.html"), kMostBytes);
    std::vector<std::string> listed;
    const json manifest = json::parse(content_of(run / "run.json"));
    for (const json& file : manifest.at("files")) listed.push_back(file.at("path"));
    for (const char* name : {"report.html", "fit.csv"}) {
      EXPECT_NE(std::find(listed.begin(), listed.end(), name), listed.end()) << name;
    }
    EXPECT_EQ(content_of(run / "report.html").find("This plot is missing"), std::string::npos);
  }
}

TEST_F(Reports, SayWhichModelToUseOrWhyNone) {
  EXPECT_NE(content_of(paper_ / "report.html").find("Recommended model"), std::string::npos);
  EXPECT_NE(content_of(rejected_ / "report.html").find("No model can be used"), std::string::npos);
}

TEST_F(Reports, SayWhenAndByWhichVersionTheyWereWrittenAndWhatWasRecorded) {
  const std::string page = content_of(paper_ / "report.html");
  EXPECT_NE(page.find(" UTC by eha "), std::string::npos);
  EXPECT_NE(page.find("<strong>Recorded.</strong> "), std::string::npos);
  EXPECT_NE(page.find("record_rows"), std::string::npos);
  EXPECT_EQ(page.find("transforms"), std::string::npos);
}

TEST_F(Reports, AreValidHtml) {
  if (std::system("command -v tidy >/dev/null") != 0) GTEST_SKIP() << "tidy is not installed";
  for (const fs::path& run : {paper_, rejected_}) {
    // 1 would be a warning, 2 an error.
    EXPECT_EQ(std::system(("tidy -q -e '" + (run / "report.html").string() + "'").c_str()), 0) << run;
  }
}

TEST_F(Reports, AreWrittenAnewOnRequestAndElsewhere) {
  const Ended here = run_eha({"report", paper_.string(), "-o", "other.html", "--json"}, folder_->path());
  ASSERT_EQ(here.code, 0) << here.err;
  EXPECT_EQ(json::parse(here.out).at("file"), "other.html");
  EXPECT_TRUE(fs::exists(folder_->path() / "other.html"));
  EXPECT_EQ(run_eha({"report", (paper_ / "models").string()}, folder_->path()).code, 10);
}

TEST_F(Reports, AndAnswersAreInTheUnitThatIsAskedFor) {
  const Ended report = run_eha({"report", paper_.string(), "-o", "mm.html", "--units", "mm"}, folder_->path());
  ASSERT_EQ(report.code, 0) << report.err;
  EXPECT_NE(content_of(folder_->path() / "mm.html").find("displacement [mm]"), std::string::npos);
  const Ended shown = run_eha({"runs", "show", paper_.string(), "--units", "mm"}, folder_->path());
  EXPECT_NE(shown.out.find("largest mm"), std::string::npos) << shown.out;
  const std::string model = (paper_ / json::parse(content_of(paper_ / "run.json"))
                                          .at("identification")
                                          .at("models")
                                          .at(0)
                                          .at("file")
                                          .get<std::string>())
                                .string();
  const Ended validated = run_eha({"validate", model, paper_.string(), "--units", "mm"}, folder_->path());
  EXPECT_NE(validated.out.find(" mm^2 "), std::string::npos) << validated.out << validated.err;
}

TEST_F(Reports, GnuplotMissingCostsThePlotsAlone) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const Ended report = run_eha({"report", paper_.string(), "-o", "bare.html"}, folder_->path());
  const Ended plot = run_eha({"plot", paper_.string()}, folder_->path());
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(report.code, 0) << report.err;
  EXPECT_NE(report.err.find("apt install gnuplot-nox"), std::string::npos);
  EXPECT_NE(content_of(folder_->path() / "bare.html").find("Recommended model"), std::string::npos);
  EXPECT_EQ(plot.code, 69);
  EXPECT_NE(plot.err.find("apt install gnuplot-nox"), std::string::npos);
}

TEST_F(Reports, PlotDrawsRunsTablesAndModels) {
  const Ended text = run_eha({"plot", paper_.string()}, folder_->path());
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("measured"), std::string::npos);
  const std::string model =
      json::parse(content_of(paper_ / "run.json")).at("identification").at("models")[0].at("file");
  int number = 0;
  for (const fs::path& source : {paper_, paper_ / model, paper_ / "data_40ms.csv", paper_ / "fit.csv"}) {
    const std::string picture = std::to_string(++number) + ".png";
    const Ended drawn = run_eha({"plot", source.string(), "-o", picture}, folder_->path());
    ASSERT_EQ(drawn.code, 0) << drawn.err;
    EXPECT_EQ(content_of(folder_->path() / picture).substr(1, 3), "PNG");
  }
  EXPECT_EQ(run_eha({"plot", paper_.string(), "-o", "a.gif"}, folder_->path()).code, 2);
  ASSERT_EQ(run_eha({"plot", paper_.string(), "-o", "run.svg"}, folder_->path()).code, 0);
  const std::string drawn = content_of(folder_->path() / "run.svg");
  EXPECT_NE(drawn.find(", simulated rig: "), std::string::npos) << "the title has the rig";
  EXPECT_NE(drawn.find("recommended"), std::string::npos);
  EXPECT_NE(drawn.find("time [s], the first 10 s left out"), std::string::npos);
  ASSERT_EQ(run_eha({"plot", (paper_ / model).string(), "-o", "model.svg"}, folder_->path()).code, 0);
  EXPECT_NE(content_of(folder_->path() / "model.svg").find(", fitted to " + paper_.filename().string()),
            std::string::npos);
}

/// The code blocks of a language in a document.
std::string code_in(const std::string& document, const std::string& language) {
  const std::string begin = "```" + language + "\n";
  const std::size_t at = document.find(begin) + begin.size();
  return document.substr(at, document.find("```", at) - at);
}

TEST_F(Reports, TheReadersOfTheDocumentationRead) {
  const std::string document = content_of(source_file("docs/files.md"));
  const std::string recommended =
      json::parse(content_of(paper_ / "run.json")).at("identification").at("recommendation").at("model");
  const auto expect_run = [&](const std::string& program, const std::string& script) {
    const std::string out = output_of_shell(program + " '" + script + "' '" + paper_.string() + "' 2>&1");
    EXPECT_NE(out.find("recommended: " + recommended), std::string::npos) << out;
    EXPECT_NE(out.find("50000 rows"), std::string::npos) << out;
    EXPECT_NE(out.find("rms error"), std::string::npos) << out;
  };
  bool ran = false;
  if (std::system("/usr/bin/python3 -c 'import h5py, numpy' 2>/dev/null") == 0) {
    expect_run("/usr/bin/python3", folder_->write("reader.py", code_in(document, "python")).string());
    ran = true;
  }
  if (std::system("command -v octave-cli >/dev/null") == 0) {
    expect_run("octave-cli --no-init-file", folder_->write("reader.m", code_in(document, "octave")).string());
    ran = true;
  }
  if (!ran) GTEST_SKIP() << "neither Python with h5py nor Octave is installed";
}

TEST(EndedRun, HasItsPageAndANextStepAtOnce) {
  const TemporaryFolder folder;
  std::string text = content_of(source_file("config/experiments/paper.toml"));
  const std::string offset = "offset_V = -0.1";
  folder.write("trip.toml", text.replace(text.find(offset), offset.size(), "offset_V = 0.6 "));
  std::string tones = content_of(folder.path() / "trip.toml");
  const std::string first = "amplitude_V = 1.9";
  folder.write("trip.toml", tones.replace(tones.find(first), first.size(), "amplitude_V = 1.3"));
  const Ended ended = run_eha({"run", "trip.toml", "--local", "--fast", "--accept-travel-risk", "--rig",
                               source_file("config/rigs/sim.toml"), "-o", "runs"},
                              folder.path());
  ASSERT_EQ(ended.code, static_cast<int>(ExitCode::safety_trip)) << ended.err;
  EXPECT_NE(ended.out.find("Next: xdg-open runs/"), std::string::npos) << ended.out;
  EXPECT_EQ(ended.out.find("Next: eha fit"), std::string::npos) << "the page says first what to correct: " << ended.out;
  for (const auto& entry : fs::directory_iterator(folder.path() / "runs")) {
    if (entry.path().filename().string().find("-trip") == std::string::npos) continue;
    const std::string page = content_of(entry.path() / "report.html");
    EXPECT_NE(page.find("The run tripped at 3"), std::string::npos);
    const std::size_t cure = ended.err.find("the rod drifted at ");
    ASSERT_NE(cure, std::string::npos) << ended.err;
    const std::string offset_V = ended.err.substr(ended.err.find("offset_V = ", cure), 16);
    EXPECT_NE(page.find("Next: set " + offset_V), std::string::npos) << offset_V << ": as the terminal has it";
    EXPECT_EQ(page.find("lower the excitation"), std::string::npos) << "which would not stop a drift";
    EXPECT_NE(page.find(" s of 50"), std::string::npos) << "a part of the run";
  }
}

}  // namespace
}  // namespace eha::test
