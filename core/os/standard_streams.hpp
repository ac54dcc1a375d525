// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::os {

/// Opens /dev/null as each of the three standard streams that the process was started without. The first file that it
/// opens would otherwise become that stream, and messages would be written into it. To be called before any other.
void open_missing_streams() noexcept;

}  // namespace eha::os
