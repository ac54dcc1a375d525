// SPDX-License-Identifier: GPL-3.0-or-later
// `eha design --improve n2` on simulated rigs that differ from the shipped one, as a user goes: the paper's experiment,
// a twin calibrated by its record alone, the design, and the record of the design. Predicted against achieved. Minutes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

constexpr int kRigs = 10;
constexpr double kFactor = 1.5;   // between what is predicted and what is achieved
constexpr int kPaperRecords = 4;  // their geometric mean: the fit keeps a noise model for some and not for others

constexpr const char* kModel = R"(
[[model]]
name = "fo_valve"
structure = "fo"
input_map = "valve"
)";

double between(double low, double high, std::mt19937_64& draw) {
  return low + (high - low) * static_cast<double>(draw() >> 11) * 0x1p-53;
}

/// The text with the value of a key replaced, and what follows it on the line.
std::string with_value(std::string text, const std::string& key, const std::string& value) {
  const std::size_t at = text.find("\n" + key + " = ");
  if (at == std::string::npos) throw std::runtime_error("no key " + key);
  const std::size_t end = text.find('\n', at + 1);
  return text.replace(at + 1, end - at - 1, key + " = " + value);
}

std::string number(double value) { return fmt::format("{:.6f}", value); }

/// The shipped rig with other oil, mass, friction and valve.
std::string perturbed_rig(int which) {
  std::mt19937_64 draw(static_cast<std::uint64_t>(which));
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  rig = with_value(rig, "bulk_modulus_bar", number(between(5500.0, 9000.0, draw)));
  rig = with_value(rig, "moving_mass_kg", number(between(15.0, 30.0, draw)));
  rig = with_value(rig, "coulomb_friction_N", number(between(80.0, 160.0, draw)));
  rig = with_value(rig, "viscous_friction_N_s_per_mm", number(between(4.0, 8.0, draw)));
  const double dead_band_V = between(0.1, 0.2, draw);
  const double null_V = -between(0.15, 0.25, draw);
  rig = with_value(rig, "valve_dead_band_V", number(dead_band_V));
  rig = with_value(rig, "valve_null_offset_V", number(-null_V));
  rig = with_value(rig, "valve_natural_frequency_Hz", number(between(35.0, 50.0, draw)));
  // What the rig's owner would have measured of this valve.
  rig = with_value(rig, "null_V", number(null_V));
  return with_value(rig, "dead_band_V", number(dead_band_V + 0.05));
}

class ImprovementOnRig : public testing::TestWithParam<int> {
 protected:
  /// Standard error of n2 by the record of an experiment with this noise. @returns NaN where the fit states none
  double std_by(const std::string& experiment, std::uint64_t seed) {
    folder_.write("rig.toml", with_value(rig_, "seed", fmt::format("{}", seed)));
    const Ended ended = run_eha({"run", experiment, "--local", "--fast", "--rig", "rig.toml", "--output",
                                 fmt::format("runs-{}", seed), "--json", "--accept-travel-risk"},
                                folder_.path());
    const json document = json::parse(ended.out, nullptr, false);
    if (document.is_discarded()) throw std::runtime_error(ended.err);
    run_ = document.at("run");
    for (const json& model : document.at("models")) {
      if (model.at("name") != "fo_valve") continue;
      for (const json& parameter : model.at("parameters")) {
        if (parameter.at("name") == "n2") return parameter.at("std").get<double>();
      }
    }
    return std::nan("");
  }

  /// The file of the model that the newest run gave.
  [[nodiscard]] std::string model_file() const {
    const std::string accepted = run_ + "/models/fo_valve.json";
    return std::filesystem::exists(folder_.path() / accepted) ? accepted : run_ + "/models/rejected/fo_valve.json";
  }

  TemporaryFolder folder_;
  std::string rig_ = perturbed_rig(GetParam());
  std::string run_;
};

TEST_P(ImprovementOnRig, AchievesWhatItPredicts) {
  const std::string paper = content_of(source_file("config/experiments/paper.toml"));
  folder_.write("paper.toml", with_value(paper, "procedure", "\"default\"") + kModel);
  const auto seed = 100 * static_cast<std::uint64_t>(GetParam());
  const double before = std_by("paper.toml", seed);
  // Nobody knows the rig; its twin is the shipped one, calibrated by the record.
  const Ended calibrated =
      run_eha({"replay", run_, "--rig", source_file("config/rigs/sim.toml"), "--calibrate", "valve_null_offset_V",
               "valve_dead_band_V", "coulomb_friction_N", "--twin", "twin.toml"},
              folder_.path());
  ASSERT_EQ(calibrated.code, 0) << calibrated.err;
  // Without EXPERIMENT it plays and uses as much as the paper's does.
  const Ended designed = run_eha({"design", "--from", model_file(), "--improve", "n2", "--twin", "twin.toml", "--rig",
                                  "rig.toml", "-o", "improved.toml", "--json"},
                                 folder_.path());
  ASSERT_EQ(designed.code, 0) << designed.err;
  const json design = json::parse(designed.out);
  const auto predicted = design.at("predicted_std").get<double>();
  const auto predicted_gain = before / predicted;

  const double achieved = std_by("improved.toml", seed + 1);
  double by_paper = std::log(before) / kPaperRecords;
  for (std::uint64_t i = 1; i < kPaperRecords; ++i) {
    by_paper += std::log(std_by("paper.toml", seed + 10 + i)) / kPaperRecords;
  }
  by_paper = std::exp(by_paper);
  const double gain = by_paper / achieved;
  fmt::print(
      "rig {}: n2 +- {:.4f} achieved, {:.4f} predicted (ratio {:.2f}, trials {}); {:.4f} by the paper's tones, of "
      "{} records; better by {:.2f}, {:.2f} predicted (ratio {:.2f})\n",
      GetParam(), achieved, predicted, achieved / predicted, design.at("predicted_std_range").dump(), by_paper,
      kPaperRecords, gain, predicted_gain, gain / predicted_gain);
  EXPECT_LE(achieved, kFactor * predicted);
  EXPECT_GE(achieved, predicted / kFactor);
  // Smaller than by the paper's tones in the same time. The factor predicted is one record's over the prediction, and
  // errors by single records of the paper's tones differ by a third and more: it is printed, not judged.
  EXPECT_GT(gain, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Ten, ImprovementOnRig, testing::Range(1, kRigs + 1));

}  // namespace
}  // namespace eha::test
