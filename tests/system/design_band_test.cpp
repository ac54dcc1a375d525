// SPDX-License-Identifier: GPL-3.0-or-later
// An experiment made for a band of frequencies.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using Json = nlohmann::json;

TEST(DesignBand, FillsTheLimitsWithLowPeaksAndIsAValidExperiment) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml");
  const Ended made = run_eha(
      {"design", "--band", "0.05:1.5", "--tones", "30", "--rig", rig, "-o", "band.toml", "--json"}, folder.path());
  ASSERT_EQ(made.code, 0) << made.err;
  const Json design = Json::parse(made.out);
  EXPECT_EQ(design.at("tones"), 30);
  EXPECT_EQ(design.at("binding"), "slew");
  EXPECT_LT(design.at("crest_factor").at("voltage").get<double>(), 1.7);
  EXPECT_LT(design.at("crest_factor").at("slew").get<double>(), 1.7);
  const Ended checked = run_eha({"check", "band.toml", "--rig", rig}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_EQ(checked.err.find("no whole number of periods"), std::string::npos) << checked.err;
  EXPECT_NE(content_of(folder.path() / "band.toml").find("[hold]"), std::string::npos);
}

TEST(DesignBand, IsToBePlayedOnTheSimulatedRigThatItIsMadeFor) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml");
  for (const bool odd : {false, true}) {
    std::vector<std::string> words{"design", "--band", "0.2:1.5", "--period", "5", "--rig", rig, "-o", "band.toml"};
    if (odd) words.emplace_back("--odd-random");
    const Ended made = run_eha(words, folder.path());
    EXPECT_NE(made.out.find("\nwritten: band.toml, for the limits of " + rig + "\n"), std::string::npos) << made.out;
    EXPECT_NE(made.out.find("Next: eha run band.toml --local --fast --rig " + rig), std::string::npos)
        << made.out << made.err;
  }
}

TEST(DesignBand, MakesRealisationsOfOddLinesThatPartNoiseAndDistortion) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml");
  const Ended made = run_eha({"design", "--band", "0.2:1.5", "--period", "5", "--odd-random", "--realisations", "3",
                              "--rig", rig, "-o", "band.toml", "--json"},
                             folder.path());
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(Json::parse(made.out).at("duration_s"), 45.0);
  const Ended checked = run_eha({"check", "band.toml", "--rig", rig}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err;
  std::string text = content_of(folder.path() / "band.toml");
  text += "[[model]]\nname = \"il\"\nstructure = \"integrator_lag\"\n";
  folder.write("band.toml", text);
  const Ended run = run_eha({"run", "band.toml", "--local", "--fast", "--rig", rig, "--json"}, folder.path());
  const Json response = Json::parse(run.out).at("frequency_response");
  EXPECT_EQ(response.at("realisations"), 3);
  // The valve's dead band distorts more than the sensor's noise does.
  const Json& levels = response.at("levels");
  ASSERT_TRUE(levels.at("odd_distortion_dB").is_number()) << response;
  EXPECT_GT(levels.at("odd_distortion_dB").get<double>(), levels.at("noise_dB").get<double>() + 6.0);
}

TEST(DesignBand, RefusesABandWithoutLinesAndOneThatIsNone) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_eha({"design", "--band", "0.051:0.052"}, folder.path()).code, 2);
  EXPECT_EQ(run_eha({"design", "--band", "5:1"}, folder.path()).code, 2);
  EXPECT_EQ(run_eha({"design", "--tones", "5"}, folder.path()).code, 2);
  EXPECT_EQ(run_eha({"design", "--odd-random"}, folder.path()).code, 2);
  EXPECT_EQ(run_eha({"design", "--band", "0.1:1", "--realisations", "3"}, folder.path()).code, 2);
}

TEST(DesignOfAParameter, ThatDoesNotImproveItIsNotOfferedForARun) {
  const TemporaryFolder folder;
  const Ended fitted =
      run_eha({"fit", source_file("config/records/bench.csv"), "--model", "integrator_lag_valve", "-o", "models"},
              folder.path());
  ASSERT_EQ(fitted.code, 0) << fitted.err;
  const auto design = [&](const std::string& name) {
    return run_eha({"design", "--from", "models/integrator_lag_valve.json", "--improve", name, "-o", "better.toml"},
                   folder.path());
  };
  const Ended gain = design("K");
  ASSERT_EQ(gain.code, 0) << gain.err;
  EXPECT_NE(gain.out.find("does not improve K: a longer one may"), std::string::npos) << gain.out;
  EXPECT_EQ(gain.out.find("Next: eha run"), std::string::npos) << gain.out;
  EXPECT_NE(gain.out.find("Next: eha design --from models/integrator_lag_valve.json --improve K --to 0.0"),
            std::string::npos)
      << gain.out;
  // The answer's name of the time constant.
  const Ended lag = design("T");
  ASSERT_EQ(lag.code, 0) << lag.err;
  EXPECT_NE(lag.out.find("standard error of a2 now"), std::string::npos) << lag.out;
  const Ended resonance = design("f0");
  EXPECT_EQ(resonance.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(resonance.err.find("no single parameter of integrator_lag_valve"), std::string::npos) << resonance.err;
}

TEST(DesignOfAParameter, KeepsAnExperimentThatNoDesignImproves) {
  const TemporaryFolder folder;
  const Ended fitted =
      run_eha({"fit", source_file("config/records/bench.csv"), "--model", "integrator_lag_valve", "-o", "models"},
              folder.path());
  ASSERT_EQ(fitted.code, 0) << fitted.err;
  const auto design = [&](const std::vector<std::string>& more) {
    // A rig that is not simulated: the model file alone predicts, which is quick.
    std::vector<std::string> words{"design", "--from", "models/integrator_lag_valve.json",     "--improve",
                                   "a2",     "--rig",  source_file("config/rigs/pci1716.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return run_eha(words, folder.path());
  };
  ASSERT_EQ(design({"-o", "best.toml"}).code, 0);
  const Ended again = design({"best.toml", "-o", "again.toml"});
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("best.toml is kept"), std::string::npos) << again.out;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "again.toml"));

  std::ofstream(folder.path() / "poor.toml") << R"(schema = 1
name = "poor"
duration_s = 50.0

[excitation]
kind = "multisine"
tones = [ { frequency_Hz = 0.05, amplitude_V = 0.5, phase_rad = 0.0 } ]

[record]
discard_s = 10.0
decimation = 20
)";
  const Ended better = design({"poor.toml", "-o", "better.toml"});
  ASSERT_EQ(better.code, 0) << better.err;
  EXPECT_NE(better.out.find("written: better.toml"), std::string::npos) << better.out;
}

}  // namespace
}  // namespace eha::test
