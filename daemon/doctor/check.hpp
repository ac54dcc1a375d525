// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace eha::doctor {

enum class Level { ok, warn, fail };

/// The result of one check.
struct Check {
  std::string name;  ///< "scheduling"
  Level level = Level::ok;
  std::string found;             ///< lines separated by newlines
  std::string remedy;            ///< the command or change that corrects it; empty when ok
  ExitCode code = ExitCode::ok;  ///< of a failure; ok otherwise
};

[[nodiscard]] Check ok(std::string name, std::string found);
[[nodiscard]] Check warn(std::string name, std::string found, std::string remedy);
[[nodiscard]] Check fail(std::string name, std::string found, std::string remedy, ExitCode code);

/// Returns the code of the most basic failure: configuration before device before permission before input/output, since
/// each makes the later ones meaningless. ok without a failure.
[[nodiscard]] ExitCode exit_code(const std::vector<Check>& checks) noexcept;

/// "ok", "warn", "fail".
[[nodiscard]] std::string_view to_text(Level level) noexcept;

/// Purpose of the checks. On a simulated rig an unmet requirement of a real one is only a warning.
enum class Stakes { simulated, machine };

}  // namespace eha::doctor
