// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace eha::os {

/// Returns the user who answers for processes of a uid: the owner of a subordinate uid, of which subuid(5) gives a user
/// thousands, nobody (65534) for one of root, else the uid itself, also where a file cannot be read. What each user may
/// have only so much of is counted by this one. Reads the two files and nothing else: it does not block. Cost: some 20
/// us for a uid from 65536 on.
/// @param subuid, passwd  files like /etc/subuid and /etc/passwd
[[nodiscard]] uid_t accountable_user(uid_t uid, const std::filesystem::path& subuid = "/etc/subuid",
                                     const std::filesystem::path& passwd = "/etc/passwd");

/// Returns the name in a file like /etc/passwd, without the name service switch; empty if it is not there.
[[nodiscard]] std::string local_user_name(uid_t uid, const std::filesystem::path& passwd = "/etc/passwd");

/// The same for messages: "uid 1234" if it is not there.
[[nodiscard]] std::string local_user_text(uid_t uid);

}  // namespace eha::os
