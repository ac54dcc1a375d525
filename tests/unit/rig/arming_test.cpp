// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/arming.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "config/measured_check.hpp"
#include "core/error.hpp"
#include "hal/backends/backend.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"

namespace eha {
namespace {

config::RigConfig card() {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  rig.is_sample = false;
  return rig;
}

/// The refusal of the card's rig after a change, empty when it may be armed.
std::string refusal(const std::function<void(config::RigConfig&)>& change) {
  config::RigConfig rig = card();
  change(rig);
  try {
    require_protecting_limits(rig);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

/// Why a rig without an enable line is not opened; there is no such card.
std::string opening(double safe_V, const std::function<void(config::RigConfig&)>& change) {
  config::RigConfig rig = card();
  auto& options = std::get<hal::ComediOptions>(rig.backend);
  options.device = "/nonexistent/comedi0";
  options.enable.reset();
  options.enable_contact.reset();
  rig.limits.safe_V = safe_V;
  change(rig);
  try {
    static_cast<void>(open_at_rest(rig));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// A rig whose sensor drifts while the rod stands.
class DriftingRig final : public acquisition::FakeRig {
 public:
  explicit DriftingRig(double in_per_s) : in_per_s_(in_per_s) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const hal::RigStatus status = FakeRig::read(elapsed_ns, reading);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begun_;
    reading.displacement_in += in_per_s_ * passed.count();
    return status;
  }

 private:
  double in_per_s_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

/// How the inputs of a rig are judged.
ExitCode judged(hal::Rig& rig, const config::RigConfig& config) {
  try {
    require_plausible_inputs(rig, config);
  } catch (const Error& error) {
    return error.exit_code();
  }
  return ExitCode::ok;
}

TEST(OpenAtRest, PutsOutNoVoltageThatDrivesAValveWhoseHydraulicsStayOn) {
  const auto as_it_is = [](config::RigConfig&) {};
  const auto unmeasured = [](config::RigConfig& rig) { rig.limits.following.reset(); };
  const std::string opened = "/nonexistent/comedi0";  // named by what tries to open it
  EXPECT_NE(opening(4.0, as_it_is).find("safe_V = 4 V drives the valve"), std::string::npos) << opening(4.0, as_it_is);
  EXPECT_NE(opening(0.3, unmeasured).find("no enable line"), std::string::npos) << opening(0.3, unmeasured);
  EXPECT_NE(opening(0.05, unmeasured).find(opened), std::string::npos) << opening(0.05, unmeasured);
  const auto sample = [](config::RigConfig& rig) { rig.is_sample = true; };
  EXPECT_NE(opening(0.0, sample).find("sample = true"), std::string::npos) << opening(0.0, sample);
  // With an enable line the valve is off.
  config::RigConfig switched = card();
  std::get<hal::ComediOptions>(switched.backend).device = opened;
  switched.limits.safe_V = 4.0;
  EXPECT_THROW(static_cast<void>(open_at_rest(switched)), DeviceError);
}

TEST(OpenAtRest, OpensNoCardWhoseHydraulicsAreOnWhileTheComputerIsOff) {
  config::RigConfig rig = card();
  auto& options = std::get<hal::ComediOptions>(rig.backend);
  options.device = "/nonexistent/comedi0";
  options.enable->active = hal::ActiveLevel::low;
  EXPECT_THROW(static_cast<void>(open_at_rest(rig)), ConfigError);
  options.enable_contact = hal::ContactLine{};
  EXPECT_THROW(static_cast<void>(open_at_rest(rig)), DeviceError) << "the contact shows it";
}

TEST(OpenAtRest, TrustsNoDeadBandOrNullOfAFileThatNothingShowsToBeMeasured) {
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const auto valve = [](double null_V, double dead_band_V, double half_gain) {
    return [=](config::RigConfig& rig) {
      config::Following& following = *rig.limits.following;
      following.null_V = null_V;
      following.dead_band_V = dead_band_V;
      following.gain_positive_in_per_V_s = half_gain;
      following.gain_negative_in_per_V_s = half_gain;
    };
  };
  const auto measured = [](const auto& change) {
    return [=](config::RigConfig& rig) {
      change(rig);
      config::Following& following = *rig.limits.following;
      following.measured_check = config::measured_check_of(following);
      following.measured_rig_check = config::measured_rig_check_of(rig.backend);
    };
  };
  const std::string opened = "/nonexistent/comedi0";
  std::string text = opening(0.0, valve(0.4, 0.45, 0.07));
  EXPECT_TRUE(contains(text, "set 0.4, within 0.1 V of the valve's null")) << text;
  text = opening(0.4, valve(0.4, 0.45, 0.07));
  EXPECT_TRUE(contains(text, opened.c_str())) << text;
  text = opening(0.0, measured(valve(0.4, 0.45, 0.07)));
  EXPECT_TRUE(contains(text, opened.c_str())) << text;
  text = opening(0.0, valve(0.04, 0.02, 0.07));
  EXPECT_TRUE(contains(text, "within 0.02 V")) << text;
  text = opening(0.0, valve(0.09, 0.45, 0.6));
  EXPECT_TRUE(contains(text, "moves the rod at 0.11 in/s if the valve has no dead band")) << text;
  text = opening(0.4, valve(0.4, 0.45, 0.6));
  EXPECT_TRUE(contains(text, "if the valve's null were -0.4 V")) << text;
  EXPECT_EQ(text.find(opened), std::string::npos) << text;
}

TEST(OpenAtRest, SaysWhetherTheHydraulicsAreOff) {
  config::RigConfig rig = card();
  EXPECT_EQ(rest_text(rig), "at 0 V with the hydraulics off");
  std::get<hal::ComediOptions>(rig.backend).enable.reset();
  EXPECT_EQ(rest_text(rig), "at 0 V without an enable line: the hydraulics stay on");
}

TEST(Arming, RefusesEachShippedRigThatMovesAMachineBecauseItIsASample) {
  const std::string text = refusal([](auto& rig) { rig.is_sample = true; });
  EXPECT_NE(text.find("sample = true"), std::string::npos) << text;
  for (const auto& file : std::filesystem::directory_iterator(EHA_SOURCE_DIR "/config/rigs")) {
    const config::RigConfig rig = config::load_rig(file.path());
    EXPECT_TRUE(rig.is_sample) << file.path();
    EXPECT_EQ(arming_findings(rig).refusals.empty(), !hal::moves_machine(rig.backend)) << file.path();
  }
}

TEST(Arming, TakesTheShippedCardWithoutAWord) {
  const ArmingFindings findings = arming_findings(card());
  EXPECT_TRUE(findings.refusals.empty());
  EXPECT_TRUE(findings.warnings.empty());
}

TEST(Arming, RefusesLimitsThatProtectFromNothingAndNamesAValueThatDoes) {
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  std::string text = refusal([](auto& rig) { rig.limits.safe_V = 4.9; });
  EXPECT_TRUE(contains(text, "not armed: limits.safe_V = 4.9 V drives the valve; set 0")) << text;
  text = refusal([](auto& rig) { rig.limits.velocity_limit_in_per_s = 1e9; });
  EXPECT_TRUE(contains(text, "limits.velocity_limit_in_per_s = 1e+09") && contains(text, "at most 56")) << text;
  text = refusal([](auto& rig) { rig.limits.slew_V_per_s = 1e9; });
  EXPECT_TRUE(contains(text, "limits.slew_V_per_s = 1e+09") && contains(text, "at most 1e+03")) << text;
  text = refusal([](auto& rig) { rig.limits.slew_V_per_s = 2.0; });
  EXPECT_TRUE(contains(text, "limits.slew_V_per_s = 2 V/s: a stop") && contains(text, "2.5 s; set at least 2.5"))
      << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.limits.slew_V_per_s = 2.5; }), "");
  text = refusal([](auto& rig) { rig.limits.stopping_deceleration_in_per_s2 = 1e12; });
  EXPECT_TRUE(contains(text, "limits.stopping_deceleration_in_per_s2") && contains(text, "at most 3861")) << text;
}

TEST(Arming, RefusesASlipOfThePenInFollowing) {
  using Following = config::Following;
  struct Slip {
    std::function<void(Following&)> make;
    const char* refused;
  };
  const auto widen = [](Following& f, std::optional<double> uncertainty_V) {
    f.dead_band_V = 1.2;
    f.gain_positive_in_per_V_s = 0.6;
    f.dead_band_uncertainty_V = uncertainty_V;
  };
  const auto slow = [](Following& f, double positive, double negative) {
    f.gain_positive_in_per_V_s = positive;
    f.gain_negative_in_per_V_s = negative;
    f.measured_check = config::measured_check_of(f);
    f.measured_rig_check = config::measured_rig_check_of(card().backend);
  };
  const std::vector<Slip> slips{
      {[](Following& f) { f.dead_band_V = 3.0; }, "following.dead_band_V = 3 V is more than 30 %"},
      {[](Following& f) { f.dead_band_V = 1.5; }, ""},
      {[&](Following& f) { widen(f, {}); }, "if the valve had none, the rod would move at 1.4 in/s"},
      {[&](Following& f) { widen(f, 0.02); }, "if the valve had none, the rod would move at 1.4 in/s"},
      {[&](Following& f) {
         widen(f, 0.02);
         f.measured_check = config::measured_check_of(f);
         f.measured_rig_check = config::measured_rig_check_of(card().backend);
       },
       ""},
      {[&](Following& f) {
         widen(f, 0.02);
         f.measured_check = config::measured_check_of(f);  // of before: it names no rig
       },
       "its lines with measured_check and measured_rig_check"},
      {[&](Following& f) {
         f.measured_check = config::measured_check_of(f);
         f.measured_rig_check = config::measured_rig_check_of(card().backend) + 1;
       },
       "following.measured_rig_check does not fit"},
      {[](Following& f) {
         f.null_V = -2.0;
         f.gain_positive_in_per_V_s = 0.6;
       },
       "following.null_V = -2 V: if the valve's null were 2 V, the rod would move at 4.8 in/s"},
      {[](Following& f) {
         f.null_V = 0.4;  // within the dead band of the file
         f.dead_band_V = 0.5;
         f.gain_positive_in_per_V_s = 0.6;
       },
       "following.null_V = 0.4 V: if the valve's null were -0.4 V, the rod would move at 0.96 in/s"},
      {[](Following& f) {
         f.null_V = 0.3;
         f.dead_band_V = 0.2;
         f.gain_positive_in_per_V_s = 0.45;
         f.pressure_delay_s = 1.0;
       },
       "if the valve's null were -0.3 V, the rod would move 0.36 in before a dead sensor shows; set at most 0.28"},
      {[](Following& f) {
         f.null_V = 0.3;
         f.dead_band_V = 0.2;
         f.gain_positive_in_per_V_s = 0.45;
         f.gain_negative_in_per_V_s = 0.4;
         f.pressure_delay_s = 0.27;
       },
       ""},
      {[](Following& f) {
         f.dead_band_V = 0.1;  // the valve's null may be 0.3 V from 0 V
         f.gain_positive_in_per_V_s = 0.45;
         f.pressure_delay_s = 1.0;
       },
       "if the valve's null were -0.3 V, the rod would move 0.18 in"},
      {[&](Following& f) {
         widen(f, 0.02);
         f.dead_band_V = 0.2;
         f.measured_check = config::measured_check_of(f);
         f.dead_band_V = 1.2;
       },
       "following.measured_check does not fit"},
      {[](Following& f) {
         f = {.gain_positive_in_per_V_s = 1.18, .gain_negative_in_per_V_s = 1.03, .null_V = -0.42, .dead_band_V = 0.05};
       },
       "limits.safe_V = 0 V, 0.42 V from the valve's null, moves the rod at 0.87 in/s"},
      {[](Following& f) {
         f = {.gain_positive_in_per_V_s = 1.18, .gain_negative_in_per_V_s = 1.03, .null_V = -0.17, .dead_band_V = 0.05};
         f.measured_check = config::measured_check_of(f);
         f.measured_rig_check = config::measured_rig_check_of(card().backend);
       },
       ""},
      {[](Following& f) { f.limit_in = 0.29; }, "following.limit_in = 0.29 in is more than 5 % of the travel; set 0.1"},
      {[](Following& f) { f.limit_in = 0.27; }, ""},
      {[](Following& f) { f.pressure_delay_s = 5.0; }, "following.pressure_delay_s = 5 s"},
      {[](Following& f) { f.pressure_delay_s = 3.0; }, ""},
      {[](Following& f) { f.gain_positive_in_per_V_s = 0.0493; },
       "following.gain_positive_in_per_V_s = 0.0493 in/(V s) is less than 0.05, with which a dead sensor would show "
       "late; mm for inches? If the rod is so slow, measure it (`eha characterise`, or the same with the run of an "
       "earlier one"},
      {[](Following& f) { f.gain_negative_in_per_V_s = 0.0493; }, "following.gain_negative_in_per_V_s = 0.0493"},
      {[](Following& f) { f.gain_negative_in_per_V_s = 0.05; }, ""},
      {[&](Following& f) { slow(f, 0.0493, 0.0493); }, ""},
      {[&](Following& f) { slow(f, 0.0079, 0.0081); }, "following.gain_positive_in_per_V_s = 0.0079"},
      {[&](Following& f) { slow(f, 0.0081, 0.0079); }, "at least 0.008"},
      {[&](Following& f) { slow(f, 0.0081, 0.0081); }, ""},
      {[](Following& f) { f.gain_negative_in_per_V_s = 0.0081; }, "no rod is 8.6 times as fast one way as the other"},
      {[](Following& f) { f.gain_positive_in_per_V_s = 0.6; }, "times as fast one way as the other"},
  };
  for (const Slip& slip : slips) {
    const std::string text = refusal([&](auto& rig) { slip.make(*rig.limits.following); });
    EXPECT_EQ(text.empty(), std::string(slip.refused).empty()) << text << slip.refused;
    EXPECT_NE(text.find(slip.refused), std::string::npos) << text << slip.refused;
  }
}

TEST(Arming, TakesMeasuredNumbersOnTheirOwnRigOnly) {
  const auto text_on = [](const std::function<void(hal::ComediOptions&)>& change) {
    return refusal([&](auto& rig) {
      config::Following& following = *rig.limits.following;
      following.measured_check = config::measured_check_of(following);
      following.measured_rig_check = config::measured_rig_check_of(rig.backend);
      change(std::get<hal::ComediOptions>(rig.backend));
    });
  };
  EXPECT_EQ(text_on([](auto&) {}), "");
  EXPECT_EQ(text_on([](auto& card) { card.feedback_settling_us = 20.0; }), "");
  const std::vector<std::function<void(hal::ComediOptions&)>> others{
      [](auto& card) { card.device = "/dev/comedi1"; }, [](auto& card) { card.board = "pci1710"; },
      [](auto& card) { card.feedback.channel = 2; },    [](auto& card) { card.command.channel = 1; },
      [](auto& card) { card.scale_in_per_V = 0.296; },  [](auto& card) { card.offset_in = 2.96; }};
  for (const auto& other : others) {
    const std::string text = text_on(other);
    EXPECT_NE(text.find("measured_rig_check does not fit"), std::string::npos) << &other - others.data() << text;
  }
}

TEST(Arming, TakesNoSheetBackAfterACalibrationThatHasChangedTheMeasuredGains) {
  const std::string text = refusal([](auto& rig) {
    config::Following& following = *rig.limits.following;
    following.measured_check = config::measured_check_of(following);
    following.measured_rig_check = config::measured_rig_check_of(rig.backend);
    std::get<hal::ComediOptions>(rig.backend).scale_in_per_V *= 1.6;
    following.gain_positive_in_per_V_s *= 1.6;
    following.gain_negative_in_per_V_s *= 1.6;
  });
  EXPECT_NE(text.find("measured_check and measured_rig_check do not fit"), std::string::npos) << text;
  EXPECT_NE(text.find("eha characterise --without-following -o rig-bare.toml"), std::string::npos) << text;
  EXPECT_EQ(text.find("put the lines of the sheet"), std::string::npos) << text;
}

TEST(Arming, RefusesATickOnWhichNoCheckActsInTimeAndABoundThatBoundsNothing) {
  std::string text = refusal([](auto& rig) { rig.realtime.sample_period_s = 0.051; });
  EXPECT_NE(text.find("realtime.sample_period_s = 0.051 s"), std::string::npos) << text;
  const auto as_measured = [](config::RigConfig& rig) {
    rig.limits.following->measured_check = config::measured_check_of(*rig.limits.following);
    rig.limits.following->measured_rig_check = config::measured_rig_check_of(rig.backend);
    rig.realtime.sample_period_s = 0.05;
  };
  EXPECT_EQ(refusal(as_measured), "");
  text = refusal([](auto& rig) { rig.realtime.sample_period_s = 0.003; });
  EXPECT_NE(text.find("sample_period_s = 0.003 s: [following] is not as it was measured"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.realtime.sample_period_s = 0.002; }), "");
  text = refusal([](auto& rig) { rig.realtime.stall_limit_s = 1.0; });
  EXPECT_NE(text.find("realtime.stall_limit_s = 1 s"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.realtime.stall_limit_s = 0.2; }), "");
  text = refusal([](auto& rig) { rig.realtime.abort_consecutive_late = 1'000'000; });
  EXPECT_NE(text.find("realtime.abort_consecutive_late = 1000000"), std::string::npos) << text;
  EXPECT_NE(text.find("at most 1000,"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.realtime.abort_consecutive_late = 1000; }), "");
  text = refusal([](auto& rig) { rig.realtime.abort_total_late = 10'001; });
  EXPECT_NE(text.find("realtime.abort_total_late = 10001"), std::string::npos) << text;
  EXPECT_NE(text.find("at most 10000,"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.realtime.abort_total_late = 10'000; }), "");
  text = refusal([](auto& rig) {
    rig.realtime.sample_period_s = 0.02;
    rig.realtime.abort_consecutive_late = 51;
  });
  EXPECT_NE(text.find("at most 50,"), std::string::npos) << text;
  text = refusal([](auto& rig) { rig.limits.closed_loop_max_V = 5.5; });
  EXPECT_NE(text.find("limits.closed_loop_max_V = 5.5 V"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.limits.closed_loop_max_V = 3.0; }), "");
}

TEST(Arming, RefusesASensorWhoseOpenWireReadsAsAPlaceWithinTheTravel) {
  const std::string text = refusal([](auto& rig) { rig.limits.sensor->open_circuit_V = 0.0; });
  EXPECT_NE(text.find("sensor.open_circuit_V = 0 V reads as 2.950 in, within the travel"), std::string::npos) << text;
  EXPECT_EQ(refusal([](auto& rig) { rig.limits.sensor->open_circuit_V = -10.0; }), "");
  const std::string beyond = refusal([](auto& rig) { rig.limits.sensor->open_circuit_V = 100.0; });
  EXPECT_NE(beyond.find("sensor.open_circuit_V = 100 V is no reading of an input of -10 to 10 V"), std::string::npos)
      << beyond;
}

/// The warnings of a rig, a line each.
std::string warnings_of(const config::RigConfig& rig) {
  std::string lines;
  for (const std::string& sentence : arming_findings(rig).warnings) lines += sentence + '\n';
  return lines;
}

TEST(Arming, WarnsOfATravelThatIsTinyForTheSensorOrForAMachine) {
  config::RigConfig rig = card();
  rig.limits.travel_max_in = 5.75 / 25.4;
  std::string text = warnings_of(rig);
  EXPECT_NE(text.find("limits.travel_min_in..travel_max_in = 0.15..0.226378 in"), std::string::npos) << text;
  EXPECT_NE(text.find("1.3 % of the 5.9 in"), std::string::npos) << text;
  rig = card();
  rig.limits.travel_max_in = 0.75;  // a tenth of what the sensor shows
  EXPECT_EQ(warnings_of(rig), "");
  // All of the file in another unit.
  auto& options = std::get<hal::ComediOptions>(rig.backend);
  options.scale_in_per_V /= 25.4;
  options.offset_in /= 25.4;
  rig.limits.travel_min_in = 0.15 / 25.4;
  rig.limits.travel_max_in = 5.75 / 25.4;
  text = warnings_of(rig);
  EXPECT_NE(text.find("a travel of 5.6 mm"), std::string::npos) << text;
  EXPECT_NE(text.find("another unit"), std::string::npos) << text;
}

TEST(Arming, WarnsOfMeasuredNumbersThatWereChangedOnASimulatedRig) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  EXPECT_EQ(warnings_of(rig), "");
  ASSERT_TRUE(rig.limits.following);
  rig.limits.following->measured_check = config::measured_check_of(*rig.limits.following);
  EXPECT_EQ(warnings_of(rig), "");
  rig.limits.following->null_V += 0.1;
  const std::string text = warnings_of(rig);
  EXPECT_NE(text.find("following.measured_check does not fit"), std::string::npos) << text;
  EXPECT_NE(text.find("would not be armed"), std::string::npos) << text;
  EXPECT_TRUE(arming_findings(rig).refusals.empty());
}

TEST(Arming, SaysThatNoCommandReachesOneSideOfTheValve) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  rig.limits.following->null_V = -7.0;
  EXPECT_EQ(warnings_of(rig),
            "following.null_V = -7 V with dead_band_V = 0.2 V: of the commands -5..5 V none moves the rod towards "
            "smaller displacements; correct it, or the command limits\n");
  rig.limits.following->null_V = 4.85;
  EXPECT_NE(warnings_of(rig).find("towards greater displacements"), std::string::npos);
  rig.limits.following->null_V = 4.75;
  EXPECT_EQ(warnings_of(rig), "");
  rig = card();
  rig.limits.following->null_V = -7.0;
  const std::vector<std::string> refusals = arming_findings(rig).refusals;
  EXPECT_TRUE(std::any_of(refusals.begin(), refusals.end(), [](const std::string& refusal) {
    return refusal.find("none moves the rod") != std::string::npos;
  }));
}

TEST(Arming, WarnsOfWhatIsNotKnown) {
  config::RigConfig rig = card();
  rig.limits.following.reset();
  rig.limits.sensor->open_circuit_V.reset();
  EXPECT_EQ(arming_findings(rig).warnings.size(), 2U);
  EXPECT_TRUE(arming_findings(rig).refusals.empty());
  rig.limits.sensor.reset();
  EXPECT_EQ(arming_findings(rig).warnings.size(), 2U);
  EXPECT_NO_THROW(require_protecting_limits(rig)) << "a rig file that was armed before is armed still";
}

TEST(Arming, RefusesTicksForWhichThePulsesOfAnUnknownValveAreTooLong) {
  const auto unknown = [](double tick_s) {
    return refusal([&](auto& rig) {
      rig.limits.following.reset();
      rig.realtime.sample_period_s = tick_s;
    });
  };
  const std::string text = unknown(0.05);
  EXPECT_NE(text.find("realtime.sample_period_s = 0.05 s"), std::string::npos) << text;
  EXPECT_NE(text.find("set at most 0.02"), std::string::npos) << text;
  EXPECT_EQ(unknown(0.02), "");
}

TEST(Arming, WarnsOfAPriorityThatTheGuardCouldNotPreempt) {
  config::RigConfig rig = card();
  rig.realtime.priority = 90;
  EXPECT_TRUE(arming_findings(rig).warnings.empty());
  rig.realtime.priority = 91;
  ASSERT_EQ(arming_findings(rig).warnings.size(), 1U);
  EXPECT_NE(arming_findings(rig).warnings.front().find("realtime.priority = 91 is limited to 90"), std::string::npos);
}

TEST(Arming, AsksNothingOfARigThatMovesNoMachine) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  rig.limits.following.reset();
  rig.limits.velocity_limit_in_per_s = 1e9;
  const ArmingFindings findings = arming_findings(rig);
  EXPECT_TRUE(findings.refusals.empty() && findings.warnings.empty());
}

