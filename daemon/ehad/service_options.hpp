// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/acquisition/run.hpp"

namespace eha::service {

/// ehad's command line.
struct Options {
  std::string rig_file = "/etc/ehad/rig.toml";
  std::string config_file = "/etc/ehad/ehad.toml";
  std::filesystem::path state = "/var/lib/ehad";
  std::filesystem::path socket = "/run/ehad/ehad.sock";
  acquisition::NonRealtime non_realtime = acquisition::NonRealtime::refuse;
};

/// @param text  receives help or version for standard output, if that was requested; then nothing is returned
/// @throws UsageError
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv, std::string& text);

}  // namespace eha::service
