// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/program_path.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"

namespace eha::cli {
namespace {

constexpr const char* kWebCommandFooter = R"(
Runs eha-web: a page in a browser on this machine with the rod, the run and its frequency response as it is measured, the
queue, the runs with their reports and files, and Stop. Prints its address, and the token that Stop asks for. Ctrl-C ends
it. It reads ehad's socket and the run folders. To run it permanently: systemctl enable --now eha-web.
From another machine: ssh -L 8420:127.0.0.1:8420 BENCH, then http://127.0.0.1:8420 there.

Examples:
  eha web
  eha web --port 9000 --socket /tmp/ehad/ehad.sock

More in eha-web(8).)";

/// Replaces this process by eha-web.
struct WebCommand {
  std::uint16_t port = 8420;  ///< on 127.0.0.1; 0: any free one
  std::filesystem::path socket = control::default_socket();
  std::optional<std::string> runs = {};        ///< folder; none: the one that ehad names
  std::optional<std::string> token_file = {};  ///< none: a token for the process is made and printed
  std::vector<std::string> allowed_hosts = {};
};

ExitCode execute(const WebCommand& command, Console& console) {
  const std::filesystem::path program = find_program("eha-web");
  if (program.empty()) throw ConfigError("eha-web: not found beside eha; install the whole package");
  std::vector<std::string> words{program.string(), "--port", std::to_string(command.port), "--socket",
                                 command.socket.string()};
  const auto add = [&](const char* option, const std::optional<std::string>& value) {
    if (value) words.insert(words.end(), {option, *value});
  };
  add("--runs", command.runs);
  add("--token-file", command.token_file);
  for (const std::string& host : command.allowed_hosts) add("--allow-host", host);
  console.flush();
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw IoError(fmt::format("{}: cannot be started: {}", program.string(), error_text(errno)));
}

}  // namespace

void add_web(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("web", "Show the rig and its runs on a page in a browser");
  sub->footer(kWebCommandFooter);
  auto& command = options_of<WebCommand>(*sub, line);
  sub->add_option("--port", command.port, "Port on 127.0.0.1 and [::1] (default 8420; 0: any free one)")
      ->type_name("N");
  sub->add_option("--socket", command.socket, "Socket of ehad (default $EHA_SOCKET or /run/ehad/ehad.sock)")
      ->type_name("PATH");
  sub->add_option("--runs", command.runs, "Folder of the runs (default: the one that ehad names)")->type_name("DIR");
  sub->add_option("--token-file", command.token_file,
                  "File with the token for Stop, mode 0640 or less (default: a token for this process is printed)")
      ->type_name("FILE");
  sub->add_option("--allow-host", command.allowed_hosts,
                  "Further NAME or NAME:PORT in the browser's address, such as that of an ssh tunnel")
      ->type_name("NAME");
}

}  // namespace eha::cli
