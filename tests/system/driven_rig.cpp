// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/driven_rig.hpp"

#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <new>
#include <stdexcept>
#include <thread>

#include "daemon/record/journal.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

constexpr int kHogPriority = 90;
constexpr off_t kOutputSubdevice = 1;
constexpr std::chrono::seconds kGenerousStart(60);

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void* shared_memory(std::size_t size, int file) {
  void* memory =
      mmap(nullptr, size, PROT_READ | PROT_WRITE, file < 0 ? MAP_SHARED | MAP_ANONYMOUS : MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("cannot map memory");
  return memory;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("the sample rig file has no " + what);
  return text.replace(at, what.size(), by);
}

bool may_be_fifo() {
  bool granted = false;
  std::thread([&] {
    sched_param parameter{};
    parameter.sched_priority = kHogPriority;
    granted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0;
  }).join();
  return granted;
}

[[noreturn]] void hog(int cpu, std::int64_t duration_ns, std::atomic<std::int64_t>& begun_ns) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(static_cast<std::size_t>(cpu), &cpus);
  sched_param parameter{};
  parameter.sched_priority = kHogPriority;
  if (sched_setaffinity(0, sizeof cpus, &cpus) != 0 || sched_setscheduler(0, SCHED_FIFO, &parameter) != 0) _exit(1);
  const std::int64_t begun = now_ns();
  std::int64_t earlier = begun_ns.load();
  while (earlier < begun && !begun_ns.compare_exchange_weak(earlier, begun)) {
  }
  while (now_ns() < begun + duration_ns) {
  }
  _exit(0);
}

/// What stands after the name in /proc/PROCESS/stat: the state, the parent, ...; empty for a process that has ended.
std::string stat_of(const fs::path& process) {
  std::ifstream file(process / "stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(") ");
  return name_end == std::string::npos ? "" : text.substr(name_end + 2);
}

}  // namespace

DrivenRig::DrivenRig() : file_(fs::path("/dev/shm") / ("eha-card-" + std::to_string(getpid()))) {
  const int file = open(file_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0 || ftruncate(file, sizeof(CardMemory)) != 0) throw std::runtime_error("cannot create a card");
  card_ = static_cast<CardMemory*>(shared_memory(sizeof(CardMemory), file));
  close(file);
  reset();
}

DrivenRig::~DrivenRig() {
  munmap(card_, sizeof(CardMemory));
  std::error_code ignored;
  fs::remove(file_, ignored);
}

std::string DrivenRig::obstacle() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return "a sanitizer must be loaded before the stand-in card, and is no program to measure times of";
#endif
  if (geteuid() != 0) return "needs root: a rig file that drives a card belongs to root";
  return may_be_fifo() ? "" : "needs SCHED_FIFO";
}

void DrivenRig::reset() {
  new (card_) CardMemory;
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&card_->mutex, &attributes);
  pthread_mutexattr_destroy(&attributes);
}

std::vector<std::string> DrivenRig::environment() const {
  return {std::string("LD_PRELOAD=") + EHA_STAND_IN_CARD_LIBRARY, std::string(kCardFile) + "=" + file_.string()};
}

std::string DrivenRig::rig_text(std::optional<int> cpu) {
  std::string text = replaced(content_of(source_file("config/rigs/pci1716.toml")), "sample = true ", "# no sample ");
  if (cpu) text = replaced(text, "# cpu = 1 ", "cpu = " + std::to_string(*cpu) + " ");
  // What a shared machine does to the ticks is not under test, and it takes processors away for 0.1 s.
  text = replaced(text, "abort_consecutive_late = 5 ", "abort_consecutive_late = 1000 ");
  text = replaced(text, "abort_total_late = 50 ", "stall_limit_s = 0.15\nabort_total_late = 10000 ");
  return text;
}

