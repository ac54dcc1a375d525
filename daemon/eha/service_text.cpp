// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace eha::cli {

using Json = nlohmann::ordered_json;

namespace {

double number(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

}  // namespace

std::string progress_text(const Json& run) {
  const std::string warning = run.value("near_limit", false)
                                  ? fmt::format(", NEAR A LIMIT: {:.0f} % of travel, {:.0f} % of velocity",
                                                number(run, "travel_percent"), number(run, "velocity_percent"))
                                  : "";
  return fmt::format(
      "{:.1f} of {:.1f} s, {:+.2f} V, {:.3f} in, latency at most {:.0f} us, {:.0f} late, {:.0f} skipped{}",
      number(run, "experiment_s"), number(run, "experiment_total_s"), number(run, "applied_V"),
      number(run, "displacement_in"), number(run, "latency_max_us"), number(run, "late"), number(run, "skipped"),
      warning);
}

double share_played(const Json& run) {
  return number(run, "experiment_s") / std::max(number(run, "experiment_total_s"), 1e-9);
}

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
