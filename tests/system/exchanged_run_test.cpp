// SPDX-License-Identifier: GPL-3.0-or-later
// A run folder whose owner puts a link to another folder in its place while somebody else fits it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kShort = R"(schema = 1
name = "short"
duration_s = 4.0
[excitation]
kind = "odd_random_multisine"
amplitude_V = 2.0
offset_V = -0.2
frequency_min_Hz = 0.5
frequency_max_Hz = 2.0
[record]
decimation = 40
[[model]]
name = "io"
structure = "terms"
denominator = [{ order = 1.0 }, { order = 0.0, coefficient = 0.0 }]
[acceptance]
min_validation_r2_percent = 0.0
require_stable = false
)";

class ExchangedRun : public testing::Test {
 protected:
  ExchangedRun() : runs_(folder_.path() / "runs"), elsewhere_(folder_.path() / "elsewhere"), link_(runs_ / "link") {
    folder_.write("short.toml", kShort);
  }

  /// Plays a run, and makes the folder elsewhere and the link that leads to it.
  void play(std::vector<std::string> words) {
    words.insert(words.end(), {"--local", "--fast", "--rig", source_file("config/rigs/sim.toml")});
    const Ended played = run_eha(words, folder_.path());
    ASSERT_EQ(played.code, 0) << played.err;
    for (const auto& entry : fs::directory_iterator(runs_)) {
      if (!entry.is_symlink()) run_ = entry.path();
    }
    fs::create_directories(elsewhere_ / "models" / "rejected");
    fs::copy_file(run_ / "run.json", elsewhere_ / "run.json");  // of a run without a record, which no fit begins with
    fs::create_directory_symlink(elsewhere_, link_);
  }

  void exchange() const {
    ASSERT_EQ(syscall(SYS_renameat2, AT_FDCWD, run_.c_str(), AT_FDCWD, link_.c_str(), RENAME_EXCHANGE), 0);
  }

  /// Names of the files elsewhere with their times.
  [[nodiscard]] std::set<std::pair<std::string, fs::file_time_type>> files_elsewhere() const {
    std::set<std::pair<std::string, fs::file_time_type>> files;
    for (const auto& entry : fs::recursive_directory_iterator(elsewhere_)) {
      files.emplace(entry.path().string(), entry.last_write_time());
    }
    return files;
  }

  /// Runs `eha` again and again, each time exchanging the folder for the link at another moment.
  /// @param files  that it writes into the run folder
  void exchange_during(std::vector<std::string> words, const std::vector<std::string>& files, int moments) {
    words.emplace_back("--no-progress");
    const auto begun = std::chrono::steady_clock::now();
    const Ended undisturbed = run_eha(words, folder_.path());
    ASSERT_EQ(undisturbed.code, 0) << undisturbed.err;
    const auto takes = std::chrono::steady_clock::now() - begun;
    const auto before = files_elsewhere();
    int written = 0;
    for (int i = 0; i < moments; ++i) {
      for (const std::string& file : files) fs::remove(run_ / file);
      Ended ended;
      std::thread process([&] { ended = run_eha(words, folder_.path()); });
      std::this_thread::sleep_for(takes * i / moments);
      exchange();
      process.join();
      exchange();
      ASSERT_EQ(files_elsewhere(), before) << "moment " << i << '\n' << ended.out << ended.err;
      EXPECT_EQ((ended.out + ended.err).find("/proc/"), std::string::npos) << ended.out << ended.err;
      const auto is_there = [&](const std::string& file) { return fs::exists(run_ / file); };
      if (ended.code == 0 && std::all_of(files.begin(), files.end(), is_there)) ++written;
    }
    EXPECT_GE(written, moments / 2) << "of so many moments kept to the run";
  }

  TemporaryFolder folder_;
  fs::path runs_;
  fs::path elsewhere_;
  fs::path link_;
  fs::path run_;
};

TEST_F(ExchangedRun, GetsTheFilesOfItsFitWhateverStandsInItsPlace) {
  play({"run", "short.toml"});
  exchange_during({"fit", "runs/latest"}, {"fit.csv", "report.html"}, 25);
}

TEST_F(ExchangedRun, GetsTheTableOfASweep) {
  play({"run", "short.toml"});
  exchange_during({"fit", "runs/latest", "--sweep", "commensurate", "--sweep-orders", "0.9:1:0.1"},
                  {"models/sweep_commensurate.csv"}, 12);
}

TEST_F(ExchangedRun, GetsItsReport) {
  play({"run", "short.toml"});
  exchange_during({"report", "runs/latest"}, {"report.html"}, 12);
}

TEST_F(ExchangedRun, GetsItsValveSheet) {
  play({"characterise"});
  exchange_during({"fit", "runs/" + run_.filename().string()}, {"valve_sheet.json", "report.html"}, 12);
}

}  // namespace
}  // namespace eha::test
