// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/system_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>

namespace eha::doctor {
namespace {

namespace fs = std::filesystem;

/// First line of a kernel file; empty when it cannot be read.
std::string first_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
  return line;
}

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

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

std::vector<int> cpu_list(std::string_view text) {
  constexpr int kMostCpus = 1 << 16;
  std::vector<int> cpus;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::string_view part = text.substr(0, comma);
    text.remove_prefix(std::min(comma + 1, text.size()));
    const std::size_t dash = part.find('-');
    const std::optional<int> first = whole_number(part.substr(0, dash));
    const std::optional<int> last = dash == std::string_view::npos ? first : whole_number(part.substr(dash + 1));
    if (!first || !last || *first < 0 || *last >= kMostCpus) continue;
    for (int cpu = *first; cpu <= *last; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

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
