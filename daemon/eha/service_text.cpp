// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <fmt/format.h>

#include <vector>

namespace eha::cli {

using Json = nlohmann::ordered_json;

std::string verdict_text(const Json& entry) {
  std::string text = entry.value("outcome", "");
  std::vector<std::string> accepted;
  for (const Json& model : entry.value("models", Json::array())) {
    if (model.value("accepted", false)) accepted.push_back(model.value("name", "?"));
  }
  if (!accepted.empty()) {
    text += fmt::format(", accepted: {}", fmt::join(accepted, ", "));
  } else if (!entry.value("models", Json::array()).empty()) {
    text += ", all rejected";
  }
  const std::string note = entry.value("note", "");
  if (!note.empty()) text += (text.empty() ? "" : ": ") + note;
  return text;
}

}  // namespace eha::cli
