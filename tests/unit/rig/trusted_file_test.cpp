// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <thread>

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

/// In a mount table of its own with an /etc/ehad: another user turns a link to and fro between that and a folder with
/// another file of root, and asks again and again. @returns how often that file was taken; -1: not possible here
int times_taken(const std::filesystem::path& outside, const std::filesystem::path& links) {
  constexpr int kTries = 3000;
  constexpr int kImpossible = 255;
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNS) != 0 || mount("", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", "/etc", "tmpfs", 0, nullptr) != 0 || mkdir("/etc/ehad", 0755) != 0) {
      _exit(kImpossible);
    }
    std::ofstream("/etc/ehad/rig.toml") << "# the file of the site\n";
    config::RigConfig rig = config::load_rig(outside / "rig.toml");
    rig.file_name = links / "link" / "rig.toml";
    if (setresuid(65534, 65534, 65534) != 0) _exit(kImpossible);
    std::atomic<bool> goes_on = true;
    std::thread turning([&] {
      for (int i = 0; goes_on; ++i) {
        std::filesystem::create_directory_symlink(i % 2 == 0 ? outside : "/etc/ehad", links / "next");
        std::filesystem::rename(links / "next", links / "link");
      }
    });
    int taken = 0;
    for (int i = 0; i < kTries && taken < 100; ++i) {
      try {
        require_local_rig_file(rig);
        ++taken;
      } catch (const Error&) {
        // As it should be.
      }
    }
    goes_on = false;
    turning.join();
    _exit(taken);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  return WEXITSTATUS(status) == kImpossible ? -1 : WEXITSTATUS(status);
}

TEST(LocalRigFile, IsNotTakenThroughALinkThatTurnsMeanwhile) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, whom such a file belongs to";
  const test::TemporaryFolder outside;
  const test::TemporaryFolder links;
  chmod(outside.path().c_str(), 0755);
  chmod(links.path().c_str(), 0777);
  outside.write("rig.toml", config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml").text);
  chmod((outside.path() / "rig.toml").c_str(), 0644);
  const int taken = times_taken(outside.path(), links.path());
  if (taken < 0) GTEST_SKIP() << "needs a mount table of its own";
  EXPECT_EQ(taken, 0);
}

/// In a user namespace whose root is another user than the machine's. @returns the exit code of `asked`; 255: not
/// possible here
int as_root_of_a_namespace(const std::function<int()>& asked) {
  constexpr int kImpossible = 255;
  const pid_t child = fork();
  if (child == 0) {
    // Whose files in /proc would otherwise be root's after the change of the user.
    if (setresuid(65534, 65534, 65534) != 0 || prctl(PR_SET_DUMPABLE, 1) != 0 || unshare(CLONE_NEWUSER) != 0) {
      _exit(kImpossible);
    }
    std::ofstream map("/proc/self/uid_map");
    map << "0 65534 1" << std::flush;
    if (!map || geteuid() != 0) _exit(kImpossible);
    _exit(asked());
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

TEST(LocalRigFile, OfTheRootOfANamespaceIsNotRoots) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give a file to another user";
  const test::TemporaryFolder folder;
  chmod(folder.path().c_str(), 0755);
  const std::string file = folder.path() / "rig.toml";
  std::ofstream(file) << config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml").text;
  chmod(file.c_str(), 0644);
  ASSERT_EQ(chown(file.c_str(), 65534, 65534), 0);
  const config::RigConfig rig = config::load_rig(file);
  const int ended = as_root_of_a_namespace([&] {
    struct stat facts {};
    if (stat(file.c_str(), &facts) != 0 || facts.st_uid != 0) return 2;  // it looks like root's
    try {
      require_local_rig_file(rig);
      return 0;
    } catch (const PermissionError&) {
      return 1;
    }
  });
  if (ended == 255) GTEST_SKIP() << "needs user namespaces";
  EXPECT_EQ(ended, 1);
}

TEST(LocalRigFile, LiesInEtcWhateverItsPathLooksLike) {
  EXPECT_FALSE(is_site_rig_file("/tmp/rig.toml"));
  EXPECT_FALSE(is_site_rig_file("/etc/ehad/../rig.toml"));
  EXPECT_FALSE(is_site_rig_file("/etc/ehad2/rig.toml"));
}

}  // namespace
}  // namespace eha
