// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/kind_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eha::tune {

using ident::FeedbackKind;

std::string name_of(FeedbackKind kind) {
  switch (kind) {
    case FeedbackKind::p:
      return "P";
    case FeedbackKind::pi:
      return "PI";
    case FeedbackKind::pd:
      return "PD";
    case FeedbackKind::pid:
      return "PID";
    case FeedbackKind::fopid:
      return "FOPID";
  }
  return "?";
}

std::vector<ComparedKind> kinds_compared(const std::vector<Candidate>& candidates, const ident::AxisPlant& plant,
                                         std::optional<double> fractional_gain) {
  const ident::PlantResponse response{plant.grid_rad_s, plant.response, plant.order_at_zero};
  std::vector<ComparedKind> kinds;
  std::vector<double> load_errors;
  std::optional<double> of_pid;
  for (const auto& [name, kind] : ident::kFeedbackKinds) {
    const Candidate* best = nullptr;
    for (const Candidate& c : candidates) {
      if (c.kind == kind && !c.hunts && (best == nullptr || c.following_rms_in < best->following_rms_in)) best = &c;
    }
    if (best == nullptr) continue;
    const ident::Feedback& feedback = best->design.settings.feedback;
    ComparedKind& row = kinds.emplace_back(
        ComparedKind{.kind = kind, .following_rms_in = best->following_rms_in, .rest_error_in = best->rest_error_in});
    const bool integrates = feedback.ki > 0.0;
    if (!integrates && feedback.kp > 0.0) row.lasting_error_s = 1.0 / feedback.kp;
    load_errors.push_back(integrates ? std::sqrt(ident::squared_load_error(response, feedback)) : 0.0);
    if (kind == FeedbackKind::pid && integrates) of_pid = load_errors.back();
  }
  if (!of_pid || !(*of_pid > 0.0) || !std::isfinite(*of_pid)) return kinds;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (load_errors[i] > 0.0 && std::isfinite(load_errors[i])) kinds[i].load_error_of_pid = load_errors[i] / *of_pid;
  }
  const bool has_fopid =
      std::any_of(kinds.begin(), kinds.end(), [](const ComparedKind& k) { return k.kind == FeedbackKind::fopid; });
  if (fractional_gain && *fractional_gain > 0.0 && !has_fopid) {
    kinds.push_back({.kind = FeedbackKind::fopid, .load_error_of_pid = std::min(1.0, 1.0 / *fractional_gain)});
  }
  return kinds;
}

std::vector<std::string> kind_titles(const DisplayUnit& unit) {
  const std::string in = unit.of("in");
  return {"kind", fmt::format("following, RMS [{}]", in), fmt::format("at rest [{}]", in), "after a load (PID: 1)",
          fmt::format("lasting, load of 1 {}/s [{}]", in, in)};
}

std::vector<std::vector<std::string>> kind_rows(const std::vector<ComparedKind>& kinds, const DisplayUnit& unit) {
  std::vector<std::vector<std::string>> rows;
  if (kinds.size() < 2) return rows;
  const double factor = unit.factor("in");
  const auto length = [&](const std::optional<double>& value_in) {
    return value_in ? fmt::format("{:.3g}", factor * *value_in) : std::string("not tried");
  };
  for (const ComparedKind& k : kinds) {
    const std::string after_load = k.load_error_of_pid       ? fmt::format("{:.2f}", *k.load_error_of_pid)
                                   : k.lasting_error_s > 0.0 ? "stays"
                                                             : "-";
    rows.push_back({name_of(k.kind), length(k.following_rms_in), length(k.rest_error_in), after_load,
                    fmt::format("{:.3g}", k.lasting_error_s)});
  }
  return rows;
}

}  // namespace eha::tune
