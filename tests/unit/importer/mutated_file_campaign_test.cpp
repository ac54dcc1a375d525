// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdlib>

#include "tests/unit/importer/mutated_files.hpp"

namespace eha::importer {

/// EHA_MUTATIONS: how many of each kind; EHA_SEED: of the generator; EHA_KEEP: a folder for files that end badly.
class MutatedFileCampaign : public testing::TestWithParam<const char*> {};

TEST_P(MutatedFileCampaign, IsReadOrRefused) {
  const char* count = std::getenv("EHA_MUTATIONS");
  const char* seed = std::getenv("EHA_SEED");
  foreign::read_mutated(GetParam(), count == nullptr ? 100'000 : std::atoll(count),
                        seed == nullptr ? 1 : std::strtoull(seed, nullptr, 10));
}

INSTANTIATE_TEST_SUITE_P(Kinds, MutatedFileCampaign, testing::Values("mat", "hdf5", "csv", "raw"));

}  // namespace eha::importer
