// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/web_options.hpp"

#include <CLI/CLI.hpp>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/web/access.hpp"

namespace eha::web {
namespace {

constexpr const char* kWebFooter = R"(
Shows the rig, the run and its results on a page in a browser on this machine. It listens on 127.0.0.1 and [::1] only, reads the
socket of ehad and the run folders, and never touches the rig. The page can stop the rig and nothing else. Stop needs a
token: from the token file, or without one a random token for this process, which is printed.
From another machine: ssh -L 8420:127.0.0.1:8420 BENCH, then http://127.0.0.1:8420 there.

Exit codes: 0 stopped as asked, 1 a bug, 2 wrong usage, 69 the port is taken, 74 input/output error, 77 permission denied,
78 wrong token file.

Examples:
  eha web
  eha web --port 9000 --socket /tmp/ehad/ehad.sock
  systemctl enable --now eha-web

More in eha-web(8).)";

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, std::string& text) {
  Options options;
  options.socket = control::default_socket();
  CLI::App app("eha-web - shows the rig and its runs on a page in a browser", "eha-web");
  app.footer(kWebFooter);
  app.set_help_flag("-h,--help", "Print this help and leave");
  app.set_version_flag("--version", "", "Print the version and leave");
  app.add_option("--port", options.port, "Port on 127.0.0.1 and [::1] (default 8420; 0: any free one)")->type_name("N");
  app.add_option("--socket", options.socket, "Socket of ehad (default $EHA_SOCKET or /run/ehad/ehad.sock)")
      ->type_name("PATH");
  app.add_option("--runs", options.runs, "Folder of the runs (default: the one that ehad names)")->type_name("DIR");
  app.add_option("--token-file", options.token_file,
                 "File with the token for Stop, mode 0640 or less (default: a token for this process is printed)")
      ->type_name("FILE");
  app.add_option("--allow-host", options.allowed_hosts,
                 "Further NAME or NAME:PORT in the browser's address, such as that of an ssh tunnel")
      ->type_name("NAME");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    text = app.help();
    return std::nullopt;
  } catch (const CLI::CallForVersion&) {
    text = std::string("eha-web ") + EHA_VERSION + "\n";
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UsageError(std::string(error.what()) + "; see `eha-web --help`");
  }
  for (const std::string& host : options.allowed_hosts) {
    if (!is_host(host)) throw UsageError("--allow-host " + host + ": expected NAME or NAME:PORT; see `eha-web --help`");
  }
  return options;
}

}  // namespace eha::web
