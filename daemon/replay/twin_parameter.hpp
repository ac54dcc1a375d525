// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/sim/sim_options.hpp"

namespace eha::replay {

/// Returns the keys of `[sim]` that a record can determine: the plant's, not those of converters, sensor and
/// integration. In the order of the file.
[[nodiscard]] std::vector<std::string> twin_parameters();

/// The value of a key. @throws UsageError  no such key; names the nearest one
[[nodiscard]] double value_of(const hal::SimOptions& options, std::string_view key);

/// The options with one key changed. @throws UsageError as value_of
[[nodiscard]] hal::SimOptions with_value(hal::SimOptions options, std::string_view key, double value);

}  // namespace eha::replay
