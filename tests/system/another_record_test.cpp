// SPDX-License-Identifier: GPL-3.0-or-later
// A model on another record: where that begins, what its input does between the rows, and columns that are exchanged.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "ident/excitation/portable_draw.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

/// Levels of a positioner of 1.5 mm/V with a lag of 0.18 s and a dead time of 40 ms, at rest at the first one.
std::string positioner(std::uint64_t seed) {
  ident::PortableDraw draw(seed);
  std::string text = "time_s,cmd_V,pos_mm\n";
  std::vector<double> u;
  double x = 0.0;
  for (std::size_t k = 0; k < 3000; ++k) {
    u.push_back(k % 50 == 0 ? std::clamp(50.0 + 20.0 * draw.normal(), 15.0, 85.0) : u.back());
    if (k == 0) x = 1.5 * u[0];
    text += fmt::format("{:.2f},{:.4f},{:.3f}\n", 0.01 * static_cast<double>(k), u.back(), x + 0.05 * draw.normal());
    x += (1.0 - std::exp(-0.01 / 0.18)) * (1.5 * u[k < 4 ? 0 : k - 4] - x);
  }
  return text;
}

TEST(AnotherRecord, OfAPositionerWithADeadTimeIsOfTheSamePlant) {
  const TemporaryFolder folder;
  folder.write("a.csv", positioner(1));
  folder.write("b.csv", positioner(2));
  const Ended fitted = run_eha({"fit", "a.csv", "--model", "io1", "--delay", "free", "-o", "m", "-q"}, folder.path());
  ASSERT_EQ(fitted.code, 0) << fitted.out << fitted.err;
  const Ended validated = run_eha({"validate", "m/io1.json", "b.csv"}, folder.path());
  EXPECT_EQ(validated.code, 0) << validated.out << validated.err;
  EXPECT_NE(validated.out.find("io1 on b.csv: good"), std::string::npos) << validated.out;
  const Ended compared = run_eha({"compare", "m/io1.json", "b.csv", "--json"}, folder.path());
  EXPECT_EQ(nlohmann::json::parse(compared.out).at("models").at(0).at("plant"), "this") << compared.out;
  const auto first_output = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"simulate", "m/io1.json", "b.csv", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = run_eha(words, folder.path());
    return nlohmann::json::parse(ended.out).at("output").at(20).get<double>();
  };
  const std::string text = content_of(folder.path() / "b.csv");
  const double u = std::stod(text.substr(text.find("\n0.00,") + 6));
  EXPECT_NEAR(first_output({}), 1.5 * u, 0.1);
  EXPECT_GT(std::abs(first_output({"--input-before", "0"}) - 1.5 * u), 5.0);
}

/// Tones, sampled every 10 ms, to an integrator with a lag of 50 ms and a dead time of 25 ms.
std::string sampled_tones(double phase) {
  ident::PortableDraw draw(5);
  const double decay = std::exp(-0.001 / 0.05);
  const auto volts = [&](int k) {
    const double t = 2.0 * std::numbers::pi * 0.001 * k;
    return 2.0 * std::sin(0.31 * t + phase) + 1.5 * std::sin(1.3 * t + 2.0 * phase) + std::sin(4.1 * t);
  };
  std::string text = "time_s,valve_V,rod_mm\n";
  double y = 100.0;
  double speed = 0.0;
  for (int k = 0; k < 20'000; ++k) {
    if (k % 10 == 0) text += fmt::format("{:.2f},{:.6f},{:.5f}\n", 0.001 * k, volts(k), y + 0.002 * draw.normal());
    y += 0.001 * speed;
    speed = decay * speed + (1.0 - decay) * 22.0 * volts(k - 25);
  }
  return text;
}

