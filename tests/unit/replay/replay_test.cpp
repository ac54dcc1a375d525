// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/replay.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "daemon/replay/twin_calibration.hpp"
#include "daemon/replay/twin_file.hpp"
#include "daemon/replay/twin_parameter.hpp"
#include "tests/unit/replay/twin_record.hpp"

namespace eha::replay {
namespace {

using test::record_of;
using test::TwinRecord;

std::string fault_of(const TwinRecord& record, const std::vector<CalibrationRequest>& requests) {
  try {
    static_cast<void>(calibrate({}, requests, record.volts, record.displacement_in, record.step_s));
  } catch (const Error& error) {
    return error.what();
  }
  return "no fault";
}

TEST(Replay, OfARecordOfTheSameRigDiffersByTheSensorsNoise) {
  const hal::SimOptions rig;
  const TwinRecord record = record_of(rig, 10.0);
  const Eigen::VectorXd replayed =
      displacement_in(starting_at(rig, record.displacement_in[0]), record.volts, record.step_s);
  const double rms = std::sqrt((replayed - record.displacement_in).squaredNorm() / 10000.0);
  EXPECT_LT(rms, 3.0 * rig.sensor_noise_V * rig.scale_in_per_V);
  EXPECT_GT(rms, 0.5 * rig.sensor_noise_V * rig.scale_in_per_V);
}

TEST(Replay, RefusesUnitsThatTheRigHasNot) {
  ident::Record record;
  record.input = record.output = Eigen::VectorXd::Ones(3);
  record.output_channel.unit = "mm";
  EXPECT_NEAR(measured_in(record)[0], 1.0 / 25.4, 1e-12);
  record.output_channel.unit = "bar";
  EXPECT_THROW(static_cast<void>(measured_in(record)), DataError);
}

TEST(Calibration, FindsNullAndDeadBandThatDiffer) {
  hal::SimOptions truth;
  truth.valve_null_offset_V = 0.26;
  truth.valve_dead_band_V = 0.11;
  const TwinRecord record = record_of(truth, 12.0);
  const Calibration found = calibrate({}, {{"valve_null_offset_V"}, {"valve_dead_band_V"}}, record.volts,
                                      record.displacement_in, record.step_s);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.parameters[0].value, 0.26, std::max(0.002, 1.5 * found.parameters[0].half_width));
  EXPECT_NEAR(found.parameters[1].value, 0.11, std::max(0.002, 1.5 * found.parameters[1].half_width));
  EXPECT_LT(found.parameters[0].half_width, 0.05 * 0.26);
  EXPECT_LT(found.rms_error_in, 0.0005);
  EXPECT_LT(found.rms_error_in, kMoreThanNoise * found.noise_in);
}

TEST(Calibration, LeavesMoreThanNoiseWhereSomethingElseDiffers) {
  hal::SimOptions truth;
  truth.valve_dead_band_V = 0.19;
  truth.supply_pressure_bar = 64.0;
  const TwinRecord record = record_of(truth, 12.0);
  const Calibration found = calibrate({}, {{"valve_dead_band_V"}}, record.volts, record.displacement_in, record.step_s);
  EXPECT_GT(found.rms_error_in, 2.0 * kMoreThanNoise * found.noise_in);
}

TEST(Calibration, RefusesByNameWhatTheRecordDoesNotTell) {
  const TwinRecord record = record_of({}, 12.0);
  const std::string stop = fault_of(record, {{"valve_dead_band_V"}, {"end_stop_stiffness_N_per_mm"}});
  EXPECT_NE(stop.find("end_stop_stiffness_N_per_mm: the record does not determine it"), std::string::npos) << stop;
  EXPECT_EQ(stop.find("valve_dead_band_V"), std::string::npos) << stop;
  const std::string weight = fault_of(
      record, {{"moving_mass_kg"}, {"tank_pressure_bar"}, {"supply_pressure_bar"}, {"valve_rated_flow_L_per_min"}});
  EXPECT_NE(weight.find("moving_mass_kg and tank_pressure_bar cannot be told apart"), std::string::npos) << weight;
  const std::string flow = fault_of(record, {{"valve_rated_flow_L_per_min"}, {"valve_rated_drop_bar"}});
  EXPECT_NE(flow.find("valve_rated_flow_L_per_min and valve_rated_drop_bar cannot be told apart"), std::string::npos)
      << flow;
}

TEST(Calibration, RefusesTwoVolumesThatTheSensorsNoiseHides) {
  hal::SimOptions noisy;
  noisy.sensor_noise_V = 0.01;  // ten times the shipped rig's
  const std::vector<CalibrationRequest> volumes{
      {"bulk_modulus_bar", {}}, {"cap_dead_volume_cm3", {}}, {"rod_dead_volume_cm3", {}}};
  const std::string hidden = fault_of(record_of(noisy, 6.0), volumes);
  EXPECT_NE(hidden.find("cap_dead_volume_cm3"), std::string::npos) << hidden;
  EXPECT_NE(hidden.find("rod_dead_volume_cm3"), std::string::npos) << hidden;
}

TEST(Calibration, RefusesWrongRequests) {
  const TwinRecord record = record_of({}, 3.0);
  EXPECT_NE(fault_of(record, {{"moving_mass"}}).find("moving_mass_kg"), std::string::npos);
  EXPECT_NE(fault_of(record, {{"seed"}}).find("simulated plant"), std::string::npos);
  EXPECT_NE(fault_of(record, {{"bore_mm"}, {"bore_mm"}}).find("twice"), std::string::npos);
  EXPECT_NE(fault_of(record, {{"bore_mm", {{50.0, 60.0}}}}).find("50:60"), std::string::npos);
  TwinRecord brief = record_of({}, 1.0);
  EXPECT_NE(fault_of(brief, {{"bore_mm"}}).find("2 s"), std::string::npos);
}

TEST(TwinParameter, IsReadAndWrittenByItsKey) {
  const hal::SimOptions options;
  for (const std::string& key : twin_parameters()) {
    EXPECT_NEAR(value_of(with_value(options, key, value_of(options, key) + 1.0), key), value_of(options, key) + 1.0,
                1e-9)
        << key;
  }
}

TEST(TwinFile, ChangesTheCalibratedValuesAlone) {
  Calibration calibration;
  calibration.parameters = {{"moving_mass_kg", 20.0, 26.5, 0.1, 0.2}, {"bore_mm", 40.0, 41.0, 0.1, 0.2}};
  calibration.options.sub_step_us = 25.0;
  const std::string text = twin_text(
      "schema = 1\n[limits]\nbore_mm = 7\n[sim]\nmoving_mass_kg = 20.0   # rod\nsub_step_us = 50\n[realtime]\n",
      calibration, "r.csv");
  EXPECT_NE(text.find("moving_mass_kg = 26.5  # calibrated: +- 0.2 (95 %), was 20\n"), std::string::npos) << text;
  EXPECT_NE(text.find("[sim]\nbore_mm = 41"), std::string::npos) << text;
  EXPECT_NE(text.find("[limits]\nbore_mm = 7\n"), std::string::npos) << text;
  EXPECT_NE(text.find("sub_step_us = 25"), std::string::npos) << text;
  EXPECT_EQ(text.find("sub_step_us = 50"), std::string::npos) << text;
}

}  // namespace
}  // namespace eha::replay
