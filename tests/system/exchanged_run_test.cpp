// SPDX-License-Identifier: GPL-3.0-or-later
// A run folder whose owner puts a link to another folder in its place while somebody else fits it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
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
    const Ended played =
        run_eha({"run", "short.toml", "--local", "--fast", "--rig", source_file("config/rigs/sim.toml"), "--json"},
                folder_.path());
    run_ = folder_.path() / nlohmann::json::parse(played.out).at("run").get<std::string>();
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

  TemporaryFolder folder_;
  fs::path runs_;
  fs::path elsewhere_;
  fs::path link_;
  fs::path run_;
};

TEST_F(ExchangedRun, GetsTheFilesOfItsFitWhateverStandsInItsPlace) {
  const std::vector<std::string> fit{"fit", "runs/latest", "--no-progress"};
  const auto begun = std::chrono::steady_clock::now();
  const Ended undisturbed = run_eha(fit, folder_.path());
  ASSERT_EQ(undisturbed.code, 0) << undisturbed.err;
  const auto takes = std::chrono::steady_clock::now() - begun;
  const auto before = files_elsewhere();
  constexpr int kMoments = 25;
  int fitted = 0;
  for (int i = 0; i < kMoments; ++i) {
    for (const char* name : {"fit.csv", "report.html"}) fs::remove(run_ / name);
    Ended ended;
    std::thread fits([&] { ended = run_eha(fit, folder_.path()); });
    std::this_thread::sleep_for(takes * i / kMoments);
    exchange();
    fits.join();
    exchange();
    EXPECT_EQ(files_elsewhere(), before) << "moment " << i << '\n' << ended.out << ended.err;
    if (files_elsewhere() != before) break;
    EXPECT_EQ(ended.err.find("/proc/"), std::string::npos) << ended.err;
    if (ended.code == 0 && fs::exists(run_ / "fit.csv") && fs::exists(run_ / "report.html")) ++fitted;
  }
  EXPECT_GE(fitted, kMoments / 2) << "fits that kept to the run";
}

}  // namespace
}  // namespace eha::test
