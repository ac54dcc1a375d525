// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha {
namespace {

/// Whether another user than root may open the rig of a file without the service.
bool is_refused_to_a_user(const config::RigConfig& rig) {
  const pid_t child = fork();
  if (child == 0) {
    if (setresuid(65534, 65534, 65534) != 0) _exit(2);
    try {
      require_local_rig_file(rig);
    } catch (const PermissionError&) {
      _exit(1);
    } catch (...) {
      _exit(3);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_LE(WEXITSTATUS(status), 1);
  return WEXITSTATUS(status) == 1;
}

TEST(LocalRigFile, OfACardIsOneOfEtcForEverybodyButRoot) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, whom such a file belongs to";
  const test::TemporaryFolder folder;
  chmod(folder.path().c_str(), 0755);
  const auto owned = [&](const char* shipped) {
    const config::RigConfig rig = config::load_rig(std::string(EHA_SOURCE_DIR "/config/rigs/") + shipped);
    const std::string file = folder.path() / shipped;
    std::ofstream(file) << rig.text;
    chmod(file.c_str(), 0644);
    return config::load_rig(file);
  };
  const config::RigConfig card = owned("pci1716.toml");
  EXPECT_NO_THROW(require_trusted_rig_file(card)) << "the service may";
  EXPECT_NO_THROW(require_local_rig_file(card)) << "root may";
  EXPECT_TRUE(is_refused_to_a_user(card));
  EXPECT_FALSE(is_refused_to_a_user(owned("sim.toml")));
}

TEST(LocalRigFile, LiesInEtcWhateverItsPathLooksLike) {
  EXPECT_FALSE(is_site_rig_file("/tmp/rig.toml"));
  EXPECT_FALSE(is_site_rig_file("/etc/ehad/../rig.toml"));
  EXPECT_FALSE(is_site_rig_file("/etc/ehad2/rig.toml"));
}

}  // namespace
}  // namespace eha
