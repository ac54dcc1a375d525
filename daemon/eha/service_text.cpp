// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <fmt/format.h>

#include <ctime>
#include <optional>
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

std::vector<std::string> end_times(const nlohmann::ordered_json& entries) {
  std::vector<std::string> texts;
  std::optional<double> end_s;
  for (const auto& entry : entries) {
    const std::string state = entry.at("state");
    const double duration_s = entry.value("duration_s", 0.0);
    std::tm start{};
    texts.emplace_back();
    if (entry.value("fast", false)) continue;
    if (state == "running" && strptime(entry.value("run", "").c_str(), "%Y%m%dT%H%M%SZ", &start) != nullptr) {
      end_s = static_cast<double>(timegm(&start)) + duration_s;
    } else if (state == "waiting" && end_s) {
      *end_s += duration_s;
    } else {
      continue;
    }
    const auto seconds = static_cast<std::time_t>(*end_s);
    std::tm local{};
    localtime_r(&seconds, &local);
    texts.back() = fmt::format("{:02}:{:02}", local.tm_hour, local.tm_min);
  }
  return texts;
}

}  // namespace eha::cli
