// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <string>

#include "core/guard_page.hpp"
#include "fast_clock.hpp"
#include "hal/snapshot_file.hpp"
#include "snapshot_file.hpp"

namespace eha {
namespace {

struct Result {
  int status = -1;
  std::string output;  ///< both streams
};

/// Runs a command line of the shell.
Result run(const std::string& command) {
  Result result;
  FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return result;
  for (int byte = fgetc(pipe); byte != EOF; byte = fgetc(pipe)) result.output += static_cast<char>(byte);
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

const std::string kProgram = EHA_SAFE;

TEST(EhaSafe, EndsLoudlyWhenItCannotMakeTheRigSafe) {
  const testing::FastClock clock;
  const testing::SnapshotFile snapshot;
  const Result result = run(kProgram + " " + snapshot.path().string());
  EXPECT_EQ(result.status, 69);
  EXPECT_NE(result.output.find("eha-safe: error: /dev/no-such-card: "), std::string::npos) << result.output;
}

TEST(EhaSafe, HasNothingToDoWhereTheServiceLeftNoSnapshot) {
  if (std::filesystem::exists(hal::kServiceSnapshot)) GTEST_SKIP() << hal::kServiceSnapshot << " belongs to a service";
  const Result result = run(kProgram);
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output.rfind("eha-safe: /run/ehad/safe.json is not there: the service drives no card", 0), 0U)
      << result.output;
}

TEST(EhaSafe, NamesTheSnapshotThatALocalRunLeft) {
  if (std::filesystem::exists(hal::kServiceSnapshot)) GTEST_SKIP() << hal::kServiceSnapshot << " belongs to a service";
  std::string folder = std::filesystem::temp_directory_path() / "runtime-XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const std::filesystem::path left = std::filesystem::path(folder) / "eha-1a2b3c" / "safe.json";
  std::filesystem::create_directory(left.parent_path());
  const std::string command = "XDG_RUNTIME_DIR=" + folder + " " + kProgram;
  EXPECT_EQ(run(command).output.find(folder), std::string::npos) << "an empty folder is no snapshot";
  std::ofstream(left) << "{}";
  const Result result = run(command);
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.output.find("run eha-safe " + left.string() + "\n"), std::string::npos) << result.output;
  std::filesystem::remove_all(folder);
}

TEST(EhaSafe, ActsAtTheEndOfItsInputUnlessItHeardDone) {
  const testing::FastClock clock;
  const testing::SnapshotFile snapshot;
  const std::string guard = kProgram + " --guard " + snapshot.path().string();
  Result result = run("printf 'done\\n' | " + guard);
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output, "ready\n");
  for (const char* words : {"", "done", "undone\\n", "do\\nne\\n", " done\\n"}) {
    result = run(std::string("printf '") + words + "' | " + guard);
    EXPECT_EQ(result.status, 69) << words;
    EXPECT_EQ(result.output.rfind("ready\n", 0), 0U) << result.output;
    EXPECT_NE(result.output.find("ended without making it safe"), std::string::npos) << result.output;
  }
}

TEST(EhaSafe, SaysOfAProgramThatDroveNothingThatItDroveNothing) {
  const testing::FastClock clock;
  const testing::SnapshotFile snapshot;
  const std::filesystem::path file = snapshot.path().string() + ".page";
  auto page = std::make_unique<GuardPage>();
  page->mark_version();
  const auto said = [&] {
    std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(page.get()), sizeof(GuardPage));
    return run("printf '' | " + kProgram + " --guard " + snapshot.path().string() + " --page " + file.string()).output;
  };
  const std::string refused = said();
  EXPECT_NE(refused.find("ended and had driven nothing"), std::string::npos) << refused;
  EXPECT_EQ(refused.find("without making it safe"), std::string::npos) << refused;
  page->begin_drive(1, 100'000'000);
  const std::string driven = said();
  EXPECT_NE(driven.find("ended without making it safe"), std::string::npos) << driven;
  std::filesystem::remove(file);
}

TEST(EhaSafe, RefusesASnapshotThatItCannotReadBeforeItSaysReady) {
  Result result = run(kProgram + " --guard /no/such/file </dev/null");
  EXPECT_EQ(result.status, 74);
  EXPECT_EQ(result.output.find("ready"), std::string::npos);
  result = run(kProgram + " --guard /proc/version </dev/null");
  EXPECT_EQ(result.status, 78);
  EXPECT_EQ(result.output.find("ready"), std::string::npos);
}

TEST(EhaSafe, ExplainsItself) {
  EXPECT_EQ(run(kProgram + " one two").status, 2);
  EXPECT_EQ(run(kProgram + " --no-such-option x").status, 2);
  EXPECT_EQ(run(kProgram + " --version").status, 0);
  EXPECT_NE(run(kProgram + " --help").output.find("NOT safe"), std::string::npos);
}

TEST(EhaSafe, LoadsNothingButTheCardsLibraryAndTheLanguages) {
  const Result result = run("objdump -p " + kProgram);
  if (result.status != 0) GTEST_SKIP() << "objdump is missing: " << result.output;
  const std::set<std::string> allowed = {"libcomedi.so.0", "libstdc++.so.6", "libm.so.6",
                                         "libgcc_s.so.1",  "libc.so.6",      "ld-linux-x86-64.so.2",
                                         "libasan.so.8",   "libubsan.so.1",  "libtsan.so.2"};
  const std::regex needed("NEEDED +(\\S+)");
  int count = 0;
  for (std::sregex_iterator it(result.output.begin(), result.output.end(), needed); it != std::sregex_iterator();
       ++it) {
    EXPECT_TRUE(allowed.contains((*it)[1].str())) << (*it)[1].str();
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace eha
