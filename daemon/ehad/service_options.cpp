// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/service_options.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "core/error.hpp"
#include "hal/comedi/comedi_available.hpp"

namespace eha::service {
namespace {

constexpr const char* kFooter = R"(
Keeps the rig open, runs the experiments that eha submits, one at a time, and fits each completed run. The rig is faulted
at the start: nothing moves before `eha arm`.
SIGTERM and SIGINT ramp the command [V] to the rig's safe voltage and end the service; a second one makes the rig safe at
once. SIGHUP reads the configuration again, unless the rig is armed.

Exit codes: 0 stopped as asked, 1 a bug, 2 wrong usage, 69 no device or already running, 74 input/output error,
77 permission denied, 78 wrong configuration.

Examples:
  ehad --rig config/rigs/sim.toml --state /tmp/ehad --socket /tmp/ehad/ehad.sock
  systemctl start ehad

More in ehad(8) and ehad-protocol(7).)";

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, std::string& text) {
  Options options;
  bool allow_non_realtime = false;
  CLI::App app("ehad - owns the rig and runs experiments on it", "ehad");
  app.footer(kFooter);
  app.set_help_flag("-h,--help", "Print this help and leave");
  app.set_version_flag("--version", "", "Print the version and leave");
  app.add_option("--rig", options.rig_file, "Rig file (default /etc/ehad/rig.toml)")->type_name("FILE");
  app.add_option("--config", options.config_file,
                 "The service's own settings (default /etc/ehad/ehad.toml, which may be absent)")
      ->type_name("FILE");
  app.add_option("--state", options.state, "Folder of runs/ and queue/ (default /var/lib/ehad)")->type_name("DIR");
  app.add_option("--socket", options.socket, "Socket of the service (default /run/ehad/ehad.sock)")->type_name("PATH");
  app.add_flag("--allow-non-realtime", allow_non_realtime, "Run without real-time privileges; for test benches");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    text = app.help();
    return std::nullopt;
  } catch (const CLI::CallForVersion&) {
    text = std::string("ehad ") + EHA_VERSION +
           "\ncomedi backend: " + (hal::comedi_available ? "built in" : "left out") + "\n";
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UsageError(std::string(error.what()) + "; see `ehad --help`");
  }
  // Clients in other folders receive these paths.
  options.state = std::filesystem::absolute(options.state).lexically_normal();
  options.rig_file = std::filesystem::absolute(options.rig_file).lexically_normal().string();
  if (allow_non_realtime) options.non_realtime = acquisition::NonRealtime::allow;
  return options;
}

}  // namespace eha::service
