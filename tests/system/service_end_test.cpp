// SPDX-License-Identifier: GPL-3.0-or-later
// The service and its worker are killed between any two operations on files with which a run ends.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/file_trap.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// A service whose operations on files are counted.
class TrappedService {
 public:
  explicit TrappedService(long kill_before) {
    const fs::path control_file = daemon.folder() / "control";
    std::ofstream(control_file).close();
    fs::resize_file(control_file, sizeof(FileTrapControl));
    const int file = open(control_file.c_str(), O_RDWR | O_CLOEXEC);
    control =
        new (mmap(nullptr, sizeof(FileTrapControl), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)) FileTrapControl{};
    close(file);
    control->kill_before = kill_before;
    daemon.set_environment(std::string("LD_PRELOAD=") + EHA_FILE_TRAP_LIBRARY);
    daemon.set_environment("EHA_TRAP_CONTROL=" + control_file.string());
    daemon.set_environment("EHA_TRAP_LOG=" + (daemon.folder() / "operations").string());
    daemon.set_environment("EHA_TRAP_UNDER=" + (daemon.folder() / "state").string());
    daemon.start();
  }
  TrappedService(const TrappedService&) = delete;
  TrappedService& operator=(const TrappedService&) = delete;
  ~TrappedService() { munmap(control, sizeof(FileTrapControl)); }

  std::int64_t begin_run() {
    Client client(daemon.socket());
    client.call("arm");
    return submit(client, experiment_text("end", 6.0));
  }

  [[nodiscard]] bool is_dead() const {
    siginfo_t ended{};
    return waitid(P_PID, static_cast<id_t>(daemon.pid()), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == daemon.pid();
  }

  [[nodiscard]] std::vector<std::string> operations() const {
    std::vector<std::string> lines;
    std::istringstream text(content_of(daemon.folder() / "operations"));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

  Daemon daemon;
  FileTrapControl* control = nullptr;
};

/// What a run of which nothing was killed leaves.
struct Reference {
  std::vector<std::string> operations;
  std::string journal;
  std::string raw;
  std::string decimated;
};

Reference run_undisturbed() {
  TrappedService service(-1);
  const Json over = follow(service.daemon, service.begin_run());
  EXPECT_EQ(over.at("exit_code"), 0) << "a model is accepted, so that the link is moved, too: " << over;
  const fs::path run = over.at("folder").get<std::string>();
  EXPECT_EQ(service.daemon.stop(SIGTERM), 0);
  return {service.operations(), content_of(run / "raw.ehalog"), content_of(run / "raw.h5"),
          content_of(run / "data_40ms.csv")};
}

/// The operations before which to kill: of many writes to one file the first and the last.
std::vector<long> kill_points(const std::vector<std::string>& operations) {
  std::vector<long> points;
  for (std::size_t i = 0; i < operations.size(); ++i) {
    const bool is_inner =
        i > 0 && i + 1 < operations.size() && operations[i] == operations[i - 1] && operations[i] == operations[i + 1];
    if (!is_inner) points.push_back(static_cast<long>(i));
  }
  return points;
}

std::size_t count_of(const std::string& what, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

bool has_unfinished_files(const fs::path& folder) {
  const auto files = fs::recursive_directory_iterator(folder);
  return std::any_of(begin(files), end(files), [](const auto& file) { return file.path().extension() == ".tmp"; });
}

void expect_whole(const Reference& reference, long kill_before) {
  TrappedService service(kill_before);
  Daemon& daemon = service.daemon;
  const std::int64_t entry = service.begin_run();
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (!service.is_dead() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (!service.is_dead()) {
    daemon.stop(SIGKILL);
    FAIL() << "it lives after " << service.control->count << " operations";
  }
  ASSERT_EQ(daemon.wait(), 128 + SIGKILL);
  service.control->kill_before = -1;
  const fs::path run = *std::find_if(fs::directory_iterator(daemon.runs()), fs::directory_iterator(),
                                     [](const auto& found) { return found.is_directory() && !found.is_symlink(); });
  const bool was_fitted = Json::parse(content_of(run / "run.json")).at("identification").is_object();
  const std::size_t log_before = daemon.log().size();
  daemon.start();
  Json over = entry_of(daemon, entry);
  if (over.at("state") != "over") over = follow(daemon, entry);
  const std::string log = daemon.log().substr(log_before);
  ASSERT_EQ(daemon.stop(SIGTERM), 0);

  EXPECT_EQ(content_of(run / "raw.h5"), reference.raw);
  EXPECT_EQ(content_of(run / "data_40ms.csv"), reference.decimated);
  EXPECT_FALSE(has_unfinished_files(daemon.folder() / "state"));
  const Json manifest = Json::parse(content_of(run / "run.json"));
  const std::string journal = content_of(run / "raw.ehalog");
  if (kill_before == 0) {
    // The journal has no end: that the experiment had completed is not known, and it is not fitted by itself.
    EXPECT_EQ(journal, reference.journal.substr(0, journal.size()));
    EXPECT_EQ(manifest.at("outcome"), "recovered");
    EXPECT_EQ(over.at("outcome"), "recovered");
    return;
  }
  EXPECT_EQ(journal, reference.journal);
  EXPECT_EQ(manifest.at("outcome"), "completed");
  EXPECT_EQ(over.at("outcome"), "completed");
  EXPECT_EQ(over.at("exit_code"), 0) << over;
  EXPECT_EQ(over.at("models").size(), 1U);
  EXPECT_EQ(manifest.at("identification").at("accepted"), true);
  EXPECT_TRUE(fs::exists(run / "models" / "io.json"));
  EXPECT_TRUE(fs::equivalent(daemon.runs() / "latest", run));
  EXPECT_EQ(count_of("being fitted by process", log), was_fitted ? 0U : 1U) << log;
}

TEST(ServiceEnd, LosesNothingAndFitsNothingTwiceWhenKilledBetweenAnyTwoOperationsOnFiles) {
  const Reference reference = run_undisturbed();
  const std::vector<long> points = kill_points(reference.operations);
  EXPECT_GT(points.size(), 30U) << "journal, raw.h5, data, manifest, queue, models, link, index";
  std::cout << reference.operations.size() << " operations on files, killed before " << points.size() << " of them\n";
  for (const long point : points) {
    SCOPED_TRACE("killed before operation " + std::to_string(point) + ": " +
                 reference.operations[static_cast<std::size_t>(point)]);
    expect_whole(reference, point);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace eha::test
