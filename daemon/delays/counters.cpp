// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/delays/counters.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

#include "core/os/file_descriptor.hpp"
#include "core/text.hpp"
#include "daemon/delays/kernel_files.hpp"

namespace eha::delays {
namespace {

namespace fs = std::filesystem;

constexpr double kTick_s = 0.01;  // USER_HZ, the unit of /proc
constexpr std::size_t kLongestName = 32;
constexpr off_t kSmiCount = 0x34;  // MSR_SMI_COUNT of Intel's processors

bool is_number(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The number behind "cpu"; -1 for other names, as "cpuidle".
int cpu_of(std::string_view name) {
  constexpr std::size_t kPrefix = 3;
  return (name.starts_with("cpu") || name.starts_with("CPU")) && is_number(name.substr(kPrefix))
             ? std::atoi(name.data() + kPrefix)
             : -1;
}

/// The rows of /proc/interrupts or /proc/softirqs. The first line names the CPUs of the columns.
std::map<std::string, InterruptRow> interrupt_rows(const fs::path& file) {
  std::map<std::string, InterruptRow> rows;
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::vector<int> cpus;
  std::istringstream header(line);
  for (std::string name; header >> name;) cpus.push_back(cpu_of(name));
  while (std::getline(stream, line)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::size_t first = line.find_first_not_of(' ');
    InterruptRow row;
    std::istringstream counts(line.substr(colon + 1));
    for (const int cpu : cpus) {
      std::uint64_t count = 0;
      if (!(counts >> count)) break;
      row.count[cpu] = count;
    }
    std::string rest;
    std::getline(counts, rest);
    const std::size_t gap = rest.rfind("  ");
    row.device = gap == std::string::npos ? rest : rest.substr(gap + 2);
    rows[line.substr(first, colon - first)] = std::move(row);
  }
  return rows;
}

std::map<int, CpuTime> cpu_times(const fs::path& file) {
  std::map<int, CpuTime> times;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream fields(line);
    std::string name;
    fields >> name;
    const int cpu = cpu_of(name);
    double user = 0.0, nice = 0.0, system = 0.0, idle = 0.0, waiting = 0.0, interrupts = 0.0, softirqs = 0.0,
           stolen = 0.0;
    if (cpu < 0 || !(fields >> user >> nice >> system >> idle >> waiting >> interrupts >> softirqs >> stolen)) continue;
    times[cpu] = {(user + nice + system + interrupts + softirqs) * kTick_s, stolen * kTick_s};
  }
  return times;
}

std::vector<SleepState> sleep_states(const fs::path& folder) {
  std::vector<SleepState> states;
  std::error_code ignored;
  for (const fs::directory_entry& state : fs::directory_iterator(folder, ignored)) {
    const std::string name = first_line(state.path() / "name");
    if (name.empty()) continue;
    states.push_back({name, std::atof(first_line(state.path() / "latency").c_str()),
                      std::strtoull(first_line(state.path() / "usage").c_str(), nullptr, 10)});
  }
  return states;
}

/// @returns whether the CPU has the counter and it is readable
bool read_smi(const fs::path& msr, std::uint64_t& count) {
  const os::FileDescriptor file(open(msr.c_str(), O_RDONLY | O_CLOEXEC));
  return file && pread(file.get(), &count, sizeof count, kSmiCount) == static_cast<ssize_t>(sizeof count);
}

/// Adds the thread of a /proc/PID/task/TID/stat, if its priority is real-time.
void add_thread(const fs::path& task, pid_t process, std::map<pid_t, RealtimeThread>& threads) {
  std::ifstream stream(task / "stat");
  std::string stat;
  std::getline(stream, stat, '\0');
  // "TID (name) state parent ..."; the name may contain any character.
  const std::size_t name = stat.find('(');
  const std::size_t name_end = stat.rfind(')');
  if (name == std::string::npos || name_end == std::string::npos || name_end < name) return;
  std::istringstream rest(stat.substr(name_end + 1));
  std::vector<std::string> fields;  // from the third, proc(5)
  for (std::string field; rest >> field;) fields.push_back(std::move(field));
  constexpr std::size_t kFirst = 3;
  const auto number = [&](std::size_t field) { return std::atol(fields[field - kFirst].c_str()); };
  constexpr std::size_t kParent = 4, kUser = 14, kSystem = 15, kProcessor = 39, kPriority = 40, kPolicy = 41;
  if (fields.size() <= kPolicy - kFirst) return;
  constexpr long kDeadline = 6;
  const bool is_deadline = number(kPolicy) == kDeadline;
  if (number(kPriority) == 0 && !is_deadline) return;
  threads[std::atoi(task.filename().c_str())] = {
      .process = process,
      .parent = static_cast<pid_t>(number(kParent)),
      .name = shortened(stat.substr(name + 1, name_end - name - 1), kLongestName),
      .priority = is_deadline ? 100 : static_cast<int>(number(kPriority)),
      .cpu = static_cast<int>(number(kProcessor)),
      .used_s = static_cast<double>(number(kUser) + number(kSystem)) * kTick_s};
}

std::map<pid_t, RealtimeThread> realtime_threads(const fs::path& proc) {
  std::map<pid_t, RealtimeThread> threads;
  std::error_code ignored;
  for (const fs::directory_entry& process : fs::directory_iterator(proc, ignored)) {
    const std::string pid = process.path().filename().string();
    if (!is_number(pid)) continue;
    std::error_code gone;
    fs::directory_iterator task(process.path() / "task", gone);
    for (; !gone && task != fs::directory_iterator(); task.increment(gone)) {
      add_thread(task->path(), std::atoi(pid.c_str()), threads);
    }
  }
  return threads;
}

}  // namespace

Counters read_counters(const fs::path& root) {
  Counters counters;
  counters.uptime_s = std::atof(first_line(root / "proc/uptime").c_str());
  counters.interrupts = interrupt_rows(root / "proc/interrupts");
  counters.softirqs = interrupt_rows(root / "proc/softirqs");
  counters.cpus = cpu_times(root / "proc/stat");
  for (const auto& [cpu, time] : counters.cpus) {
    const std::string number = std::to_string(cpu);
    auto states = sleep_states(root / "sys/devices/system/cpu" / ("cpu" + number) / "cpuidle");
    if (!states.empty()) counters.sleep[cpu] = std::move(states);
    std::uint64_t count = 0;
    if (read_smi(root / "dev/cpu" / number / "msr", count)) counters.smi[cpu] = count;
  }
  counters.realtime_threads = realtime_threads(root / "proc");
  return counters;
}

}  // namespace eha::delays
