// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/daemon.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <thread>

#include "core/error.hpp"
#include "daemon/control/socket_address.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

/// Polling interval for conditions that send no notification.
constexpr auto kLook = std::chrono::milliseconds(5);

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("the shipped experiment has no " + what);
  return text.replace(at, what.size(), by);
}

}  // namespace

Daemon::Daemon(const std::string& settings, const fs::path& base) : folder_(base), log_file_(folder_.path() / "log") {
  folder_.write("ehad.toml", settings);
  fs::copy_file(source_file("config/rigs/sim.toml"), rig_file());
  const sockaddr_un address = control::socket_address(folder_.path() / "notify");
  manager_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (bind(manager_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("cannot be a service manager");
  }
  manager_thread_ = std::thread([this] { manage(); });
}

Daemon::~Daemon() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  shutdown(manager_, SHUT_RDWR);
  manager_thread_.join();
  close(manager_);
}

void Daemon::manage() {
  std::array<char, 4096> message{};
  for (;;) {
    const ssize_t size = recv(manager_, message.data(), message.size(), 0);
    if (size <= 0) return;
    const std::lock_guard lock(mutex_);
    messages_.emplace_back(message.data(), static_cast<std::size_t>(size));
    told_.notify_all();
  }
}

void Daemon::start() {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_file_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  // Open across exec, as libcomedi's device is.
  posix_spawn_file_actions_addopen(&actions, kDeviceDescriptor, kDevice, O_RDONLY, 0);
  std::vector<std::string> words{EHAD_PROGRAM,
                                 "--rig",
                                 rig_file().string(),
                                 "--config",
                                 (folder_.path() / "ehad.toml").string(),
                                 "--state",
                                 (folder_.path() / "state").string(),
                                 "--socket",
                                 socket().string()};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::vector<std::string> variables{"NOTIFY_SOCKET=" + (folder_.path() / "notify").string(), "WATCHDOG_USEC=4000000"};
  variables.insert(variables.end(), environment_.begin(), environment_.end());
  std::vector<char*> environment;
  for (std::string& variable : variables) environment.push_back(variable.data());
  for (char** own = environ; *own != nullptr; ++own) environment.push_back(*own);
  environment.push_back(nullptr);
  const int error = posix_spawn(&pid_, EHAD_PROGRAM, &actions, nullptr, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start ehad");
  if (!hears("READY=1")) throw std::runtime_error("ehad is not ready: " + log());
}

int Daemon::stop(int signal) {
  send(signal);
  return wait();
}

void Daemon::send(int signal) const { kill(pid_, signal); }

int Daemon::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool Daemon::hears(const std::string& text, std::chrono::seconds patience) {
  const auto deadline = steady_clock::now() + patience;
  std::unique_lock lock(mutex_);
  for (;;) {
    while (!messages_.empty()) {
      const bool is_it = messages_.front().find(text) != std::string::npos;
      messages_.pop_front();
      if (is_it) return true;
    }
    if (has_ended() || steady_clock::now() > deadline) return false;
    told_.wait_for(lock, std::chrono::milliseconds(100));
  }
}

void Daemon::forget_messages() {
  const std::lock_guard lock(mutex_);
  messages_.clear();
}

bool Daemon::has_ended() const {
  siginfo_t ended{};
  return pid_ <= 0 ||
         (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == pid_);
}

bool Daemon::logs(const std::string& text, std::chrono::seconds patience) const {
  const auto deadline = steady_clock::now() + patience;
  for (;;) {
    const bool is_over = has_ended() || steady_clock::now() > deadline;
    if (log().find(text) != std::string::npos) return true;
    if (is_over) return false;
    std::this_thread::sleep_for(kLook);
  }
}

void Daemon::open_to_all() const {
  fs::permissions(folder_.path(), fs::perms(0755));
  fs::permissions(socket(), fs::perms(0666));
}

std::unique_ptr<control::Client> connect_as(uid_t uid, const Daemon& daemon) {
  // The kernel takes note of the effective user at connect().
  if (seteuid(uid) != 0) throw std::runtime_error("cannot become another user");
  std::unique_ptr<control::Client> client;
  try {
    client = std::make_unique<control::Client>(daemon.socket());
  } catch (...) {
    static_cast<void>(seteuid(0));
    throw;
  }
  if (seteuid(0) != 0) throw std::runtime_error("cannot become root again");
  return client;
}

bool can_change_user() {
  if (geteuid() == 0) return true;
  std::cerr << "not root: cannot act as two users\n";
  return false;
}

std::string experiment_text(const std::string& name, double duration_s) {
  std::string text = content_of(source_file("config/experiments/paper.toml"));
  text = replaced(text, "name = \"paper\"", "name = \"" + name + "\"");
  text = replaced(text, "duration_s = 50.0", fmt::format("duration_s = {:.2f}", duration_s));
  text = replaced(text, "discard_s = 10.0", "discard_s = 0.4");
  // One model, an integrator, which a few seconds determine: these tests are about the service.
  const std::size_t second = text.find("# The structures to fit.");
  const std::size_t end = text.find("[acceptance]");
  if (second == std::string::npos || end == std::string::npos) throw std::runtime_error("the experiment has changed");
  return text.replace(second, end - second,
                      "[[model]]\nname = \"io\"\nstructure = \"terms\"\n"
                      "denominator = [{ order = 1.0 }, { order = 0.0, coefficient = 0.0 }]\n\n");
}

std::string quiet_experiment_text(const std::string& name, double duration_s) {
  std::string text = replaced(experiment_text(name, duration_s), "offset_V = -0.1", "offset_V = -0.2");
  for (const char* amplitude : {"amplitude_V = 1.9", "amplitude_V = 1.6", "amplitude_V = 1.5"}) {
    text = replaced(text, amplitude, "amplitude_V = 0.04");
  }
  return text;
}

std::string faulting_experiment_text(const std::string& name) {
  std::string text = replaced(experiment_text(name, 40.0), "offset_V = -0.1", "offset_V = 4.0");
  for (const char* amplitude : {"amplitude_V = 1.9", "amplitude_V = 1.6", "amplitude_V = 1.5"}) {
    text = replaced(text, amplitude, "amplitude_V = 0.1");
  }
  return text;
}

std::int64_t submit(control::Client& client, const std::string& experiment, bool fast) {
  return client
      .call("submit", {{"experiment", experiment},
                       {"name", "test.toml"},
                       {"fast", fast},
                       {"accept_travel_risk", true},
                       {"detach", true}})
      .at("entry");
}

Json follow(const Daemon& daemon, std::int64_t entry, const std::function<bool(const Json&)>& enough) {
  control::Client client(daemon.socket());
  client.call("watch", {{"entry", entry}, {"rate_Hz", 25}});
  const auto deadline = steady_clock::now() + kGenerous;
  while (steady_clock::now() < deadline) {
    const std::optional<Json> snapshot = client.next_event(std::chrono::seconds(1));
    if (!snapshot) continue;
    if (snapshot->at("last") == true || (enough && enough(*snapshot))) return snapshot->at("entry");
  }
  throw std::runtime_error("experiment not over in time: " + daemon.log());
}

Refused refused(control::Client& client, const std::string& method, const Json& params) {
  try {
    client.call(method, params);
    return {};
  } catch (const Error& error) {
    return {static_cast<int>(error.exit_code()), error.what()};
  }
}

Json entry_of(const Daemon& daemon, std::int64_t entry) {
  const Json queue = control::Client(daemon.socket()).call("queue");
  for (const Json& found : queue.at("entries")) {
    if (found.at("entry") == entry) return found;
  }
  return nullptr;
}

}  // namespace eha::test
