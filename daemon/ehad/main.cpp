// SPDX-License-Identifier: GPL-3.0-or-later
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <exception>
#include <iostream>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/os/standard_streams.hpp"
#include "daemon/ehad/left_card.hpp"
#include "daemon/ehad/log.hpp"
#include "daemon/ehad/own_folders.hpp"
#include "daemon/ehad/service.hpp"
#include "daemon/ehad/service_options.hpp"

namespace {

using eha::ExitCode;

ExitCode run_program(int argc, char** argv) {
  eha::service::set_up_log();
  try {
    std::string text;
    const std::optional<eha::service::Options> options = eha::service::parse_options(argc, argv, text);
    if (!options) {
      std::cout << text << std::flush;
      return std::cout ? ExitCode::ok : ExitCode::io;
    }
    eha::service::make_left_card_safe(options->socket);
    eha::service::prepare_folders(*options);
    eha::service::Service(*options).run();
    return ExitCode::ok;
  } catch (const eha::ConfigError& error) {
    for (const std::string& line : error.lines()) spdlog::error("{}", line);
    return error.exit_code();
  } catch (const eha::Error& error) {
    spdlog::error("{}", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    spdlog::critical("internal error: {}; this is a bug in ehad, please report it with the journal", error.what());
    return ExitCode::bug;
  }
}

}  // namespace

int main(int argc, char** argv) {
  eha::os::open_missing_streams();
  // Others may not change the service's files, whatever the umask of the shell that starts it is.
  constexpr mode_t kOthersWrite = 022;
  umask(umask(kOthersWrite) | kOthersWrite);
  // Writing to a closed pipe, or to a file at its size limit, must be an error of write(), not the end of the process.
  for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
  const int code = static_cast<int>(run_program(argc, argv));
  // The rig is safe and closed; a stopped reader of the log must not keep the process alive.
  if (!eha::service::flush_log(std::chrono::seconds(1))) _exit(code);
  return code;
}
