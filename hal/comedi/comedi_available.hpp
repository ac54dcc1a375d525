// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::hal {

/// Whether this build can drive a card; `--version` says so.
inline constexpr bool comedi_available = EHA_WITH_COMEDI != 0;

}  // namespace eha::hal
