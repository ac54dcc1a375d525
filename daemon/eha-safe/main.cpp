// SPDX-License-Identifier: GPL-3.0-or-later
#include <signal.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"
#include "core/os/shared_memory.hpp"
#include "core/os/standard_streams.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "daemon/eha-safe/local_snapshots.hpp"
#include "daemon/eha-safe/save_rows.hpp"
#include "daemon/eha-safe/watch_parent.hpp"
#include "hal/backends/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace {

/// Longest wait for a dying process to release the card; each converter call may take the kernel's time-out of 1 s.
constexpr std::chrono::milliseconds kReleaseLimit{10'000};

/// Signals to the watched process or its whole group must not end the guard, nor must a journal at its size limit
/// (SIGXFSZ). A service manager's watchdog sends SIGABRT.
void ignore_group_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGABRT, SIGXFSZ}) signal(number, SIG_IGN);
}

/// Whether the service's snapshot is absent: then it drove no card, or the card has been made safe. The service writes
/// it before it drives a card; eha-safe removes it afterwards.
bool nothing_is_driven(const std::filesystem::path& snapshot) {
  std::error_code error;
  return std::filesystem::status(snapshot, error).type() == std::filesystem::file_type::not_found;
}

eha::hal::SafeAction load_action(const std::string& file) {
  return eha::hal::safe_action(eha::hal::read_safe_snapshot(file), file);
}

void tell_safe(const eha::hal::SafeAction& rig, const std::string& done) {
  std::cerr << "eha-safe: " << rig.device << ": " << done << "\n";
}

/// Prints the reason for which the guard acted; only afterwards, because a write to a stopped terminal may block.
/// @param has_driven  the loop has begun since the rig was opened
void tell_why(const eha::hal::SafeAction& rig, eha::WatchEnd end, bool has_driven) {
  if (end == eha::WatchEnd::death && !has_driven) {
    std::cerr << "eha-safe: the program that opened " << rig.device << " ended and had driven nothing\n";
    return;
  }
  const char* why = " ended without making it safe\n";
  if (end == eha::WatchEnd::stop) why = " was stopped and has been killed\n";
  if (end == eha::WatchEnd::stall) why = " stood still and has been killed\n";
  std::cerr << "eha-safe: the program that drove " << rig.device << why;
}

/// The shared memory of the driving program, and its owner.
class Page {
 public:
  /// @throws IoError, PermissionError  not a page, or one of another version of the program
  explicit Page(const std::string& file) : memory_(eha::os::SharedMemory::open(file, sizeof(eha::GuardPage))) {
    if (!get().is_of_this_version()) throw eha::IoError(file + ": not the memory of a program of this version");
    struct stat facts {};
    fstat(memory_.file().get(), &facts);
    owner_ = facts.st_uid;
  }
  [[nodiscard]] eha::GuardPage& get() { return *static_cast<eha::GuardPage*>(memory_.data()); }

  /// Saves the rows of a program that has died and prints the result; a failure prevents no other action.
  /// @param journal  as passed by the program; none: the one that the page names
  void save_rows(eha::os::FileDescriptor journal = {}) noexcept {
    try {
      if (!journal) journal = eha::open_journal(get(), owner_);
      if (!journal) {
        if (get().has_journal())
          std::cerr << "eha-safe: " << get().journal_path() << ": left to its writer, which lives\n";
        return;
      }
      const std::uint64_t rows = eha::save_rows(get(), journal);
      if (rows > 0) std::cerr << "eha-safe: " << get().journal_path() << ": the last " << rows << " rows are saved\n";
    } catch (const std::exception& error) {
      std::cerr << "eha-safe: error: the last rows of the run are lost: " << error.what() << "\n";
    }
  }

 private:
  eha::os::SharedMemory memory_;
  uid_t owner_ = 0;
};

/// Makes the rig of a dead program safe and saves its rows. The first try comes before anything else. Afterwards a
/// hanging disk does not delay the rig, and a card that does not answer does not delay the rows, unless no thread can
/// be started.
/// @returns the result
/// @throws as SafeAction::make_safe, after the rows
std::string act(const eha::hal::SafeAction& rig, std::optional<Page>& page, eha::os::FileDescriptor journal = {}) {
  std::optional<std::string> done;
  try {
    done = rig.make_safe(std::chrono::milliseconds(0));
  } catch (const eha::Error&) {
    // Tried again below.
  }
  if (!page) return done ? *done : rig.make_safe(kReleaseLimit);
  if (done) {
    page->save_rows(std::move(journal));
    return *done;
  }
  std::jthread saver;
  try {
    saver = std::jthread([&] { page->save_rows(std::move(journal)); });
  } catch (const std::system_error&) {
    page->save_rows(std::move(journal));
  }
  return rig.make_safe(kReleaseLimit);
}

