// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace eha::doctor {

/// Facts about the machine from /sys; a member is empty if the kernel reports none.
struct SystemFiles {
  std::vector<std::string> governors;  ///< frequency governors in use, each once; empty without frequency scaling
  std::vector<int> online_cpus;
  std::vector<int> isolated_cpus;          ///< excluded from the scheduler (isolcpus)
  std::string idle_driver;                 ///< "intel_idle"; "none" or empty when CPUs do not sleep deeply
  std::string clock_source;                ///< "tsc"
  std::vector<std::string> clock_sources;  ///< available
};

/// @param root  "/", or a folder laid out like it
[[nodiscard]] SystemFiles read_system_files(const std::filesystem::path& root);

/// Whether the PCI bus holds a device. @param vendor, device  four lower-case hexadecimal digits each
[[nodiscard]] bool has_pci_device(const std::filesystem::path& root, std::string_view vendor, std::string_view device);

/// Whether a kernel module drives a PCI device.
enum class ModuleSupport {
  listed,      ///< modules.alias names the module for the device
  not_listed,  ///< modules.alias does not name it
  unknown,     ///< there is no modules.alias for this kernel
};

/// Looks a module up in lib/modules/RELEASE/modules.alias, which depmod writes; out-of-tree modules are in it too.
/// @param vendor, device  four lower-case hexadecimal digits each
[[nodiscard]] ModuleSupport module_support(const std::filesystem::path& root, std::string_view release,
                                           std::string_view module_name, std::string_view vendor,
                                           std::string_view device);

}  // namespace eha::doctor
