// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/user_names.hpp"

#include <pwd.h>

#include <cstdio>
#include <future>
#include <memory>
#include <vector>

#include "core/text.hpp"

namespace eha::service {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kBuffer = 16 * 1024;

/// The name in /etc/passwd, without the name service switch; empty when it is not there.
std::string local_name(uid_t uid) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/etc/passwd", "re"), std::fclose);
  if (!file) return {};
  std::vector<char> buffer(kBuffer);
  passwd entry{};
  passwd* found = nullptr;
  while (fgetpwent_r(file.get(), &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    if (found->pw_uid == uid) return shortened(found->pw_name, kLongestName);
  }
  return {};
}

/// The name by the name service switch; the number when it has none.
std::string looked_up_name(uid_t uid) {
  std::vector<char> buffer(kBuffer);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    return shortened(found->pw_name, kLongestName);
  }
  return std::to_string(uid);
}

}  // namespace

std::string UserNames::name(uid_t uid) {
  const auto known = names_.find(uid);
  if (known != names_.end()) return known->second;
  if (names_.size() >= kMostKept) names_.clear();
  std::string& name = names_[uid];
  name = local_name(uid);
  if (name.empty()) {
    name = std::to_string(uid);
    thread_.ask([uid] { return looked_up_name(uid); },
                [this, uid](std::future<std::string> found) { names_[uid] = found.get(); });
  }
  return name;
}

}  // namespace eha::service
