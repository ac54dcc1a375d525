// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>

namespace eha::ident {

/// Default seed of a random excitation.
inline constexpr std::uint64_t kDefaultSeed = 1;
/// Greatest integer of a TOML file.
inline constexpr std::int64_t kGreatestSeed = std::numeric_limits<std::int64_t>::max();

}  // namespace eha::ident
