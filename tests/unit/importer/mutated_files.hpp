// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/foreign_reader.hpp"
#include "tests/unit/importer/foreign_fixtures.hpp"
#include "tests/unit/temporary_folder.hpp"

// MAT-files and HDF5 with bytes changed at random: arrays or a refusal, within the limits, and nothing else.

namespace eha::importer::foreign {

inline std::string mutated(std::string bytes, std::mt19937_64& generator) {
  constexpr std::uint64_t kSizes[] = {
      0, 1, 2, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fffffffffffffff, 0xffffffffffffffff};
  const std::size_t changes = 1 + generator() % 4;
  for (std::size_t i = 0; i < changes && bytes.size() > 16; ++i) {
    const std::size_t at = generator() % (bytes.size() - 8);
    switch (generator() % 6) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << generator() % 8));
        break;
      case 1:
        bytes[at] = static_cast<char>(generator() % 256);
        break;
      case 2:
      case 3: {
        const std::uint64_t size = kSizes[generator() % std::size(kSizes)];
        std::memcpy(&bytes[at], &size, generator() % 2 == 0 ? 4 : 8);
        break;
      }
      case 4:
        bytes.resize(at + 8);
        break;
      default:
        bytes.insert(at, bytes.substr(generator() % bytes.size(), 1 + generator() % 64));
    }
  }
  return bytes;
}

inline void read_mutated(int count, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const test::TemporaryFolder folder;
  const std::vector<Fixture> sound = fixtures();
  int crashes = 0;
  int read = 0;
  for (int i = 0; i < count; ++i) {
    const Fixture& fixture = sound[static_cast<std::size_t>(i) % sound.size()];
    const auto file = folder.write(fixture.name, mutated(fixture.content, generator));
    try {
      static_cast<void>(read_foreign(fixture.kind, file));
      ++read;
    } catch (const DataError& error) {
      // The library crashed in its own process, which is why it has one.
      if (std::string(error.what()).find("(signal ") != std::string::npos) ++crashes;
    } catch (const std::exception& error) {
      FAIL() << fixture.name << " of seed " << seed << ", mutation " << i << ": " << error.what();
    }
  }
  std::cout << count << " files: " << read << " read, " << crashes << " crashed the reader\n";
}

}  // namespace eha::importer::foreign
