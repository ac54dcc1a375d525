// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/tick_record.hpp"

#include "core/enum_names.hpp"

namespace eha::acquisition {
namespace {

using hal::RigStatus;

constexpr EnumNames<State, 7> kStates{{{"faulted", State::faulted},
                                       {"idle", State::idle},
                                       {"armed", State::armed},
                                       {"ramp_in", State::ramp_in},
                                       {"running", State::running},
                                       {"ramp_out", State::ramp_out},
                                       {"safe_stop", State::safe_stop}}};
constexpr EnumNames<Fault, 31> kFaults{{{"none", Fault::none},
                                        {"emergency_stop", Fault::emergency_stop},
                                        {"travel_limit", Fault::travel_limit},
                                        {"velocity_limit", Fault::velocity_limit},
                                        {"feedback_rail", Fault::feedback_rail},
                                        {"frozen_sensor", Fault::frozen_sensor},
                                        {"feedback_not_finite", Fault::feedback_not_finite},
                                        {"command_not_finite", Fault::command_not_finite},
                                        {"repeated_timeouts", Fault::repeated_timeouts},
                                        {"call_overran", Fault::call_overran},
                                        {"read_failed", Fault::read_failed},
                                        {"command_failed", Fault::command_failed},
                                        {"device_removed", Fault::device_removed},
                                        {"consecutive_late", Fault::consecutive_late},
                                        {"total_late", Fault::total_late},
                                        {"second_stop", Fault::second_stop},
                                        {"safe_write_failed", Fault::safe_write_failed},
                                        {"not_following", Fault::not_following},
                                        {"unexplained_motion", Fault::unexplained_motion},
                                        {"feedback_band", Fault::feedback_band},
                                        {"loop_stalled", Fault::loop_stalled},
                                        {"enable_contact", Fault::enable_contact},
                                        {"no_motion", Fault::no_motion},
                                        {"not_in_place", Fault::not_in_place},
                                        {"loop_speed", Fault::loop_speed},
                                        {"wrong_speed", Fault::wrong_speed},
                                        {"following_error", Fault::following_error},
                                        {"oscillation", Fault::oscillation},
                                        {"suspended", Fault::suspended},
                                        {"sensor_slip", Fault::sensor_slip},
                                        {"wrong_place", Fault::wrong_place}}};
constexpr EnumNames<RigStatus, 7> kRigStatuses{{{"ok", RigStatus::ok},
                                                {"timed_out", RigStatus::timed_out},
                                                {"io_error", RigStatus::io_error},
                                                {"busy", RigStatus::busy},
                                                {"locked", RigStatus::locked},
                                                {"removed", RigStatus::removed},
                                                {"not_finite", RigStatus::not_finite}}};

}  // namespace

std::string_view to_text(State state) noexcept { return name_in(kStates, state); }
std::string_view to_text(Fault fault) noexcept { return name_in(kFaults, fault); }

std::optional<Fault> fault_named(std::string_view text) noexcept { return value_in(kFaults, text); }
std::string_view to_text(hal::RigStatus status) noexcept { return name_in(kRigStatuses, status); }

}  // namespace eha::acquisition
