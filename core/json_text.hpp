// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "core/json_shape.hpp"

namespace eha {

/// Parses the text of a file that may be a stranger's. @returns a discarded value, of which every is_...() but
/// is_discarded() is false, where the text is no JSON or beyond JsonBounds
template <typename Json>
[[nodiscard]] Json parse_json_text(std::string_view text) {
  if (json_shape(text, {}).fault != JsonFault::none) return Json(Json::value_t::discarded);
  return Json::parse(text.begin(), text.end(), nullptr, false);
}

/// A text of a document that may be a stranger's. @param place  a JSON pointer, such as "/rig/name"
/// @returns `otherwise` where nothing or no text is there
template <typename Json>
[[nodiscard]] std::string text_at(const Json& document, const char* place, std::string otherwise = {}) {
  const typename Json::json_pointer pointer(place);
  return document.contains(pointer) && document.at(pointer).is_string()
             ? document.at(pointer).template get<std::string>()
             : std::move(otherwise);
}

}  // namespace eha
