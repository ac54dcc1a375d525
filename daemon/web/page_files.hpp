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

/// Every file of the page; page_files.cpp is made from the folder by embed.cmake.
[[nodiscard]] std::span<const PageFile> page_files() noexcept;

}  // namespace eha::web
