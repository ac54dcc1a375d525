// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string_view>

namespace eha::web {

/// A file of the page, compiled in from daemon/web/page/.
struct PageFile {
  std::string_view name;  ///< "index.html"
  std::string_view content_type;
  std::string_view content;
};

/// Returns every file of the page; embed.cmake makes page_files.cpp from the folder.
[[nodiscard]] std::span<const PageFile> page_files() noexcept;

}  // namespace eha::web
