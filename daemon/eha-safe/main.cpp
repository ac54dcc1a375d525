// SPDX-License-Identifier: GPL-3.0-or-later
#include <signal.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>

#include "core/error.hpp"
#include "daemon/eha-safe/local_snapshots.hpp"
#include "daemon/eha-safe/watch_parent.hpp"
#include "hal/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace {

/// Longest wait for a dying process to release the card; each converter call may take the kernel's time-out of 1 s.
constexpr std::chrono::milliseconds kReleaseLimit{10'000};

/// Signals that are sent to the watched process or its whole group must not end the guard. SIGABRT is what a service
/// manager's watchdog sends.
void ignore_group_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGABRT}) signal(number, SIG_IGN);
}

/// Whether the service's snapshot is absent: then it drove no card, or the card has been made safe. The service writes
/// it before it drives a card; eha-safe removes it afterwards.
bool nothing_is_driven() {
  std::error_code error;
  return std::filesystem::status(eha::hal::kServiceSnapshot, error).type() == std::filesystem::file_type::not_found;
}

eha::hal::SafeAction load_action(const std::string& file) {
  return eha::hal::safe_action(eha::hal::read_safe_snapshot(file), file);
}

void tell_safe(const eha::hal::SafeAction& rig, const std::string& done) {
  std::cerr << "eha-safe: " << rig.device << ": " << done << "\n";
}

/// Says why the guard acted; only afterwards, because a write to a stopped terminal may block.
void tell_why(const eha::hal::SafeAction& rig, eha::WatchEnd end) {
  std::cerr << "eha-safe: the program that drove " << rig.device
            << (end == eha::WatchEnd::kill ? " was stopped and has been killed\n" : " ended without making it safe\n");
}

int guard(const std::string& file) {
  const eha::hal::SafeAction rig = load_action(file);
  ignore_group_signals();
  std::cout << "ready" << std::endl;
  const eha::WatchEnd end = eha::watch_parent();
  if (end == eha::WatchEnd::done) return 0;
  std::string done;
  try {
    done = rig.make_safe(kReleaseLimit);
  } catch (const eha::Error&) {
    tell_why(rig, end);
    throw;
  }
  tell_why(rig, end);
  tell_safe(rig, done);
  return 0;
}

int make_safe(const std::string& file) {
  const eha::hal::SafeAction rig = load_action(file);
  tell_safe(rig, rig.make_safe(kReleaseLimit));
  // Only here, not in a guard: after the service's guard ExecStopPost=eha-safe still needs the file.
  if (file == eha::hal::kServiceSnapshot) {
    std::error_code ignored;  // making a safe rig safe again does no harm
    std::filesystem::remove(file, ignored);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes a rig safe without its rig file: writes the safe voltage and switches the hydraulics off.",
               "eha-safe");
  std::string file = eha::hal::kServiceSnapshot;
  bool is_guard = false;
  const CLI::Option* named =
      app.add_option("SNAPSHOT", file, "file that the program that opened the rig wrote")->capture_default_str();
  app.add_flag("--guard", is_guard,
               "print `ready`, then act at the end of standard input unless the line `done` came first");
  app.set_version_flag("--version", EHA_VERSION);
  app.footer(
      "Exit status: 0 safe, or nothing to do; 2 usage; 69 NOT safe; 74, 78 the snapshot cannot be read; "
      "77 no right to open the card.");
  try {
    app.parse(argc, argv);
    if (named->empty() && nothing_is_driven()) {
      std::cerr << "eha-safe: " << file << " is not there: the service drives no card, or it has been made safe\n";
      for (const std::filesystem::path& other : eha::find_local_snapshots()) {
        std::cerr << "eha-safe: a run by `eha run --local` is on, or left " << other.string()
                  << " when it was killed with its guard: in the second case run eha-safe " << other.string() << "\n";
      }
      return 0;
    }
    return is_guard ? guard(file) : make_safe(file);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(eha::ExitCode::usage);
  } catch (const eha::Error& error) {
    std::cerr << "eha-safe: error: " << error.what() << "\n";
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    std::cerr << "eha-safe: error: " << error.what() << "\n";
    return static_cast<int>(eha::ExitCode::bug);
  }
}