TEST(InputBetweenRows, IsTakenAsTheModelTookIt) {
  const TemporaryFolder folder;
  folder.write("a.csv", sampled_tones(0.0));
  folder.write("b.csv", sampled_tones(1.0));
  const Ended fitted =
      run_eha({"fit", "a.csv", "--model", "integrator_lag", "--delay", "free", "--intersample", "foh", "-o", "m", "-q"},
              folder.path());
  ASSERT_EQ(fitted.code, 0) << fitted.out << fitted.err;
  for (const char* record : {"a.csv", "b.csv"}) {
    const Ended ended = run_eha({"validate", "m/integrator_lag.json", record}, folder.path());
    EXPECT_EQ(ended.code, 0) << ended.out << ended.err;
    EXPECT_NE(ended.err.find("straight lines between its rows, as integrator_lag was estimated"), std::string::npos)
        << ended.err;
    const Ended held = run_eha({"validate", "m/integrator_lag.json", record, "--intersample", "zoh"}, folder.path());
    EXPECT_EQ(held.err.find("straight lines"), std::string::npos) << held.err;
    // Of an input that differs from that of the model's own record, a wrong one between the rows can be the cause.
    if (record == std::string("a.csv")) {
      EXPECT_EQ(held.code, 3) << held.out;
      EXPECT_NE((held.out + held.err).find(" --intersample zoh -o comparison.html"), std::string::npos) << held.out;
    } else {
      EXPECT_NE(held.out.find("cannot tell whether it is of this plant"), std::string::npos) << held.out;
    }
    const Ended compared = run_eha({"compare", "m/integrator_lag.json", record, "--json"}, folder.path());
    EXPECT_EQ(nlohmann::json::parse(compared.out).at("models").at(0).at("plant"), "this") << compared.out;
  }
  const Ended simulated = run_eha({"simulate", "m/integrator_lag.json", "a.csv", "--json"}, folder.path());
  const auto document = nlohmann::json::parse(simulated.out);
  EXPECT_EQ(document.at("samples"), 2000);
  const std::string text = content_of(folder.path() / "a.csv");
  const double last = std::stod(text.substr(text.find_last_of(',') + 1));
  EXPECT_NEAR(document.at("output_last").get<double>(), last, 0.05) << simulated.err;
}

/// The positioner's file with its last two columns exchanged.
std::string exchanged(const std::string& text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::size_t first = text.find(',', at);
    const std::size_t second = text.find(',', first + 1);
    result += text.substr(at, first + 1 - at) + text.substr(second + 1, end - second - 1) + "," +
              text.substr(first + 1, second - first - 1) + "\n";
    at = end + 1;
  }
  return result;
}

TEST(ExchangedColumns, AreSuspectedWhereEveryModelIsRejected) {
  const TemporaryFolder folder;
  folder.write("x.csv", exchanged(positioner(1)));
  const Ended ended =
      run_eha({"fit", "x.csv", "--input", "pos_mm", "--output", "cmd_V", "--model", "io1"}, folder.path());
  const std::string all = ended.out + ended.err;
  EXPECT_EQ(ended.code, 3) << all;
  EXPECT_NE(all.find("because         Input and output may be exchanged"), std::string::npos) << all;
  EXPECT_NE(all.find("Next: eha fit x.csv --model io1 --input 3 --output 2"), std::string::npos) << all;
  EXPECT_EQ(all.find("is read more slowly"), std::string::npos) << all;
}

TEST(ExchangedColumns, AreNamedFirstWhereAModelIsHeldAgainstThem) {
  const TemporaryFolder folder;
  folder.write("a.csv", positioner(1));
  folder.write("x.csv", exchanged(positioner(1)));
  ASSERT_EQ(run_eha({"fit", "a.csv", "--model", "io1", "--delay", "free", "-o", "m"}, folder.path()).code, 0);
  // The columns are named after what they are not.
  std::string text = content_of(folder.path() / "x.csv");
  text.replace(0, text.find('\n'), "time_s,input_V,output_mm");
  folder.write("x.csv", text);
  const Ended held = run_eha({"validate", "m/io1.json", "x.csv"}, folder.path());
  const std::string all = held.out + held.err;
  EXPECT_EQ(held.code, 3) << all;
  EXPECT_NE(held.out.find("rejected\n  Input and output may be exchanged: as given the model has an R2 of "),
            std::string::npos)
      << all;
  EXPECT_EQ(held.out.find("amplitudes"), std::string::npos) << all;
  EXPECT_NE(all.find("Next: eha validate m/io1.json x.csv --input 3 --output 2"), std::string::npos) << all;
  const Ended compared = run_eha({"compare", "m/io1.json", "x.csv"}, folder.path());
  EXPECT_NE(compared.err.find("input and output may be exchanged: "), std::string::npos) << compared.err;
  EXPECT_NE((compared.out + compared.err).find("Next: eha validate m/io1.json x.csv --input 3 --output 2"),
            std::string::npos)
      << compared.out << compared.err;
  // The right way round nothing is said.
  const Ended right = run_eha({"validate", "m/io1.json", "a.csv"}, folder.path());
  EXPECT_EQ((right.out + right.err).find("exchanged"), std::string::npos) << right.out;
}

