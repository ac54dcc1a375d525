// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/commission_session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <csignal>
#include <exception>

#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"

namespace eha::cli {
namespace {

/// Global, because a signal handler has no other access to it.
std::string farewell;

/// For times without motion; a motion has its own handler.
void say_farewell(int number) {
  [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, farewell.data(), farewell.size());
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

std::string again(const CommissionOptions& command) {
  const CommissionOptions otherwise;
  std::string line = "eha commission " + shell_word(command.rig_file);
  if (command.folder != otherwise.folder) line += " -o " + shell_word(command.folder.string());
  if (command.precision_percent != otherwise.precision_percent) {
    line += fmt::format(" --precision {:g}", command.precision_percent);
  }
  if (command.ruler) line += " --ruler " + shell_quoted(*command.ruler);
  if (command.local) {
    line += " --local";
  } else {
    line = through(command.socket, line);
  }
  if (command.fast) line += " --fast";
  if (command.yes) line += " --yes";
  if (command.allow_non_realtime) line += " --allow-non-realtime";
  return line;
}

CommissionSession::CommissionSession(const CommissionOptions& command, bool moves_machine, Console& console)
    : command_(command),
      console_(console),
      moves_machine_(moves_machine),
      // This process drives a simulated rig unless a service is named.
      is_local_(command.local || (!moves_machine && command.socket == control::default_socket())) {
  farewell = fmt::format("\neha: info: stopped; to go on with this step: {}\n", again(command));
  for (const int number : {SIGINT, SIGTERM}) {
    // A signal that nohup or a background shell ignores stays ignored.
    if (std::signal(number, say_farewell) == SIG_IGN) std::signal(number, SIG_IGN);
  }
}

CommissionSession::~CommissionSession() {
  for (const int number : {SIGINT, SIGTERM}) {
    if (std::signal(number, SIG_DFL) == SIG_IGN) std::signal(number, SIG_IGN);
  }
}

void CommissionSession::announce(const std::string& step, const std::string& does) const {
  console_.print(fmt::format("\n== {}: {}", step, does));
  console_.flush();
}

void CommissionSession::ask() const {
  if (!command_.yes && !console_.confirm("This step?")) throw Stopped{ExitCode::interrupted, "not \"yes\": stopped"};
}

void CommissionSession::ask_before_motion() const {
  if (!moves_machine_) ask();
}

Played CommissionSession::play(std::vector<std::string> words, Results results) {
  std::vector<std::string> quoted;
  for (const std::string& word : words) quoted.push_back(shell_quoted(word));
  console_.print(fmt::format("$ eha {}", fmt::join(quoted, " ")));
  console_.flush();
  words.insert(words.begin(), "eha");
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const ParsedLine line = parse_command_line(static_cast<int>(arguments.size()), arguments.data());
  console_.keep_documents();
  console_.hide_results(results == Results::hide && !console_.verbose());
  ExitCode code = ExitCode::bug;
  std::optional<Stopped> stopped;
  try {
    code = line.command(console_);
  } catch (const Error& error) {
    console_.end_progress();
    console_.error(error.what());
    stopped = Stopped{error.exit_code(), ""};
  }
  console_.hide_results(false);
  const nlohmann::ordered_json documents = console_.taken_documents();
  if (stopped) throw Stopped(*stopped);
  return {documents.empty() ? nlohmann::ordered_json::object() : documents.back(), code};
}

Played CommissionSession::drive(std::vector<std::string> words, Results results) {
  if (is_local_) {
    words.insert(words.end(), {"--local", "--rig", command_.rig_file});
    if (command_.allow_non_realtime) words.emplace_back("--allow-non-realtime");
  } else {
    words.insert(words.end(), {"--socket", command_.socket.string()});
    if (moves_machine_ && !is_armed_ &&
        !console_.confirm("Arm the rig? A fault that it repeats is acknowledged by that.")) {
      throw Stopped{ExitCode::interrupted, "not \"yes\": stopped"};
    }
    static_cast<void>(play({"arm", "--socket", command_.socket.string()}));
    is_armed_ = true;
    farewell = fmt::format("\neha: info: stopped; the rig may be armed: {}; to go on with this step: {}\n",
                           through(command_.socket, "eha disarm"), again(command_));
  }
  if (command_.fast) words.emplace_back("--fast");
  if (!moves_machine_) words.emplace_back("--yes");
  return play(std::move(words), results);
}

void CommissionSession::disarm() noexcept {
  if (!is_armed_ || !moves_machine_) return;
  is_armed_ = false;
  try {
    static_cast<void>(play({"disarm", "--socket", command_.socket.string()}, Results::hide));
  } catch (...) {  // a fault has disarmed it, or the service has ended: already reported
  }
}

}  // namespace eha::cli
