// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/web_options.hpp"

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

}  // namespace

void add_web(CLI::App& app, WebCommand& command) {
  CLI::App* sub = app.add_subcommand("web", "Show the rig and its runs on a page in a browser");
  sub->footer(kWebCommandFooter);
  sub->add_option("--port", command.port, "Port on 127.0.0.1 (default 8420; 0: any free one)")->type_name("N");
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
