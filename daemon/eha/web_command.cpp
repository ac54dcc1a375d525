// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/program_path.hpp"
#include "daemon/eha/commands.hpp"

namespace eha::cli {

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

}  // namespace eha::cli
