// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>

namespace eha::service {

/// Names of users, for messages. The users of /etc/passwd are read from that file; others (LDAP, sssd) are looked up by
/// a detached thread, because that may take long, and appear as numbers until then. Neither name() nor the destructor
/// waits for a look-up. Belongs to the main thread.
class UserNames {
 public:
  static constexpr std::size_t kMostKept = 1024;

  UserNames();
  UserNames(const UserNames&) = delete;
  UserNames& operator=(const UserNames&) = delete;
  ~UserNames();

  /// @returns printable, at most 64 characters
  [[nodiscard]] std::string name(uid_t uid);

 private:
  struct LookUps;  ///< shared with the thread, which may outlive this object

  std::map<uid_t, std::string> names_;
  std::shared_ptr<LookUps> look_ups_;
};

}  // namespace eha::service