bool DrivenRig::is_driven(std::uint64_t ticks) const {
  const auto deadline = std::chrono::steady_clock::now() + kGenerousStart;
  while (!card_->is_enabled() || card_->commands < ticks) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

os::FileDescriptor DrivenRig::take_output() const {
  os::FileDescriptor file(open(file_.c_str(), O_RDWR | O_CLOEXEC));
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = kOutputSubdevice;
  lock.l_len = 1;
  if (fcntl(file.get(), F_OFD_SETLK, &lock) != 0) throw std::runtime_error("somebody else has the output");
  return file;
}

Driver::Driver(std::vector<std::string> words, const std::vector<std::string>& environment, const fs::path& at) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
  stream_ = ends[0];
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addchdir_np(&actions, at.c_str());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::vector<std::string> variables = environment;
  std::vector<char*> strings;
  for (std::string& variable : variables) strings.push_back(variable.data());
  for (char** own = environ; *own != nullptr; ++own) strings.push_back(*own);
  strings.push_back(nullptr);
  const int error = posix_spawn(&pid_, words.front().c_str(), &actions, nullptr, arguments.data(), strings.data());
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error != 0) throw std::runtime_error("cannot start " + words.front());
}

Driver::~Driver() {
  if (pid_ > 0) kill(pid_, SIGKILL);
  if (pid_ > 0) waitpid(pid_, nullptr, 0);
  close(stream_);
}

void Driver::send(int signal) const { kill(pid_, signal); }

void Driver::end(int signal) {
  send(signal);
  siginfo_t ended{};
  waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOWAIT);
}

int Driver::wait() {
  std::array<char, 4096> bytes{};
  for (ssize_t count = 0; (count = read(stream_, bytes.data(), bytes.size())) > 0;) {
    messages_.append(bytes.data(), static_cast<std::size_t>(count));
  }
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Hogs::Hogs(const std::vector<int>& cpus, std::chrono::milliseconds duration)
    : begun_ns_(new (shared_memory(sizeof(std::atomic<std::int64_t>), -1)) std::atomic<std::int64_t>(0)) {
  const std::int64_t duration_ns = std::chrono::nanoseconds(duration).count();
  for (const int cpu : cpus) {
    const pid_t child = fork();
    if (child == 0) hog(cpu, duration_ns, *begun_ns_);
    hogs_.push_back(child);
  }
}

Hogs::~Hogs() {
  wait();
  munmap(begun_ns_, sizeof *begun_ns_);
}

void Hogs::wait() {
  for (const pid_t child : hogs_) waitpid(child, nullptr, 0);
  hogs_.clear();
}

std::int64_t Hogs::begun_ns() {
  wait();
  return begun_ns_->load();
}

fs::path only_run(const fs::path& runs) {
  const std::vector<fs::path> found = record::list_runs(runs);
  if (found.size() != 1) throw std::runtime_error(std::to_string(found.size()) + " runs in " + runs.string());
  return found.front();
}

std::uint64_t ticks_recorded(const fs::path& run) {
  std::uint64_t ticks = 0;
  record::read_journal(run / record::kJournalFile, [&](std::span<const acquisition::TickRecord> records) {
    for (const acquisition::TickRecord& row : records) ticks += (row.flags & acquisition::kSkipped) == 0 ? 1 : 0;
  });
  return ticks;
}

pid_t thread_named(pid_t process, const std::string& name) {
  for (const auto& task : fs::directory_iterator(fs::path("/proc") / std::to_string(process) / "task")) {
    std::ifstream comm(task.path() / "comm");
    std::string line;
    if (std::getline(comm, line) && line == name) return std::stoi(task.path().filename().string());
  }
  throw std::runtime_error("no thread " + name);
}

pid_t child_of(pid_t process) {
  std::vector<pid_t> children;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = stat_of(entry.path());
    if (stat.size() > 2 && std::stoi(stat.substr(2)) == process) children.push_back(std::stoi(name));
  }
  if (children.size() != 1) throw std::runtime_error(std::to_string(children.size()) + " children");
  return children.front();
}

bool waits_for_disk(pid_t process) {
  std::error_code has_ended;
  for (const auto& task : fs::directory_iterator(fs::path("/proc") / std::to_string(process) / "task", has_ended)) {
    if (stat_of(task.path()).starts_with('D')) return true;
  }
  return false;
}

}  // namespace eha::test
