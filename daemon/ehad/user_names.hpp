// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <map>
#include <string>

#include "daemon/ehad/background.hpp"

namespace eha::service {

/// Names of users, for messages. The users of /etc/passwd are read from that file; others (LDAP, sssd), whose look-up
/// may take as long as a network does, are looked up by a thread of their own and go by their number until it has
/// answered. Never blocks. Belongs to the main thread.
class UserNames {
 public:
  static constexpr std::size_t kMostKept = 1024;

  explicit UserNames(Mailbox& mailbox) : thread_("eha-names", mailbox) {}

  /// @returns printable, at most 64 characters
  [[nodiscard]] std::string name(uid_t uid);

 private:
  std::map<uid_t, std::string> names_;
  Background thread_;
};

}  // namespace eha::service
