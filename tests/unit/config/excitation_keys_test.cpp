// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "edited.hpp"
#include "faults_of.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::config {
namespace {

/// An experiment of 10 s whose [excitation] holds what is given, from line 5 on.
std::string with_excitation(const std::string& keys) {
  return "schema = 1\nname = \"x\"\nduration_s = 10\n[excitation]\n" + keys +
         "[[model]]\nname = \"io\"\nstructure = \"io\"\n";
}

TEST(ExcitationKeys, AreReadForEveryKind) {
  using namespace ident;
  const auto excitation = [](const std::string& keys) {
    return parse_prepared_experiment(with_excitation(keys), "e.toml", rig()).config.played()->excitation.kind;
  };
  const std::string band = "amplitude_V = 2\nfrequency_min_Hz = 0.1\nfrequency_max_Hz = 0.9\n";
  EXPECT_EQ(std::get<Chirp>(excitation("kind = \"chirp\"\n" + band)).band.max_Hz, 0.9);
  EXPECT_EQ(std::get<Gaussian>(excitation("kind = \"gaussian\"\nseed = 9\n" + band)).seed, 9U);
  EXPECT_EQ(std::get<OddRandomMultisine>(excitation("kind = \"odd_random_multisine\"\n" + band)).amplitude_V, 2.0);
  EXPECT_EQ(std::get<Prms>(excitation("kind = \"prms\"\namplitude_V = 2\nlevels = 5\nhold_s = 0.5\n")).levels, 5);
  EXPECT_EQ(std::get<Step>(excitation("kind = \"step\"\namplitude_V = 2\nhold_s = 0.5\n")).hold_s, 0.5);
  EXPECT_EQ(std::get<Sine>(excitation("kind = \"sine\"\ntones = [{frequency_Hz = 1, amplitude_V = 1}]\n")).tones.size(),
            1U);
}

/// A folder with an experiment of 4 ticks that plays volts.csv.
class TableFile : public ::testing::Test {
 protected:
  /// @returns what is wrong with the experiment when volts.csv holds this
  std::vector<std::string> faults_with(std::string_view csv, const std::string& duration_s = "0.004") {
    (void)folder_.write("volts.csv", csv);
    const auto path =
        folder_.write("e.toml", edited(with_excitation("kind = \"table\"\nfile = \"volts.csv\"\noffset_V = 1\n"),
                                       "duration_s = 10", "duration_s = " + duration_s));
    try {
      prepared_ = load_prepared_experiment(path, rig());
    } catch (const ConfigError& error) {
      std::vector<std::string> lines = error.lines();
      for (std::string& line : lines) {
        const std::string folder = folder_.path().string() + "/";
        for (std::size_t at = line.find(folder); at != std::string::npos; at = line.find(folder)) {
          line.erase(at, folder.size());
        }
      }
      return lines;
    }
    return {};
  }

