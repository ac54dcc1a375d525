// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/error.hpp"

namespace eha::cli {

/// Nobody reads standard output any more, as after `eha runs | head -1`: the command ends without a word.
class ClosedPipe : public IoError {
 public:
  using IoError::IoError;
};

}  // namespace eha::cli
