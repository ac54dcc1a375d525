// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/importer/mutated_files.hpp"

namespace eha::importer {

TEST(MutatedFile, IsReadOrRefused) {
  for (const char* kind : {"mat", "hdf5", "csv", "raw"}) foreign::read_mutated(kind, 300, 24);
}

TEST(MutatedFile, IsMadeOfSoundFiles) {
  for (const foreign::Fixture& fixture : foreign::fixtures_to_damage()) {
    const test::TemporaryFolder folder;
    foreign::Used used;
    const auto path = folder.write(fixture.name, fixture.content);
    EXPECT_EQ(foreign::read_again(fixture.kind, path, used), "") << fixture.name;
    // Some texts are asked about: which column is the input?
    EXPECT_TRUE(fixture.kind == "csv" || foreign::read_here(fixture.kind, path)) << fixture.name;
  }
}

}  // namespace eha::importer
