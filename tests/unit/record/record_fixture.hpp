// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/play/play.hpp"
#include "daemon/record/run_folder.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::record {

/// A folder of its own for each test, and a short experiment on the simulated rig.
class RecordTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "eha-record-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;

    rig_config_.name = "test";
    rig_config_.text = "schema = 1\n";
    rig_config_.limits = {.command_min_V = -5.0,
                          .command_max_V = 5.0,
                          .slew_V_per_s = 100.0,
                          .safe_V = 0.0,
                          .travel_min_in = 0.2,
                          .travel_max_in = 5.7,
                          .stopping_deceleration_in_per_s2 = 400.0,
                          .velocity_limit_in_per_s = 20.0,
                          .frozen_sensor_s = 0.5};
    experiment_.name = "sine";
    experiment_.text = "schema = 1\n";
    experiment_.fit.decimation = 40;
    experiment_.fit.discard_s = 0.5;
    set_duration(2.0);
  }

  void TearDown() override { std::filesystem::remove_all(folder_); }

  void set_duration(double duration_s) {
    experiment_.duration_s = duration_s;
    table_V_.resize(static_cast<std::size_t>(std::llround(duration_s * 1000.0)));
    for (std::size_t k = 0; k < table_V_.size(); ++k) {
      table_V_[k] = 1.5 * std::cos(2.0 * std::numbers::pi * 0.5 * static_cast<double>(k) * 0.001);
    }
  }

  /// A new run folder under folder_/runs, and how to play into it.
  [[nodiscard]] play::PlayRequest request(const std::string& runs = "runs") const {
    return {.rig = rig_config_,
            .experiment = experiment_,
            .table_V = table_V_,
            .folder = create_run_folder(folder_ / runs, experiment_.name),
            .time_base = acquisition::TimeBase::virtual_time};
  }

  [[nodiscard]] play::FinishedRun run(const std::string& runs = "runs") {
    const std::unique_ptr<hal::Rig> rig =
        hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), rig_config_.limits.safe_V);
    return run_on(*rig, runs);
  }

  [[nodiscard]] play::FinishedRun run_on(hal::Rig& rig, const std::string& runs = "runs") {
    acquisition::StateMachine machine;
    EXPECT_TRUE(machine.reset() && machine.arm());
    return play::play(rig, machine, request(runs), stop_);
  }

  std::filesystem::path folder_;
  config::RigConfig rig_config_;
  config::ExperimentConfig experiment_;
  std::vector<double> table_V_;
  acquisition::StopRequest stop_;
};

}  // namespace eha::record