  test::TemporaryFolder folder_;
  PreparedExperiment prepared_;
};

TEST_F(TableFile, IsPlayedTickByTickWithTheOffset) {
  const Eigen::Vector4d expected(1.0, 1.01, 1.02, 1.01);
  EXPECT_EQ(faults_with("voltage_V\n0\n0.01\n0.02\n0.01\n"), std::vector<std::string>());
  EXPECT_EQ(prepared_.table_V, expected);
  EXPECT_EQ(faults_with("# measured\r\ntime_s, \"voltage_V\",displacement_in\r\n0.5,0,3\r\n0.501,0.01,3\r\n"
                        "0.502,0.02,\r\n0.503,0.01,3\r\n"),
            std::vector<std::string>());
  EXPECT_EQ(prepared_.table_V, expected);
}

TEST_F(TableFile, HasOneRowForEachTick) {
  EXPECT_EQ(faults_with("voltage_V\n0\n0\n0\n"),
            (std::vector<std::string>{"e.toml:6:8: excitation.file: expected 4 rows, one for each tick of 0.001 s in "
                                      "duration_s = 0.004, got 3 in volts.csv"}));
  EXPECT_EQ(faults_with("time_s,voltage_V\n0,0\n0.04,0\n0.08,0\n0.12,0\n"),
            (std::vector<std::string>{"e.toml:6:8: excitation.file: expected rows spaced by the rig's tick of 0.001 s, "
                                      "got 0.04 s in volts.csv"}));
}

TEST_F(TableFile, StaysWithinTheRigsLimits) {
  EXPECT_EQ(faults_with("voltage_V\n0\n1\n0\n0\n"),
            (std::vector<std::string>{"e.toml:4:1: excitation: expected changes within the limit of rig.toml, 20 V/s, "
                                      "got 1 V within 0.001 s at 0.001 s (peak 2 V, RMS 1.32 V); all amplitudes times "
                                      "0.02 pass"}));
  EXPECT_EQ(faults_with("voltage_V\n9\n9\n9\n9\n").size(), 1U);
}

TEST_F(TableFile, ThatCannotBeReadIsRefusedWithTheLine) {
  const auto refused = [&](std::string_view csv) { return faults_with(csv).at(0); };
  EXPECT_EQ(refused("voltage_V\n0\nabc\n"),
            "e.toml:6:8: excitation.file: volts.csv:3: voltage_V: expected a finite number, got \"abc\"");
  EXPECT_EQ(
      refused("voltage_V\n1,0005\n1,0010\n"),
      "e.toml:6:8: excitation.file: volts.csv:2: expected 1 fields as in the header, got 2; numbers have a decimal "
      "point, no comma");
  EXPECT_EQ(refused("voltage_V\ninf\n"),
            "e.toml:6:8: excitation.file: volts.csv:2: voltage_V: expected a finite number, got \"inf\"");
  EXPECT_EQ(refused("time_s,voltage_V\n0,0\n0.001\n"),
            "e.toml:6:8: excitation.file: volts.csv:3: voltage_V: expected a finite number, got \"\"");
  EXPECT_EQ(refused("volts\n0\n"),
            "e.toml:6:8: excitation.file: volts.csv:1: expected a header row with a column voltage_V, got \"volts\"");
  EXPECT_EQ(refused("voltage_V\n"), "e.toml:6:8: excitation.file: volts.csv: expected rows of voltages, got none");
  EXPECT_EQ(refused("time_s,voltage_V\n0,0\n0.001,0\n0.003,0\n0.004,0\n"),
            "e.toml:6:8: excitation.file: volts.csv:3: time_s: expected evenly spaced rows, 0.00133333333 s here, got "
            "0.001");
  std::filesystem::remove(folder_.path() / "volts.csv");
  try {
    (void)load_prepared_experiment(folder_.path() / "e.toml", rig());
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("volts.csv: cannot be read: No such file"), std::string::npos);
  }
}

TEST_F(TableFile, HasNoLineOfMoreThanOneMebibyte) {
  const std::string longest(kLongestTableLine - 2, ',');
  EXPECT_EQ(faults_with("voltage_V\n0" + longest + "\n0\n0\n0"), std::vector<std::string>());
  const std::vector<std::string> refused{
      "e.toml:6:8: excitation.file: volts.csv:2: expected a table of numbers, got a line of more than 1 MiB; check the "
      "path"};
  EXPECT_EQ(faults_with("voltage_V\n0" + longest + ",,\n0\n0\n0\n"), refused);
  EXPECT_EQ(faults_with("voltage_V\n" + std::string(2 * kLongestTableLine, '\0')), refused);
}

