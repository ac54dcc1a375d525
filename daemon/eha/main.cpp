// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/os/memory.hpp"
#include "core/os/standard_streams.hpp"
#include "daemon/eha/closed_pipe.hpp"
#include "daemon/eha/command_line.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/run_command.hpp"

namespace {

using eha::ExitCode;
using eha::cli::Console;

pid_t own_pid = 0;  ///< not that of a process that was forked: on a terminal Ctrl-C is theirs as well

/// Ends a command that has no end of its own for Ctrl-C, not without a word.
void end_interrupted(int number) {
  constexpr std::string_view kSaid = "\neha: interrupted; what was not finished is not written\n";
  if (getpid() == own_pid && write(STDERR_FILENO, kSaid.data(), kSaid.size()) < 0) _exit(128 + number);
  std::signal(number, SIG_DFL);
  raise(number);
}

ExitCode run_program(int argc, char** argv) {
  own_pid = getpid();
  // A signal that nohup or a background shell ignores stays ignored.
  if (std::signal(SIGINT, end_interrupted) == SIG_IGN) std::signal(SIGINT, SIG_IGN);
  // A closed pipe, or a file at its size limit, must be an error here and not end the process in the middle.
  for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
  Console console({});
  eha::cli::ParsedLine line;
  ExitCode code = ExitCode::ok;
  try {
    line = eha::cli::parse_command_line(argc, argv);
    console = Console(line.console);
    for (const std::string& note : line.notes) console.info(note);
    if (line.command) {
      code = line.command(console);
    } else {
      console.print_content(line.text);
    }
    console.flush();
    return code;
  } catch (const eha::cli::ClosedPipe& error) {
    console.end_progress();
    return code == ExitCode::ok ? error.exit_code() : code;
  } catch (const eha::Error& error) {
    console.end_progress();
    const bool is_of_input = error.exit_code() != ExitCode::safety_trip && error.exit_code() != ExitCode::bug;
    std::string wrong = is_of_input ? eha::cli::wrong_file(line.named_files) : "";
    const auto* of_list = dynamic_cast<const eha::cli::ListError*>(&error);
    if (!wrong.empty() && of_list != nullptr) wrong += "\n" + of_list->outcome();
    console.error(wrong.empty() ? error.what() : wrong);
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    console.end_progress();
    console.error("out of memory; decimate or shorten the record");
    return ExitCode::io;
  } catch (const std::exception& error) {
    console.end_progress();
    console.error(std::string("internal error: ") + error.what() +
                  "; this is a bug in eha, please report it with the command and its input");
    return ExitCode::bug;
  }
}

}  // namespace

int main(int argc, char** argv) {
  eha::os::open_missing_streams();
  // A fit of 10^7 rows allocates 80 MB hundreds of times; clearing the pages anew took a sixth of its time.
  eha::os::keep_freed_memory();
  // Others may not change the files of this program, whatever the shell's umask is.
  constexpr mode_t kOthersWrite = 022;
  umask(umask(kOthersWrite) | kOthersWrite);
  return static_cast<int>(run_program(argc, argv));
}
