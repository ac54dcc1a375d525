// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/system_files.hpp"

#include <gtest/gtest.h>

#include "tests/unit/temporary_folder.hpp"

namespace eha::doctor {
namespace {

using Cpus = std::vector<int>;

/// A folder laid out like "/".
class Root {
 public:
  void write(const std::string& file, std::string_view content) const {
    std::filesystem::create_directories((folder_.path() / file).parent_path());
    folder_.write(file, content);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  test::TemporaryFolder folder_;
};

TEST(SystemFiles, AreReadBelowTheRoot) {
  const Root root;
  root.write("sys/devices/system/cpu/online", "0-3\n");
  root.write("sys/devices/system/cpu/isolated", "2-3\n");
  root.write("sys/devices/system/cpu/cpuidle/current_driver", "intel_idle\n");
  root.write("sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "powersave\n");
  root.write("sys/devices/system/cpu/cpufreq/policy1/scaling_governor", "performance\n");
  root.write("sys/devices/system/cpu/cpufreq/policy2/scaling_governor", "powersave\n");
  root.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  root.write("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm \n");
  const SystemFiles files = read_system_files(root.path());
  EXPECT_EQ(files.online_cpus, (Cpus{0, 1, 2, 3}));
  EXPECT_EQ(files.isolated_cpus, (Cpus{2, 3}));
  EXPECT_EQ(files.idle_driver, "intel_idle");
  EXPECT_EQ(files.governors, (std::vector<std::string>{"performance", "powersave"}));
  EXPECT_EQ(files.clock_source, "hpet");
  EXPECT_EQ(files.clock_sources, (std::vector<std::string>{"tsc", "hpet", "acpi_pm"}));
}

TEST(SystemFiles, AreEmptyWhereThereAreNone) {
  const Root root;
  const SystemFiles files = read_system_files(root.path());
  EXPECT_TRUE(files.governors.empty());
  EXPECT_TRUE(files.online_cpus.empty());
  EXPECT_EQ(files.clock_source, "");
}

TEST(SystemFiles, FindADeviceOnThePciBus) {
  const Root root;
  EXPECT_FALSE(has_pci_device(root.path(), "13fe", "1716"));
  root.write("sys/bus/pci/devices/0000:00:1f.0/vendor", "0x8086\n");
  root.write("sys/bus/pci/devices/0000:00:1f.0/device", "0x1716\n");
  EXPECT_FALSE(has_pci_device(root.path(), "13fe", "1716"));
  root.write("sys/bus/pci/devices/0000:03:00.0/vendor", "0x13fe\n");
  root.write("sys/bus/pci/devices/0000:03:00.0/device", "0x1716\n");
  EXPECT_TRUE(has_pci_device(root.path(), "13fe", "1716"));
}

TEST(SystemFiles, TellWhichKernelModuleDrivesTheCard) {
  const Root root;
  const auto support = [&] { return module_support(root.path(), "6.1.0-rt", "adv_pci1710", "13fe", "1716"); };
  EXPECT_EQ(support(), ModuleSupport::unknown);
  // Debian's own module: 1710, 1711, 1713, 1731. Another module for the card is not this one.
  const std::string own =
      "# Aliases extracted from modules themselves.\n"
      "alias pci:v000013FEd00001710sv*sd*bc*sc*i* adv_pci1710\n"
      "alias pci:v000013FEd00001731sv*sd*bc*sc*i* adv_pci1710\n"
      "alias pci:v000013FEd00001716sv*sd*bc*sc*i* not_adv_pci1710\n";
  root.write("lib/modules/6.1.0-rt/modules.alias", own);
  EXPECT_EQ(support(), ModuleSupport::not_listed);
  root.write("lib/modules/6.1.0-rt/modules.alias", own + "alias pci:v000013FEd00001716sv*sd*bc*sc*i* adv_pci1710\n");
  EXPECT_EQ(support(), ModuleSupport::listed);
}

}  // namespace
}  // namespace eha::doctor
