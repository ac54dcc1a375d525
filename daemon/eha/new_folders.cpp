// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/new_folders.hpp"

#include <system_error>

#include "core/os/files.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

NewFolders::NewFolders(const fs::path& folder) : folder_((fs::absolute(folder) / "").lexically_normal().parent_path()) {
  std::error_code ignored;
  for (fs::path above = folder_; above.has_relative_path() && !fs::exists(above, ignored);
       above = above.parent_path()) {
    ++made_;
  }
  os::create_folders(folder_);
}

NewFolders::~NewFolders() {
  std::error_code failed;
  for (fs::path made = folder_; made_ > 0 && fs::remove(made, failed); made = made.parent_path()) --made_;
}

}  // namespace eha::cli
