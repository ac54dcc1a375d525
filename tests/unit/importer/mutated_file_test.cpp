// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/importer/mutated_files.hpp"

namespace eha::importer {

TEST(MutatedFile, IsReadOrRefused) { foreign::read_mutated(90, 24); }

}  // namespace eha::importer
