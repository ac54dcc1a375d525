// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/owned_rig.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "config/rig_config.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(OwnedRig, ThatIsSimulatedLeavesThePageOfTheCardInItsFolderAlone) {
  const std::filesystem::path in_memory = "/dev/shm";
  if (!std::filesystem::is_directory(in_memory)) GTEST_SKIP() << "no " << in_memory;
  const test::TemporaryFolder folder(in_memory);
  const std::filesystem::path page = folder.write("guard.page", "of the service that drives a card");
  const std::string file = std::string(EHA_SOURCE_DIR) + "/config/rigs/sim.toml";
  { OwnedRig rig(config::parse_rig(text_of(file), file), folder.path() / "safe.json"); }
  EXPECT_EQ(text_of(page), "of the service that drives a card");
}

}  // namespace
}  // namespace eha
