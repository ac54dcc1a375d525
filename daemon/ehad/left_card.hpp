// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::service {

/// The snapshot of the card that a service of this socket drives, for eha-safe.
[[nodiscard]] std::filesystem::path snapshot_beside(const std::filesystem::path& socket);

/// Makes the card safe that a killed process of this socket left behind, before any file is read that may be wrong:
/// whatever ends this start, the rig is safe. Nothing where another process drives it, and for the file of another
/// user. What fails is logged and left to the service, which tries again. Cost: up to 3 s while the card is held.
/// @throws nothing
void make_left_card_safe(const std::filesystem::path& socket) noexcept;

}  // namespace eha::service