/// Tones to a mass with dry friction of 0.33 V, that a lag of 83 ms and 5 mm/(V s) follow while it moves.
std::string with_friction() {
  ident::PortableDraw draw(1);
  std::string text = "time_s,valve_V,rod_mm\n";
  double x = 0.0;
  double speed = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const double t = 0.02 * k;
    double u = 0.0;
    for (int i = 1; i <= 9; ++i) {
      u += 0.5 * std::sin(2.0 * std::numbers::pi * 0.05 * i * (i + 1) / 2.0 * t + 0.7 * i * i);
    }
    text += fmt::format("{:.2f},{:.4f},{:.4f}\n", t, u, x + 0.01 * draw.normal());
    for (int part = 0; part < 20; ++part) {
      const double pushed = speed + 0.001 / 0.083 * (5.0 * u - speed);
      speed = std::copysign(std::max(0.0, std::abs(pushed) - 0.001 / 0.083 * 5.0 * 0.33), pushed);
      x += 0.001 * speed;
    }
  }
  return text;
}

TEST(DryFriction, IsOfferedAsAStructureWhichDescribesIt) {
  const TemporaryFolder folder;
  folder.write("f.csv", with_friction());
  const Ended ended = run_eha({"fit", "f.csv", "--model", "integrator_lag_valve"}, folder.path());
  EXPECT_NE(ended.out.find("Next: eha fit f.csv --model friction -o models"), std::string::npos) << ended.out;
  EXPECT_EQ(ended.out.find("smaller amplitudes"), std::string::npos) << ended.out;
  const Ended offered = run_eha(
      {"fit", "f.csv", "--model", "integrator_lag_valve", "--model", "friction", "-o", "models"}, folder.path());
  EXPECT_EQ(offered.code, 0) << offered.out << offered.err;
  EXPECT_EQ(offered.out.find("--input-map"), std::string::npos) << "which a grey box cannot have: " << offered.out;
  EXPECT_NE(offered.out.find("recommended     friction ("), std::string::npos) << offered.out;
}

TEST(DryFriction, IsNoDeadEndOnTheShippedRecord) {
  const TemporaryFolder folder;
  const std::string bench = source_file("config/records/bench.csv").string();
  const Ended ladder = run_eha({"fit", bench, "-o", "m"}, folder.path());
  EXPECT_EQ(ladder.code, 0) << ladder.err;
  EXPECT_EQ(ladder.out.find("--model friction"), std::string::npos) << ladder.out;
  for (const auto& file : std::filesystem::directory_iterator(folder.path() / "m")) {
    const std::string text = content_of(file.path());
    if (text.find("\"grade\": \"rejected\"") != std::string::npos) continue;
    EXPECT_EQ(text.find("--model friction"), std::string::npos) << file.path();
  }
  const Ended asked = run_eha({"fit", bench, "--model", "friction", "-o", "f"}, folder.path());
  const std::string all = asked.out + asked.err;
  EXPECT_EQ(asked.code, 3) << all;
  EXPECT_EQ(all.find("eha design"), std::string::npos) << all;
}

/// A lag under tones whose sensor drifts. @param drift  at a row [mm]
std::string with_drift(const std::function<double(int)>& drift) {
  ident::PortableDraw draw(3);
  std::string text = "time_s,valve_V,rod_mm\n";
  double y = 0.0;
  for (int k = 0; k < 2000; ++k) {
    double u = 0.0;
    for (int i = 1; i <= 9; ++i) u += 0.7 * std::sin(0.31 * i * (i + 1) / 2.0 * 0.05 * k + 0.7 * i * i);
    text += fmt::format("{:.2f},{:.4f},{:.4f}\n", 0.05 * k, u, y + drift(k) + 0.02 * draw.normal());
    y += (1.0 - std::exp(-0.05 / 0.3)) * (5.0 * u - y);
  }
  return text;
}

