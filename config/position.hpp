// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace eha::config {

/// A place in a text file, both counted from 1; the column counts characters, not bytes.
struct Position {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

/// Maps a key's full path ("excitation.tones[0].frequency_Hz", tables counted from 0) to the place of its value.
using PositionMap = std::map<std::string, Position>;

}  // namespace eha::config
