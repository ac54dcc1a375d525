// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <csignal>
#include <exception>
#include <future>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/os/standard_streams.hpp"
#include "daemon/web/access.hpp"
#include "daemon/web/daemon_feed.hpp"
#include "daemon/web/listeners.hpp"
#include "daemon/web/response_meter.hpp"
#include "daemon/web/run_store.hpp"
#include "daemon/web/site.hpp"
#include "daemon/web/stop_token.hpp"
#include "daemon/web/web_options.hpp"
#include "daemon/web/web_server.hpp"

namespace {

using namespace std::chrono_literals;
using eha::ExitCode;

/// Blocks SIGTERM and SIGINT in this thread and in those it starts.
sigset_t block_ends() {
  sigset_t ends;
  sigemptyset(&ends);
  for (const int number : {SIGTERM, SIGINT}) sigaddset(&ends, number);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  return ends;
}

void serve(const eha::web::Options& options) {
  namespace web = eha::web;
  // Otherwise each of many threads would get its own heap.
  mallopt(M_ARENA_MAX, 2);
  const sigset_t ends = block_ends();
  web::StopToken token(options.token_file ? web::StopToken::read(*options.token_file) : web::StopToken::random());
  web::RunStore store;
  if (options.runs) store.set_folder(*options.runs);
  web::DaemonFeed::OnRuns on_runs;
  if (!options.runs) on_runs = [&store](const std::filesystem::path& folder) { store.set_folder(folder); };
  std::optional<web::Site> site;
  web::Listeners listeners = web::Listeners::inherited();
  if (listeners.empty()) listeners = web::Listeners::on_port(options.port);
  web::WebServer server(std::move(listeners), {},
                        [&site](const httplib::Request& request, httplib::Response& response, uid_t user) {
                          site->answer(request, response, user);
                        });
  const web::DaemonFeed feed(options.socket, on_runs);
  web::ResponseMeter meter(store, feed);
  site.emplace(store, feed, meter, token, options.socket);
  std::cout << fmt::format("http://127.0.0.1:{}\n", server.port());
  if (!options.token_file) std::cout << fmt::format("token for Stop, until this ends: {}\n", token.text());
  std::cout << std::flush;
  auto served = std::async(std::launch::async, [&] {
    // Ends the program if serve() fails.
    try {
      server.serve(web::AccessRules(server.port(), options.allowed_hosts));
    } catch (...) {
      kill(getpid(), SIGTERM);
      throw;
    }
  });
  int number = 0;
  sigwait(&ends, &number);
  server.end();
  served.get();
}

ExitCode run_program(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("eha-web"));
  spdlog::set_pattern("eha-web: %l: %v");
  try {
    std::string text;
    const std::optional<eha::web::Options> options = eha::web::parse_options(argc, argv, text);
    if (!options) {
      std::cout << text << std::flush;
      return std::cout ? ExitCode::ok : ExitCode::io;
    }
    serve(*options);
    return ExitCode::ok;
  } catch (const eha::Error& error) {
    spdlog::error("{}", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    spdlog::critical("internal error: {}; this is a bug in eha-web, please report it", error.what());
    return ExitCode::bug;
  }
}

}  // namespace

int main(int argc, char** argv) {
  eha::os::open_missing_streams();
  std::signal(SIGPIPE, SIG_IGN);
  return static_cast<int>(run_program(argc, argv));
}
