// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "core/utf8.hpp"

namespace eha {

/// Escapes text for HTML: &, <, > and quotes become entities, control characters but line ends spaces, and bytes that
/// are no UTF-8 '?'. Cost O(N).
[[nodiscard]] inline std::string escaped_html(std::string_view text) {
  std::string html;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    const char c = text.front();
    if (length == 0) {
      html += '?';
    } else if (length > 1) {
      html += text.substr(0, length);
    } else if (c == '&') {
      html += "&amp;";
    } else if (c == '<') {
      html += "&lt;";
    } else if (c == '>') {
      html += "&gt;";
    } else if (c == '"') {
      html += "&quot;";
    } else if (c == '\'') {
      html += "&#39;";
    } else {
      html += (static_cast<unsigned char>(c) < ' ' && c != '\n') || c == '\x7f' ? ' ' : c;
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return html;
}

}  // namespace eha
