// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "core/terminal_text.hpp"

namespace eha::record {

/// Makes every text of a document one line (one_line()), but those that have lines of their own: the `text` of a rig
/// file or an experiment, the `remarks` on a record, the `message` of a process. Cost: one pass.
inline void make_one_line(nlohmann::ordered_json& document) {
  if (!document.is_structured()) return;
  for (auto item = document.begin(); item != document.end(); ++item) {
    if (!item->is_string()) {
      make_one_line(*item);
      continue;
    }
    const std::string key = document.is_object() ? item.key() : "";
    if (key == "text" || key == "remarks" || key == "message") continue;
    auto& text = item->get_ref<std::string&>();
    text = one_line(text);
  }
}

}  // namespace eha::record