/// @param file  empty: the program drives no machine, only its rows are saved
int guard(const std::string& file, std::optional<Page>& page) {
  std::optional<eha::hal::SafeAction> rig;
  if (!file.empty()) rig = load_action(file);
  ignore_group_signals();
  eha::Watched watched;
  watched.page = page ? &page->get() : nullptr;
  watched.drives_machine = rig.has_value();
  if (rig) {
    watched.switch_off = rig->switch_off;
    eha::become_guard();
    // If it does not open here, it is tried again when it is needed.
    rig->keep_open();
  }
  std::cout << "ready" << std::endl;
  const eha::WatchEnd end = eha::watch_parent(watched);
  if (end == eha::WatchEnd::done) return 0;
  if (!rig) {
    page->save_rows(std::move(watched.journal));
    return 0;
  }
  const bool has_driven = !page || page->get().drive() != 0;
  std::string done;
  try {
    done = act(*rig, page, std::move(watched.journal));
  } catch (const eha::Error&) {
    tell_why(*rig, end, has_driven);
    throw;
  }
  tell_why(*rig, end, has_driven);
  tell_safe(*rig, done);
  return 0;
}

/// Returns the page that the service left behind, if any.
std::optional<Page> page_beside(const std::filesystem::path& snapshot) {
  std::optional<Page> page;
  try {
    const std::filesystem::path file = snapshot.parent_path() / eha::kPageFile;
    if (std::filesystem::exists(file)) page.emplace(file);
  } catch (const std::exception& error) {
    std::cerr << "eha-safe: " << error.what() << "\n";
  }
  return page;
}

int make_safe(const std::string& file) {
  const eha::hal::SafeAction rig = load_action(file);
  tell_safe(rig, rig.make_safe(kReleaseLimit));
  return 0;
}

/// Whether a snapshot is one that a service writes beside its socket, in a folder that is there: that it is missing
/// then says that nothing is driven. Any other name may be mistyped.
bool is_of_service(const std::filesystem::path& snapshot) {
  std::error_code unknown;
  return snapshot.filename() == std::filesystem::path(eha::hal::kServiceSnapshot).filename() &&
         (snapshot == eha::hal::kServiceSnapshot || std::filesystem::is_directory(snapshot.parent_path(), unknown));
}

/// Run by systemd after the service: makes its card safe, if it had one, and saves the rows that its guard has not
/// saved.
int follow_service(const std::filesystem::path& snapshot) {
  std::optional<Page> page = page_beside(snapshot);
  if (nothing_is_driven(snapshot)) {
    std::cerr << "eha-safe: " << snapshot.string()
              << " is not there: the service drives no card, or it has been made safe\n";
    if (page) page->save_rows();
    for (const std::filesystem::path& other : eha::find_local_snapshots()) {
      std::cerr << "eha-safe: a run by `eha run --local` is in progress, or left " << other.string()
                << " when it was killed together with its guard; if it was killed, run eha-safe " << other.string()
                << "\n";
    }
    return 0;
  }
  const eha::hal::SafeAction rig = load_action(snapshot.string());
  tell_safe(rig, act(rig, page));
  // Removed only here, not by a guard: after the service's guard ExecStopPost=eha-safe still needs the file.
  std::error_code ignored;  // making a safe rig safe again does no harm
  std::filesystem::remove(snapshot, ignored);
  return 0;
}

}  // namespace

#ifdef __SANITIZE_ADDRESS__
/// No leak check at the end of this program: it stops the process by SIGSTOP and waits for that, but the driver sends
/// SIGCONT to an ending guard (GuardProcess::finish), which cancels a pending SIGSTOP. Both would wait for ever.
extern "C" int __lsan_is_turned_off() { return 1; }  // NOLINT(bugprone-reserved-identifier): the sanitizer's name
#endif

int main(int argc, char** argv) {
  eha::os::open_missing_streams();
  CLI::App app("Makes a rig safe without its rig file: writes the safe voltage and switches the hydraulics off.",
               "eha-safe");
  std::string file = eha::hal::kServiceSnapshot;
  std::string page_file;
  bool is_guard = false;
  const CLI::Option* named =
      app.add_option("SNAPSHOT", file, "file that the program that opened the rig wrote")->capture_default_str();
  CLI::Option* const guards = app.add_flag(
      "--guard", is_guard, "print `ready`, then act at the end of standard input unless the line `done` came first");
  app.add_option("--page", page_file,
                 "memory that the watched program shares: switch off when its loop stands still, save its last rows "
                 "when it dies; without SNAPSHOT only the rows")
      ->needs(guards);
  app.set_version_flag("--version", EHA_VERSION);
  app.footer(
      "Exit status: 0 safe, or nothing to do; 2 usage; 69 NOT safe; 74, 78 the snapshot cannot be read; "
      "77 no right to open the card.");
  try {
    app.parse(argc, argv);
    if (is_guard) {
      std::optional<Page> page;
      if (!page_file.empty()) page.emplace(page_file);
      if (named->empty() && !page) throw CLI::RequiredError("SNAPSHOT or --page");
      return guard(named->empty() ? "" : file, page);
    }
    return is_of_service(file) ? follow_service(file) : make_safe(file);
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