TEST_F(TableFile, IsNoPipeWhichNobodyMayWriteTo) {
  (void)faults_with("voltage_V\n0\n");
  std::filesystem::remove(folder_.path() / "volts.csv");
  ASSERT_EQ(mkfifo((folder_.path() / "volts.csv").c_str(), 0600), 0);
  const auto refused = [&] {
    try {
      (void)load_prepared_experiment(folder_.path() / "e.toml", rig());
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused().find("volts.csv: expected a CSV file, got a pipe, a socket or a device"), std::string::npos);
  std::filesystem::remove(folder_.path() / "volts.csv");
  std::ofstream(folder_.path() / "volts.csv") << "voltage_V\n";
  std::filesystem::resize_file(folder_.path() / "volts.csv", (std::uintmax_t{1} << 40U));
  EXPECT_NE(refused().find("volts.csv: expected a CSV file of at most 1 GiB"), std::string::npos);
}

TEST_F(TableFile, IsNotLookedForWhereOnlyTheTextWasSent) {
  const std::string text = with_excitation("kind = \"table\"\nfile = \"/etc/passwd\"\n");
  EXPECT_EQ(faults_of(text), (std::vector<std::string>{
                                 "e.toml:6:8: excitation.file: \"/etc/passwd\" is not sent with the experiment: the "
                                 "service receives the experiment's text only; play it with --local"}));
  const ExperimentConfig over = parse_experiment(text, "run.json", NamedFiles::leave);
  EXPECT_TRUE(std::get<ident::Table>(over.played()->excitation.kind).file.volts_V.empty());
}

TEST(ExcitationKeys, OfAnotherKindAreRefused) {
  EXPECT_EQ(
      faults_of(
          with_excitation("kind = \"sine\"\nlevels = 5\namplitude_V = 1\nseed = 1\n"
                          "tones = [{frequency_Hz = 1, amplitude_V = 1}, {frequency_Hz = 2, amplitude_V = 1}]\n")),
      (std::vector<std::string>{"e.toml:6:10: excitation.levels: expected no such key (kind = \"sine\"), got 5",
                                "e.toml:7:15: excitation.amplitude_V: expected no such key (kind = \"sine\"), got 1",
                                "e.toml:8:8: excitation.seed: expected no such key (kind = \"sine\"), got 1",
                                "e.toml:9:9: excitation.tones: expected one tone for kind = \"sine\", got 2"}));
  EXPECT_EQ(faults_of(with_excitation("kind = \"chirp\"\namplitude_V = 1\ntones = []\nhold_s = 1\n"
                                      "frequency_min_Hz = 2\nfrequency_max_Hz = 1\n")),
            (std::vector<std::string>{
                "e.toml:7:9: excitation.tones: expected no such key (kind = \"chirp\"), got an array",
                "e.toml:8:10: excitation.hold_s: expected no such key (kind = \"chirp\"), got 1",
                "e.toml:10:20: excitation.frequency_max_Hz: expected more than frequency_min_Hz = 2, got 1"}));
}

TEST(ExcitationKeys, ThatTheKindNeedsAreMissed) {
  EXPECT_EQ(
      faults_of(with_excitation("kind = \"prms\"\n")),
      (std::vector<std::string>{"e.toml:4:1: excitation.amplitude_V: expected a number above 0, got no such key",
                                "e.toml:4:1: excitation.levels: expected an integer from 3 to 1000, got no such key",
                                "e.toml:4:1: excitation.hold_s: expected a number above 0, got no such key"}));
  EXPECT_EQ(faults_of(with_excitation("")).at(0),
            "e.toml:4:1: excitation.kind: expected \"multisine\", \"odd_random_multisine\", \"prms\", \"chirp\", "
            "\"gaussian\", \"step\", \"sine\" or \"table\", got no such key");
  EXPECT_EQ(faults_of(with_excitation("kind = \"multisine\"\ntones = [1]\n")),
            (std::vector<std::string>{"e.toml:6:10: excitation.tones[0]: expected a table, got 1"}));
}

TEST(ExcitationKeys, ThatTheRigCannotPlayAreRefused) {
  EXPECT_EQ(
      faults_of(with_excitation("kind = \"gaussian\"\namplitude_V = 1\nfrequency_min_Hz = 0.11\n"
                                "frequency_max_Hz = 0.19\n")),
      (std::vector<std::string>{"e.toml:4:1: excitation: expected a signal that can be played, got excitation: "
                                "expected a band that holds a multiple of 0.1 Hz (1 / duration), got 0.11..0.19 Hz"}));
  EXPECT_EQ(faults_of(with_excitation("kind = \"chirp\"\namplitude_V = 1\nfrequency_min_Hz = 1\n"
                                      "frequency_max_Hz = 500\n")),
            (std::vector<std::string>{"e.toml:8:20: excitation.frequency_max_Hz: expected less than the Nyquist "
                                      "frequency of the tick, 500 Hz, got 500"}));
  EXPECT_EQ(faults_of(with_excitation("kind = \"prms\"\namplitude_V = 4\nlevels = 3\nhold_s = 0.1\n")),
            (std::vector<std::string>{"e.toml:4:1: excitation: expected changes within the limit of rig.toml, 20 V/s, "
                                      "got 8 V within 0.1 s at 0.1 s (peak 4 V, RMS 3.53 V); all amplitudes times 0.25 "
                                      "pass"}));
  EXPECT_EQ(
      faults_of(with_excitation("kind = \"step\"\namplitude_V = 4\nhold_s = 10\n")).back(),
      "e.toml:7:10: excitation.hold_s: expected a time from one tick, 0.001 s, to less than duration_s = 10, got 10");
}

}  // namespace
}  // namespace eha::config
