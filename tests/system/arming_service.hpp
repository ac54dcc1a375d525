// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/program.hpp"

namespace eha::test {

using control::Client;

/// The built service on the stand-in card, and what arms it.
class ServiceArming : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  }
  /// Starts the service with the sample rig file, one part of it replaced.
  void start(const std::string& what = "", const std::string& by = "") {
    std::string text = DrivenRig::rig_text(std::nullopt);
    const std::size_t at = text.find(what);
    if (at == std::string::npos) throw std::runtime_error("the sample rig file has no " + what);
    std::ofstream(daemon_.rig_file()) << text.replace(at, what.size(), by);
    for (const std::string& variable : rig_.environment()) daemon_.set_environment(variable);
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
  }

  DrivenRig rig_;
  Daemon daemon_{"schema = 1\n", "/dev/shm"};  // as /run of a machine: the guard's page outlives both processes
  /// Plays an experiment during which the reading jumps, which ends it with a fault.
  void slip(double by_in, const char* fault) {
    const std::int64_t entry = submit(*client_, quiet_experiment_text("slips", 20.0), false);
    follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
    EXPECT_TRUE(rig_.is_driven(rig_.card().commands + 200)) << "rows for the monitor to know the noise";
    rig_.card().position_in += by_in;
    const Json over = follow(daemon_, entry);
    EXPECT_EQ(over.at("outcome"), "faulted") << over;
    EXPECT_EQ(over.at("note").get<std::string>().rfind(fault, 0), 0U) << over;
  }
  [[nodiscard]] Ended arm(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"arm", "--socket", daemon_.socket()};
    words.insert(words.end(), more.begin(), more.end());
    return run_eha(words, daemon_.folder());
  }
  /// Reads another rig file.
  void reload(const std::string& text) {
    std::ofstream(daemon_.rig_file()) << text;
    client_->call("reload");
  }

  std::unique_ptr<Client> client_;
};

inline constexpr int kTrip = static_cast<int>(ExitCode::safety_trip);

inline std::string text_with(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("no " + what + " in " + text);
  return text.replace(at, what.size(), by);
}

inline constexpr const char* kOffset = "offset_in = 2.95";

}  // namespace eha::test
