// SPDX-License-Identifier: GPL-3.0-or-later
// Ten minutes in real time: a rig that moves a machine, on the stand-in for libcomedi, commissioned by somebody who
// answers the questions on a terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/system/drawn_rigs.hpp"
#include "tests/system/driven_rig.hpp"

namespace eha::test {
namespace {

using testing::HasSubstr;

struct Attended {
  int code = -1;
  int questions = 0;
  std::string text;
};

/// Executes a command line of eha on a terminal and answers yes to each of its questions.
Attended attended(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                  const std::filesystem::path& at, std::chrono::minutes patience) {
  Attended done;
  int terminal = -1;
  const pid_t process = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (process == 0) {
    std::filesystem::current_path(at);
    for (const std::string& variable : environment) putenv(::strdup(variable.c_str()));
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(::strdup(word.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments.front(), arguments.data());
    ::_exit(127);
  }
  const auto deadline = std::chrono::steady_clock::now() + patience;
  std::size_t answered = 0;
  std::array<char, 4096> bytes{};
  while (std::chrono::steady_clock::now() < deadline) {
    pollfd ready{.fd = terminal, .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, 1000) <= 0) continue;
    const ssize_t count = ::read(terminal, bytes.data(), bytes.size());
    if (count <= 0) break;
    done.text.append(bytes.data(), static_cast<std::size_t>(count));
    const std::size_t question = done.text.find("Type yes to go on: ", answered);
    if (question == std::string::npos) continue;
    answered = question + 1;
    ++done.questions;
    if (::write(terminal, "yes\n", 4) != 4) break;
  }
  int status = 0;
  // Its end closes the terminal; past the deadline it is still there.
  if (std::chrono::steady_clock::now() >= deadline) ::kill(process, SIGKILL);
  ::waitpid(process, &status, 0);
  ::close(terminal);
  done.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return done;
}

TEST(CommissionMachine, FindsItsValveAndKeepsThePromise) {
  if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  DrivenRig rig;
  rig.reset();
  rig.card().dead_band_V = 0.25;
  const TemporaryFolder folder;
  std::string text = DrivenRig::rig_text(std::nullopt);
  const std::size_t begin = text.find("[following]");
  text.erase(begin, text.find("# What the sensor's input can read.") - begin);
  folder.write("rig.toml", text);
  const Attended done = attended({EHA_PROGRAM, "commission", "rig.toml", "--local", "--ruler", "2.95in"},
                                 rig.environment(), folder.path(), std::chrono::minutes(20));
  ASSERT_EQ(done.code, 0) << done.text;
  EXPECT_THAT(done.text, HasSubstr("the axis keeps the controller's promise"));
  EXPECT_GE(done.questions, 6) << "doctor, valve sheet, rig file, record, controller, trial";
  EXPECT_FALSE(rig.card().is_enabled());
  const nlohmann::json steps = json_of(folder.path() / "commission" / "commission.json").at("steps");
  EXPECT_NEAR(steps.at("sheet").at("dead_band_V").at("value").get<double>(), 0.25, 0.01);
  EXPECT_NEAR(steps.at("sheet").at("gain_positive_in_per_V_s").at("value").get<double>(), CardMemory::kGain_in_per_V_s,
              0.005);
}

}  // namespace
}  // namespace eha::test
