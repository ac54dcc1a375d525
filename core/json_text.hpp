// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace eha {

/// No file of the program nests deeper. The library walks a document by recursion: a stranger's file of a million
/// levels would end the process.
inline constexpr int kDeepestJson = 64;

/// Parses the text of a file that may be a stranger's. @returns a discarded value, of which every is_...() but
/// is_discarded() is false, where the text is no JSON or nests too deeply
template <typename Json>
[[nodiscard]] Json parse_json_text(std::string_view text) {
  bool is_too_deep = false;
  const auto look_at_depth = [&](int depth, typename Json::parse_event_t, Json&) {
    is_too_deep = is_too_deep || depth > kDeepestJson;
    return !is_too_deep;
  };
  Json json = Json::parse(text.begin(), text.end(), look_at_depth, false);
  return is_too_deep ? Json(Json::value_t::discarded) : json;
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
