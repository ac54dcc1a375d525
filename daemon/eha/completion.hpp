// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace eha::cli {

/// The completion script of `shell` ("bash" or "zsh") for every command, option and choice of `app`. The type name of
/// an option or argument determines the offered values: the lower-case words of "free|SECONDS", files for FILE, MODEL
/// and the like, folders for DIR, none for other types.
[[nodiscard]] std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace eha::cli