TEST(Arming, IsRefusedWhileTheEmergencyStopCircuitIsOpenOrTheRigCannotBeRead) {
  const config::RigConfig config = card();
  acquisition::FakeRig rig;
  EXPECT_NO_THROW(require_plausible_inputs(rig, config));
  hal::FaultRig open(rig, {{.kind = hal::FaultKind::emergency_stop}});
  EXPECT_EQ(judged(open, config), ExitCode::safety_trip);
  EXPECT_NO_THROW(require_plausible_inputs(open, config)) << "the circuit is closed again";
  hal::FaultRig unreadable(rig, {{.kind = hal::FaultKind::read_io_error}});
  EXPECT_THROW(require_plausible_inputs(unreadable, config), DeviceError);
}

TEST(Arming, IsRefusedWhileTheEnableContactIsClosed) {
  const config::RigConfig config = card();
  acquisition::FakeRig rig;
  rig.add_contact(0.1);
  EXPECT_NO_THROW(require_plausible_inputs(rig, config));
  hal::FaultRig welded(rig, {{.kind = hal::FaultKind::contact_closed}});
  EXPECT_EQ(judged(welded, config), ExitCode::safety_trip);
}

TEST(Arming, IsRefusedForASensorThatIsOffItsBandOrTooNoisy) {
  const config::RigConfig config = card();
  const hal::SimOptions plant;
  const auto sim = hal::open_rig(plant, 0.0);
  const auto with = [&](hal::InjectedFault fault) {
    fault.ticks = hal::InjectedFault::kAlways;
    return hal::FaultRig(
        *sim, {fault}, [](std::int64_t) {}, plant.conversion());
  };
  hal::FaultRig sound = with({.kind = hal::FaultKind::slow_read});
  EXPECT_NO_THROW(require_plausible_inputs(sound, config));
  hal::FaultRig at_rail = with({.kind = hal::FaultKind::open_sensor, .amount = 12.0});
  EXPECT_EQ(judged(at_rail, config), ExitCode::safety_trip);
  hal::FaultRig off_band = with({.kind = hal::FaultKind::open_sensor, .amount = 9.8});
  EXPECT_EQ(judged(off_band, config), ExitCode::safety_trip);
  hal::FaultRig noisy = with({.kind = hal::FaultKind::open_sensor, .amount = 5.0, .noise_LSB = 300.0});
  EXPECT_EQ(judged(noisy, config), ExitCode::safety_trip);
}