TEST(DriftingSensor, IsTakenOutAsAStraightLine) {
  const TemporaryFolder folder;
  folder.write("d.csv", with_drift([](int k) { return 0.01 * k; }));
  const Ended ended = run_eha({"fit", "d.csv", "-o", "m"}, folder.path());
  EXPECT_EQ(ended.code, 0) << ended.out;
  EXPECT_NE(ended.err.find("the output drifts by 20 mm over the record: a straight line of "), std::string::npos)
      << ended.err;
  const std::string line = R"("trend": ")";
  for (const auto& file : std::filesystem::directory_iterator(folder.path() / "m")) {
    if (file.path().extension() != ".json") continue;
    EXPECT_NE(content_of(file.path()).find(line), std::string::npos) << file.path();
  }
}

/// Its straight line is the valve's: taken out, it was half a volt of the null that the fit gave.
TEST(DriftingRod, KeepsTheNullOfItsValve) {
  const TemporaryFolder folder;
  folder.write("drift.toml", R"(schema = 1
name = "drift"
duration_s = 50.0
[excitation]
kind = "multisine"
offset_V = 0.3
tones = [
  { frequency_Hz = 0.05, amplitude_V = 0.969, phase_rad = 1.8 },
  { frequency_Hz = 0.20, amplitude_V = 0.816, phase_rad = 1.9 },
  { frequency_Hz = 0.65, amplitude_V = 0.765, phase_rad = 4.2 },
]
[record]
discard_s = 2.0
decimation = 40
)");
  const Ended run = run_eha(
      {"run", "drift.toml", "--rig", EHA_RIGS "/sim.toml", "--local", "--fast", "--accept-travel-risk"}, folder.path());
  EXPECT_NE(run.err.find("travel_limit"), std::string::npos) << run.err;
  std::filesystem::path recorded;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "runs")) {
    if (!entry.is_symlink()) recorded = entry.path();
  }
  const Ended fitted = run_eha({"fit", recorded.string(), "-o", "m", "--json"}, folder.path());
  EXPECT_EQ(fitted.err.find("a straight line of "), std::string::npos) << fitted.err;
  int with_a_map = 0;
  const nlohmann::json answer = nlohmann::json::parse(fitted.out);
  for (const nlohmann::json& model : answer.at("models")) {
    if (!model.contains("input_map") || !model.at("verdict").at("accepted").get<bool>()) continue;
    ++with_a_map;
    EXPECT_NEAR(model.at("input_map").at("null").get<double>(), -0.2, 0.05) << model.at("name");
  }
  EXPECT_GE(with_a_map, 1) << fitted.out;
}

TEST(DryFriction, IsNotOfferedForPlay) {
  const TemporaryFolder folder;
  ident::PortableDraw draw(2);
  std::string text = "time_s,valve_V,rod_mm\n";
  double x = 0.0;
  double speed = 0.0;
  double shown = 0.0;
  for (int k = 0; k < 2500; ++k) {
    double u = 0.0;
    for (int i = 1; i <= 9; ++i) {
      u += 0.5 * std::sin(2.0 * std::numbers::pi * 0.05 * i * (i + 1) / 2.0 * 0.02 * k + 0.7 * i * i);
    }
    text += fmt::format("{:.2f},{:.4f},{:.4f}\n", 0.02 * k, u, shown + 0.01 * draw.normal());
    for (int part = 0; part < 20; ++part) {
      speed += 0.001 / 0.08 * (5.0 * u - speed);
      x += 0.001 * speed;
      shown = std::clamp(shown, x - 0.15, x + 0.15);
    }
  }
  folder.write("p.csv", text);
  const Ended ended = run_eha({"fit", "p.csv"}, folder.path());
  EXPECT_NE(ended.out.find("There is a play (backlash, hysteresis) of about 0."), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("its sensor"), std::string::npos) << ended.out;
  EXPECT_EQ(ended.out.find("--model friction"), std::string::npos) << ended.out;
}

}  // namespace
}  // namespace eha::test
