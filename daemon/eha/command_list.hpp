// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace CLI {
class App;
}

namespace eha::cli {

struct ParsedLine;

// Each function adds a command to the program, with its options, help and execution. NAME_command.cpp defines it.
void add_run(CLI::App& app, ParsedLine& line);
void add_fit(CLI::App& app, ParsedLine& line);
void add_import(CLI::App& app, ParsedLine& line);
void add_simulate(CLI::App& app, ParsedLine& line);
void add_validate(CLI::App& app, ParsedLine& line);
void add_export(CLI::App& app, ParsedLine& line);
void add_compare(CLI::App& app, ParsedLine& line);
void add_replay(CLI::App& app, ParsedLine& line);
void add_report(CLI::App& app, ParsedLine& line);
void add_plot(CLI::App& app, ParsedLine& line);
void add_batch(CLI::App& app, ParsedLine& line);
void add_check(CLI::App& app, ParsedLine& line);
void add_design(CLI::App& app, ParsedLine& line);
void add_runs(CLI::App& app, ParsedLine& line);
void add_doctor(CLI::App& app, ParsedLine& line);
void add_latency(CLI::App& app, ParsedLine& line);
void add_tune(CLI::App& app, ParsedLine& line);
void add_track(CLI::App& app, ParsedLine& line);
void add_commission(CLI::App& app, ParsedLine& line);
void add_study(CLI::App& app, ParsedLine& line);
void add_completion(CLI::App& app, ParsedLine& line);
void add_read(CLI::App& app, ParsedLine& line);
void add_place_commands(CLI::App& app, ParsedLine& line);  ///< goto, jog
void add_characterise(CLI::App& app, ParsedLine& line);
void add_calibrate(CLI::App& app, ParsedLine& line);
void add_service_commands(CLI::App& app, ParsedLine& line);  ///< status, arm, disarm, stop, metrics, reload, queue
void add_web(CLI::App& app, ParsedLine& line);

/// All of them, in the order of the help.
inline constexpr std::array kCommands{add_run,
                                      add_fit,
                                      add_import,
                                      add_simulate,
                                      add_validate,
                                      add_export,
                                      add_compare,
                                      add_replay,
                                      add_report,
                                      add_plot,
                                      add_batch,
                                      add_check,
                                      add_design,
                                      add_runs,
                                      add_doctor,
                                      add_latency,
                                      add_tune,
                                      add_track,
                                      add_commission,
                                      add_study,
                                      add_completion,
                                      add_read,
                                      add_place_commands,
                                      add_characterise,
                                      add_calibrate,
                                      add_service_commands,
                                      add_web};

}  // namespace eha::cli
