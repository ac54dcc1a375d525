// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/privileges.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>

#include "core/os/file_descriptor.hpp"

namespace eha::doctor {
namespace {

template <typename Resource>
std::uint64_t limit_of(Resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? Privileges::kUnlimited : limit.rlim_cur;
}

/// A soft limit in a text of /proc/PID/limits, whose lines are a name, the soft and the hard limit.
std::optional<std::uint64_t> soft_limit_in(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name);
  if (at == std::string::npos) return std::nullopt;
  std::istringstream rest(text.substr(at + name.size()));
  std::string soft;
  rest >> soft;
  if (soft == "unlimited") return Privileges::kUnlimited;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(soft.data(), soft.data() + soft.size(), value);
  return error == std::errc() && end == soft.data() + soft.size() ? std::optional(value) : std::nullopt;
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

Privileges probe_privileges(int priority) {
  Privileges found;
  found.is_root = geteuid() == 0;
  std::thread([&] {
    sched_param parameter{};
    parameter.sched_priority = priority;
    found.fifo_error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  }).join();
  found.rtprio_limit = limit_of(RLIMIT_RTPRIO);
  found.memlock_limit_bytes = limit_of(RLIMIT_MEMLOCK);
  const os::FileDescriptor dma_latency(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  found.dma_latency_error = dma_latency ? 0 : errno;
  return found;
}

std::optional<Privileges> privileges_of_service(const std::filesystem::path& process, const Privileges& caller) {
  const std::string limits = content_of(process / "limits");
  const auto rtprio = soft_limit_in(limits, "Max realtime priority");
  const auto memlock = soft_limit_in(limits, "Max locked memory");
  if (!rtprio || !memlock) return std::nullopt;
  Privileges found = caller;
  found.are_grants_tried = caller.is_root;
  found.is_root = false;
  found.rtprio_limit = *rtprio;
  found.memlock_limit_bytes = *memlock;
  found.is_of_service = true;
  std::istringstream status(content_of(process / "status"));
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    std::string real;
    std::string effective;
    if (words >> name >> real >> effective && name == "Uid:") found.is_root = effective == "0";
  }
  return found;
}

}  // namespace eha::doctor
