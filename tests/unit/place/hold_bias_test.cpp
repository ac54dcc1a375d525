// SPDX-License-Identifier: GPL-3.0-or-later
// What a hold does to what is identified: paper.toml's tones on the simulated rig, held and open loop, over many seeds
// of the sensor's noise.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "config/prepared_experiment.hpp"
#include "daemon/place/hold_source.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/structure/structures.hpp"
#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

std::span<const double> values_of(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The rows in state running, as `eha fit` reads them.
ident::Record record_of(const LongPlay& play) {
  const std::size_t first = play.first(acquisition::State::running);
  const auto rows = static_cast<Eigen::Index>(play.count(acquisition::State::running));
  ident::Record record{.step_s = 0.001, .input = Eigen::VectorXd(rows), .output = Eigen::VectorXd(rows)};
  for (Eigen::Index k = 0; k < rows; ++k) {
    const acquisition::TickRecord& row = play.rows[first + static_cast<std::size_t>(k)];
    record.input[k] = row.applied_V;
    record.output[k] = row.displacement_in;
  }
  return record;
}

using Estimates = std::map<std::string, ident::ParameterEstimate>;

Estimates estimates_of(const ident::Record& record) {
  ident::StructureOptions asked;
  asked.name = "lag_valve";
  asked.structure = ident::structures::behind_valve(ident::structures::lag());
  ident::FitOptions options;
  options.decimation = 40;
  options.discard_s = 10.0;
  options.split = 1.0;
  options.intervals = ident::IntervalMethod::straight;
  Estimates estimates;
  for (const ident::ParameterEstimate& one : ident::fit(record, asked, options).model.parameters) {
    if (!one.fixed) estimates[one.name] = one;
  }
  return estimates;
}

constexpr Eigen::Index kCompared = 40'000;  // rows, whole periods of the tones

struct Differences {
  int seeds = 0;
  int agree = 0;
  double sum = 0.0;
  double std_sum = 0.0;
};

TEST(HoldBias, LeavesGainOrdersAndMapAsOpenLoopFindsThem) {
  const char* wanted = std::getenv("EHA_HOLD_SEEDS");
  const int seeds = wanted != nullptr ? std::atoi(wanted) : 50;
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const std::string text = config::load_experiment(EHA_SOURCE_DIR "/config/experiments/paper.toml").text;
  const config::PreparedExperiment held = config::parse_prepared_experiment(text + "\n[hold]\n", "held.toml", rig);
  std::map<std::string, Differences> differences;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto played_with = [&](std::unique_ptr<acquisition::CommandSource> source) {
      auto options = std::get<hal::SimOptions>(rig.backend);
      options.seed = static_cast<std::uint64_t>(seed);
      const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
      LongPlay play;
      play.limits = rig.limits;
      StartingSource started(PlaceController(play.limits, 0.001, 2.95 + held.predicted_in[0]), play.limits, 0.001,
                             std::move(source));
      play.play_on(*plant, started);
      EXPECT_EQ(play.report.outcome, acquisition::Outcome::completed) << "seed " << seed;
      return record_of(play);
    };
    const ident::Record with_hold = played_with(std::make_unique<HoldSource>(
        values_of(held.table_V), values_of(held.predicted_in), 1U, config::HoldLaw{config::hold_gains(rig).usual, 1.0},
        LoopMonitor(loop_bounds(rig.limits), 0.001)));
    // The same tones without the loop, at the mean voltage that the loop found: the rod stays where the held one is.
    const Eigen::VectorXd open_V =
        held.table_V.array() + (with_hold.input.tail(kCompared) - held.table_V.tail(kCompared)).mean();
    const ident::Record without = played_with(std::make_unique<acquisition::TableSource>(values_of(open_V), 1U));
    const Estimates closed = estimates_of(with_hold);
    const Estimates open = estimates_of(without);
    ASSERT_EQ(open.size(), closed.size());
    for (const auto& [name, one] : closed) {
      const ident::ParameterEstimate& other = open.at(name);
      Differences& sum = differences[name];
      ++sum.seeds;
      sum.sum += one.value - other.value;
      sum.std_sum += 0.5 * (one.std + other.std);
      sum.agree += one.lower95 <= other.upper95 && other.lower95 <= one.upper95 ? 1 : 0;
    }
  }
  for (const auto& [name, sum] : differences) {
    const double bias = sum.sum / sum.seeds;
    const double std = sum.std_sum / sum.seeds;
    fmt::print("{:<20} mean difference {:+.5f}, {:+.3f} of the standard error {:.5f}; {} of {} intervals meet\n", name,
               bias, bias / std, std, sum.agree, sum.seeds);
    // Where the rod is at the start differs, by design.
    if (name == "initial_output") continue;
    EXPECT_LT(std::abs(bias), std / 3.0) << name;
    EXPECT_EQ(sum.agree, sum.seeds) << name;
  }
}

}  // namespace
}  // namespace eha::place
