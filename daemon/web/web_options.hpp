// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace eha::web {

inline constexpr std::uint16_t kDefaultPort = 8420;

/// eha-web's command line.
struct Options {
  std::uint16_t port = kDefaultPort;                     ///< 0: any free one
  std::filesystem::path socket;                          ///< of ehad
  std::optional<std::filesystem::path> runs = {};        ///< none: the folder that ehad names
  std::optional<std::filesystem::path> token_file = {};  ///< none: a token for this process is made and printed
  std::vector<std::string> allowed_hosts = {};           ///< NAME or NAME:PORT, beside the loopback names
};

/// @param text  receives help or version for standard output, if that was requested; then nothing is returned
/// @throws UsageError
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv, std::string& text);

}  // namespace eha::web
