// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::hal {

/// Where the card is and how it is wired.
struct ComediOptions {};

}  // namespace eha::hal
