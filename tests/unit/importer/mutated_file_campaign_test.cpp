// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdlib>

#include "tests/unit/importer/mutated_files.hpp"

namespace eha::importer {

/// EHA_MUTATIONS: how many; EHA_SEED: of the generator.
TEST(MutatedFileCampaign, IsReadOrRefused) {
  const char* count = std::getenv("EHA_MUTATIONS");
  const char* seed = std::getenv("EHA_SEED");
  foreign::read_mutated(count == nullptr ? 20'000 : std::atoi(count),
                        seed == nullptr ? 1 : std::strtoull(seed, nullptr, 10));
}

}  // namespace eha::importer
