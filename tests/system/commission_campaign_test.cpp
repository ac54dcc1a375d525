// SPDX-License-Identifier: GPL-3.0-or-later
// `eha commission` on simulated rigs of which nothing is known. EHA_COMMISSION_RIGS: how many instead of 100.
// EHA_COMMISSION_FIRST: number of the first.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <string_view>

#include "tests/system/drawn_rigs.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

int number_of(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// Valve, oil, load, friction, noise and tick drawn; the limits are those of the shipped rig.
std::string drawn_rig(int number) {
  std::mt19937_64 draw(static_cast<std::uint64_t>(7000 + number));
  const auto between = [&draw](double low, double high) {
    return low + (high - low) * static_cast<double>(draw() >> 11) * 0x1p-53;
  };
  std::string rig = unknown_rig();
  const auto set = [&rig](const char* key, double value) { rig = with_value(std::move(rig), key, value); };
  const double coulomb_N = between(60.0, 200.0);
  set("valve_dead_band_V", between(0.05, 0.4));
  set("valve_null_offset_V", between(-0.4, 0.4));
  set("valve_rated_flow_L_per_min", between(0.9, 1.8));
  set("valve_natural_frequency_Hz", between(25.0, 60.0));
  set("moving_mass_kg", between(10.0, 40.0));
  set("coulomb_friction_N", coulomb_N);
  set("static_friction_N", coulomb_N * between(1.1, 1.6));
  set("bulk_modulus_bar", between(4000.0, 9000.0));
  set("rod_mm", between(16.0, 26.0));
  set("sensor_noise_V", between(0.0004, 0.002));
  set("initial_displacement_in", between(2.2, 3.7));
  set("sub_step_us", 25.0);
  const double ticks_ms[] = {1.0, 2.0, 4.0};
  set("sample_period_s", 0.001 * ticks_ms[draw() % 3]);
  rig = with_value(std::move(rig), "seed", 0.0);
  const std::size_t at = rig.find("seed = 0.000000");
  return rig.replace(at, std::string_view("seed = 0.000000").size(), fmt::format("seed = {}", 1 + draw() % 1'000'000));
}

double value_of(const std::string& rig, const std::string& key) {
  return std::stod(rig.substr(rig.find("\n" + key + " = ") + key.size() + 4));
}

TEST(CommissionCampaign, KeepsThePromiseOnUnknownRigs) {
  const int rigs = number_of("EHA_COMMISSION_RIGS", 100);
  const int first = number_of("EHA_COMMISSION_FIRST", 0);
  int kept = 0;
  int changed = 0;
  int noticed = 0;
  int precise = 0;
  double longest_s = 0.0;
  for (int i = first; i < first + rigs; ++i) {
    const TemporaryFolder folder;
    folder.write("rig.toml", drawn_rig(i));
    const Ended ended = run_eha({"commission", "rig.toml", "--yes", "--fast"}, folder.path());
    double rig_s = 0.0;
    std::string outcomes;
    for (const json& run : manifests_of(folder.path() / "runs")) {
      const json& report = run.at("report");
      rig_s += report.at("counters").at("ticks").get<double>() * run.at("sample_period_s").get<double>();
      outcomes += " " + run.at("outcome").get<std::string>();
      EXPECT_TRUE(run.at("outcome") == "completed" || run.at("outcome") == "precise_enough") << "rig " << i << outcomes;
      EXPECT_LT(report.at("margins").at("travel").at("percent").get<double>(), 100.0) << "rig " << i;
    }
    EXPECT_LE(rig_s, 600.0) << "rig " << i;
    longest_s = std::max(longest_s, rig_s);
    kept += ended.code == 0 ? 1 : 0;
    precise += outcomes.find("precise_enough") != std::string::npos ? 1 : 0;
    std::string said =
        ended.code == 0 ? "" : ended.err.substr(ended.err.size() - std::min<std::size_t>(600, ended.err.size()));
    if (ended.code == 0 && i % 10 == 3) {
      ++changed;
      std::string rig = content_of(folder.path() / "rig.toml");
      const bool is_dead_band = i % 20 == 3;
      rig = is_dead_band
                ? with_value(rig, "valve_dead_band_V", value_of(rig, "valve_dead_band_V") + 0.1)
                : with_value(rig, "valve_rated_flow_L_per_min", 0.8 * value_of(rig, "valve_rated_flow_L_per_min"));
      folder.write("rig.toml", rig);
      const Ended track =
          run_eha({"track", "commission/axis.toml", "--local", "--fast", "--rig", "rig.toml", "--json"}, folder.path());
      bool is_named = false;
      if (track.code == 3) {
        const json document = json::parse(track.out);
        for (const json& change : document.at("changes")) {
          const auto text = change.get<std::string>();
          is_named = is_named || text.find(is_dead_band ? "half dead band" : "gain") == 0;
        }
        said += document.at("changes").dump();
      }
      if (track.code == 11) {
        // The rig's own following check was first.
        is_named = track.err.find(is_dead_band ? "shows: half dead band" : "shows: gain") != std::string::npos &&
                   track.err.find("the promise is not kept") != std::string::npos;
      }
      noticed += is_named ? 1 : 0;
      said += fmt::format(" changed {}: exit code {}, {}", is_dead_band ? "dead band" : "gain", track.code,
                          is_named ? "named" : "not named " + track.err);
    }
    fmt::print("rig {}: exit code {},{}, {:.0f} s of rig time {}\n", i, ended.code, outcomes, rig_s, said);
    std::fflush(stdout);
  }
  fmt::print("{} rigs: {} kept, {} ended early, at most {:.0f} s; of {} changed {} were noticed and named\n", rigs,
             kept, precise, longest_s, changed, noticed);
  EXPECT_GE(kept, static_cast<int>(0.95 * rigs));
  EXPECT_EQ(noticed, changed);
}

}  // namespace
}  // namespace eha::test
