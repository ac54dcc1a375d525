// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/system_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <system_error>

#include "daemon/delays/kernel_files.hpp"

namespace eha::doctor {
namespace {

namespace fs = std::filesystem;
using delays::cpu_list;
using delays::first_line;

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper;
}

std::vector<std::string> governors_in_use(const fs::path& policies) {
  std::vector<std::string> governors;
  std::error_code ignored;
  for (const fs::directory_entry& policy : fs::directory_iterator(policies, ignored)) {
    std::string governor = first_line(policy.path() / "scaling_governor");
    if (!governor.empty()) governors.push_back(std::move(governor));
  }
  std::sort(governors.begin(), governors.end());
  governors.erase(std::unique(governors.begin(), governors.end()), governors.end());
  return governors;
}

}  // namespace

SystemFiles read_system_files(const fs::path& root) {
  const fs::path cpu = root / "sys/devices/system/cpu";
  const fs::path clock = root / "sys/devices/system/clocksource/clocksource0";
  SystemFiles files;
  files.governors = governors_in_use(cpu / "cpufreq");
  files.online_cpus = cpu_list(first_line(cpu / "online"));
  files.isolated_cpus = cpu_list(first_line(cpu / "isolated"));
  files.idle_driver = first_line(cpu / "cpuidle/current_driver");
  files.clock_source = first_line(clock / "current_clocksource");
  std::istringstream available(first_line(clock / "available_clocksource"));
  for (std::string source; available >> source;) files.clock_sources.push_back(source);
  return files;
}

bool has_pci_device(const fs::path& root, std::string_view vendor, std::string_view device) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "sys/bus/pci/devices", ignored)) {
    if (first_line(entry.path() / "vendor") == fmt::format("0x{}", vendor) &&
        first_line(entry.path() / "device") == fmt::format("0x{}", device)) {
      return true;
    }
  }
  return false;
}

ModuleSupport module_support(const fs::path& root, std::string_view release, std::string_view module_name,
                             std::string_view vendor, std::string_view device) {
  std::ifstream aliases(root / "lib/modules" / release / "modules.alias");
  if (!aliases) return ModuleSupport::unknown;
  const std::string beginning = fmt::format("alias pci:v0000{}d0000{}", upper_case(vendor), upper_case(device));
  for (std::string line; std::getline(aliases, line);) {
    if (line.rfind(beginning, 0) == 0 && line.size() > module_name.size() &&
        line.compare(line.size() - module_name.size() - 1, std::string::npos, fmt::format(" {}", module_name)) == 0) {
      return ModuleSupport::listed;
    }
  }
  return ModuleSupport::not_listed;
}

}  // namespace eha::doctor
