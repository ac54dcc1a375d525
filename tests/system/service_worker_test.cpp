// SPDX-License-Identifier: GPL-3.0-or-later
// The identification that follows a run, as a process of its own.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

std::string first_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

/// Polls until a condition holds that sends no notification.
bool comes_true(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// The process that ehad started for a fit, as its log says, once it has become `eha`.
pid_t worker_of(const Daemon& daemon) {
  const std::string word = "being fitted by process ";
  EXPECT_TRUE(daemon.logs(word)) << daemon.log();
  const std::string log = daemon.log();
  const std::string number = log.substr(log.rfind(word) + word.size());
  EXPECT_TRUE(comes_true([&] { return first_line("/proc/" + std::to_string(std::stol(number)) + "/comm") == "eha"; }));
  return static_cast<pid_t>(std::stol(number));
}

/// Plays the shipped experiment, whose fit takes seconds, and stops its worker in the middle of it.
std::int64_t start_fit_and_halt_it(const Daemon& daemon, Client& client, pid_t& worker) {
  client.call("arm");
  const std::int64_t entry = submit(client, content_of(source_file("config/experiments/paper.toml")));
  worker = worker_of(daemon);
  EXPECT_EQ(kill(worker, SIGSTOP), 0);
  return entry;
}

TEST(Worker, KeepsALowerHardLimitOfTheServiceInsteadOfRefusing) {
  const std::string worker = (fs::path(EHA_PROGRAM).parent_path() / "eha-worker").string();
  // Root could raise it.
  const std::string nobody = geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups " : "";
  EXPECT_EQ(output_of_shell("ulimit -v 3000000; ulimit -t 100; exec " + nobody + worker +
                            " $PPID -1 1800 4294967296 19 /bin/sh -c 'ulimit -v; ulimit -t; nice'"),
            "3000000\n99\n19\n");
}

TEST(ServiceWorker, HoldsNoDescriptorOfTheServiceAndIsOutOfTheWay) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  pid_t worker = 0;
  const std::int64_t entry = start_fit_and_halt_it(daemon, client, worker);
  const auto descriptors_of = [](pid_t pid) {
    std::vector<std::string> targets;
    for (const auto& descriptor : fs::directory_iterator(fs::path("/proc") / std::to_string(pid) / "fd")) {
      std::error_code closed_meanwhile;
      const fs::path target = fs::read_symlink(descriptor.path(), closed_meanwhile);
      if (!closed_meanwhile) {
        targets.push_back(target.string());
      }
    }
    return targets;
  };
  const std::vector<std::string> of_the_service = descriptors_of(daemon.pid());
  EXPECT_NE(std::find(of_the_service.begin(), of_the_service.end(), kDevice), of_the_service.end());
  for (const std::string& target : descriptors_of(worker)) {
    // Beside its standard streams it has files of its own open, when there was time for it.
    const bool is_foreign = (target.starts_with("/dev/") && target != "/dev/null") || target.starts_with("socket:") ||
                            target.starts_with("pipe:") || target.starts_with("anon_inode:") ||
                            target.starts_with((daemon.folder() / "state" / "queue").string());
    EXPECT_FALSE(is_foreign) << target;
  }
  EXPECT_EQ(sched_getscheduler(worker), SCHED_BATCH);
  EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(worker)), 19);
  rlimit limit{};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose shadow takes more addresses
  ASSERT_EQ(prlimit(worker, RLIMIT_AS, nullptr, &limit), 0);
  EXPECT_EQ(limit.rlim_cur, rlim_t{4096} << 20U);
#endif
  ASSERT_EQ(prlimit(worker, RLIMIT_CPU, nullptr, &limit), 0);
  EXPECT_EQ(limit.rlim_cur, 1800U);
  kill(worker, SIGCONT);
  EXPECT_EQ(follow(daemon, entry).at("exit_code"), 0);
}