/// A placing compares means of what its checks' time holds: at 10 ms a tenth of the readings.
TEST(Arming, TakesLessNoiseOfASensorThatIsReadRarely) {
  config::RigConfig config = card();
  const hal::SimOptions plant;
  const auto sim = hal::open_rig(plant, 0.0);
  hal::FaultRig noisy(
      *sim,
      {{.kind = hal::FaultKind::open_sensor, .ticks = hal::InjectedFault::kAlways, .amount = 5.0, .noise_LSB = 60.0}},
      [](std::int64_t) {}, plant.conversion());
  for (const auto& [period_s, expected] : {std::pair(0.001, ExitCode::ok), std::pair(0.01, ExitCode::safety_trip),
                                           std::pair(0.05, ExitCode::safety_trip)}) {
    config.realtime.sample_period_s = period_s;
    EXPECT_EQ(judged(noisy, config), expected) << period_s;
  }
}

/// The first characterisation would follow such a sensor: 24 of 40 simulated rods met an end stop at 0.3 in/s.
TEST(Arming, IsRefusedForASensorThatDriftsWithTheHydraulicsOff) {
  config::RigConfig config = card();
  config.limits.following.reset();
  for (const double in_per_s : {0.04, -0.3}) {
    DriftingRig drifting(in_per_s);
    EXPECT_EQ(judged(drifting, config), ExitCode::safety_trip) << in_per_s;
  }
  DriftingRig leaking(0.005);
  EXPECT_EQ(judged(leaking, config), ExitCode::ok);
}

}  // namespace
}  // namespace eha
