// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/open_run.hpp"

#include <fcntl.h>

#include <utility>

#include "core/os/files.hpp"
#include "daemon/record/resolved_path.hpp"

namespace eha::record {

OpenRun::OpenRun(const std::filesystem::path& folder) {
  constexpr int kHold = O_PATH | O_DIRECTORY | O_NOFOLLOW;
  Held held{.path = resolved_path(folder), .parent = {}, .folder = {}, .files = {}, .beside = {}};
  held.parent = os::open_file(held.path.parent_path(), kHold);
  held.beside = os::path_through(held.parent);
  held.folder = os::open_file(held.beside / held.path.filename(), kHold);
  held.files = os::path_through(held.folder);
  held_ = std::make_shared<const Held>(std::move(held));
}

}  // namespace eha::record