TEST(ServiceWorker, IsKnownToWhoeverAsksForItsRun) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  pid_t worker = 0;
  const std::int64_t entry = start_fit_and_halt_it(daemon, client, worker);
  const Json fitting = client.call("status").at("worker");
  EXPECT_GE(fitting.at("fitting_s").get<double>(), 0.0);
  EXPECT_GT(fitting.at("fitting_cpu_s").get<double>(), 0.0) << "it has begun";
  const fs::path run = fitting.at("folder").get<std::string>();
  const std::string socket = daemon.socket();
  const std::vector<std::vector<std::string>> questions{
      {"status"}, {"queue"}, {"runs", "list"}, {"runs", "show", run.string()}};
  for (std::vector<std::string> words : questions) {
    words.insert(words.end(), {"--socket", socket});
    const Ended ended = run_eha(words, daemon.folder());
    EXPECT_NE(ended.out.find("s so far"), std::string::npos) << words.back() << ended.out << ended.err;
    EXPECT_EQ(ended.out.find("Next: eha fit"), std::string::npos) << ended.out;
  }
  // Also in runs that this process would fit beside the service.
  setenv("EHA_SOCKET", socket.c_str(), 1);
  const Ended fitted = run_eha({"fit", run.string(), "--model", "integrator_lag"}, daemon.folder());
  const Ended apart = run_eha({"fit", run.string(), "--model", "integrator_lag", "-o", "m"}, daemon.folder());
  unsetenv("EHA_SOCKET");
  EXPECT_NE(fitted.err.find("for the service this run is being fitted"), std::string::npos) << fitted.err;
  EXPECT_EQ(apart.err.find("for the service"), std::string::npos) << apart.err;
  kill(worker, SIGCONT);
  EXPECT_EQ(follow(daemon, entry).at("exit_code"), 0);
  const Ended shown = run_eha({"runs", "show", run.string(), "--socket", socket}, daemon.folder());
  EXPECT_EQ(shown.out.find("is being fitted"), std::string::npos) << shown.out;
}

TEST(ServiceWorker, StaysOffTheCpuOfTheLoop) {
  cpu_set_t ours;
  ASSERT_EQ(sched_getaffinity(0, sizeof ours, &ours), 0);
  if (CPU_COUNT(&ours) < 2 || !CPU_ISSET(0, &ours)) GTEST_SKIP() << "needs CPU 0 and another one";
  Daemon daemon;
  std::string rig = content_of(daemon.rig_file());
  rig.insert(rig.find("priority = 80"), "cpu = 0\n");
  std::ofstream(daemon.rig_file()) << rig;
  daemon.start();
  Client client(daemon.socket());
  pid_t worker = 0;
  const std::int64_t entry = start_fit_and_halt_it(daemon, client, worker);
  cpu_set_t cpus;
  ASSERT_EQ(sched_getaffinity(worker, sizeof cpus, &cpus), 0);
  EXPECT_FALSE(CPU_ISSET(0, &cpus));
  EXPECT_EQ(CPU_COUNT(&cpus), CPU_COUNT(&ours) - 1);
  kill(worker, SIGCONT);
  follow(daemon, entry);
}

TEST(ServiceWorker, MarksTheRunAloneWhenItIsKilledAndCanBeRepeated) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  pid_t worker = 0;
  const std::int64_t entry = start_fit_and_halt_it(daemon, client, worker);
  kill(worker, SIGKILL);
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("outcome"), "completed");
  EXPECT_NE(over.at("exit_code"), 0);
  EXPECT_NE(over.at("note").get<std::string>().find("signal 9"), std::string::npos) << over;
  const fs::path run = over.at("folder").get<std::string>();
  const Json marked = Json::parse(content_of(run / "run.json")).at("identification");
  EXPECT_NE(marked.at("error").get<std::string>().find("signal 9"), std::string::npos) << marked;
  EXPECT_FALSE(fs::exists(daemon.runs() / "latest"));
  // The rig is as it was, and the next experiment runs.
  EXPECT_EQ(client.call("status").at("state"), "armed");
  EXPECT_EQ(follow(daemon, submit(client, experiment_text("next"))).at("outcome"), "completed");
  const Ended fitted = run_eha({"fit", run.string()}, daemon.folder());
  EXPECT_EQ(fitted.code, 0) << fitted.err;
  EXPECT_FALSE(Json::parse(content_of(run / "run.json")).at("identification").contains("error"));
}

TEST(ServiceWorker, IsEndedWhenItTakesTooLong) {
  Daemon daemon("schema = 1\n[worker]\nwall_time_s = 1\n");
  daemon.start();
  Client client(daemon.socket());
  pid_t worker = 0;
  const std::int64_t entry = start_fit_and_halt_it(daemon, client, worker);
  const Json over = follow(daemon, entry);
  EXPECT_NE(over.at("note").get<std::string>().find("worker.wall_time_s"), std::string::npos) << over;
}

TEST(ServiceWorker, DiesWithTheServiceAndTheFitIsMadeAfterTheRestart) {
  Daemon daemon;
  daemon.start();
  pid_t worker = 0;
  std::int64_t entry = 0;
  {
    Client client(daemon.socket());
    entry = start_fit_and_halt_it(daemon, client, worker);
  }
  daemon.stop(SIGKILL);
  EXPECT_TRUE(comes_true([&] {
    // Gone, or a zombie until init looks after it.
    const std::string line = first_line("/proc/" + std::to_string(worker) + "/stat");
    return line.empty() || line.find(") Z ") != std::string::npos || line.find(") X ") != std::string::npos;
  }));
  daemon.start();
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("outcome"), "completed");
  EXPECT_EQ(over.at("exit_code"), 0) << over << daemon.log();
}

}  // namespace
}  // namespace eha::test
