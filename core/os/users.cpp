// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/users.hpp"

#include <pwd.h>

#include <charconv>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace eha::os {
namespace {

constexpr uid_t kLeastSubordinate = 65536;  // smaller uids are those of the machine's users
constexpr uid_t kNobody = 65534;
constexpr std::size_t kBuffer = 16 * 1024;

/// Returns the first user of a file like /etc/passwd that is wanted.
template <typename IsWanted, typename Take>
void find_user(const std::filesystem::path& passwd_file, const IsWanted& is_wanted, const Take& take) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(passwd_file.c_str(), "re"), std::fclose);
  if (!file) return;
  std::vector<char> buffer(kBuffer);
  passwd entry{};
  passwd* found = nullptr;
  while (fgetpwent_r(file.get(), &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    if (is_wanted(*found)) return take(*found);
  }
}

std::optional<uid_t> number_of(std::string_view text) {
  uid_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<uid_t> uid_of(const std::string& user, const std::filesystem::path& passwd_file) {
  if (const std::optional<uid_t> number = number_of(user)) return number;
  std::optional<uid_t> uid;
  find_user(
      passwd_file, [&](const passwd& entry) { return entry.pw_name == user; },
      [&](const passwd& entry) { uid = entry.pw_uid; });
  return uid;
}

}  // namespace

uid_t accountable_user(uid_t uid, const std::filesystem::path& subuid, const std::filesystem::path& passwd) {
  if (uid < kLeastSubordinate) return uid;
  std::ifstream file(subuid);
  for (std::string line; std::getline(file, line);) {  // USER:FIRST:COUNT
    const std::size_t first_at = line.find(':');
    const std::size_t count_at = first_at == std::string::npos ? first_at : line.find(':', first_at + 1);
    if (count_at == std::string::npos) continue;
    const auto first = number_of(std::string_view(line).substr(first_at + 1, count_at - first_at - 1));
    const auto count = number_of(std::string_view(line).substr(count_at + 1));
    if (!first || !count || uid < *first || uid - *first >= *count) continue;
    // Containers of a manager that runs as root; their users have none of root's rights.
    if (const auto owner = uid_of(line.substr(0, first_at), passwd)) return *owner == 0 ? kNobody : *owner;
  }
  return uid;
}

std::string local_user_name(uid_t uid, const std::filesystem::path& passwd) {
  std::string name;
  find_user(
      passwd, [&](const ::passwd& entry) { return entry.pw_uid == uid; },
      [&](const ::passwd& entry) { name = entry.pw_name; });
  return name;
}

std::string local_user_text(uid_t uid) {
  std::string name = local_user_name(uid);
  return name.empty() ? "uid " + std::to_string(uid) : name;
}

}  // namespace eha::os
