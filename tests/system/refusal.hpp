// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {

/// Runs `eha` in a folder and expects it to refuse: this exit code, nothing on standard output, one line
/// "eha: error: ..." for each fault that holds each of `fragments`, and no file made, changed or removed.
void expect_refused(const TemporaryFolder& folder, const std::vector<std::string>& arguments, ExitCode code,
                    const std::vector<std::string>& fragments, std::size_t faults = 1);

/// A record of `rows` rows at 10 ms that a first-order lag explains, to be spoilt by a test.
[[nodiscard]] std::string sound_record(int rows);

}  // namespace eha::test
