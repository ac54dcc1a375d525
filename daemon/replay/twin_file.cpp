// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/replay/twin_file.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "core/millimetre_key.hpp"
#include "core/text.hpp"

namespace eha::replay {
namespace {

constexpr std::size_t kLongestOrigin = 100;

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::string line_of(const CalibratedParameter& p) {
  return fmt::format("{} = {:.6g}  # calibrated: +- {:.2g} (95 %), was {:g}", p.key, p.value, p.half_width, p.before);
}

}  // namespace

std::string twin_text(std::string_view text, const Calibration& calibration, std::string_view origin) {
  std::string out = fmt::format("# Calibrated with {}: rms error {:.3g} in\n", shortened(origin, kLongestOrigin),
                                calibration.rms_error_in);
  std::vector<std::pair<std::string, std::string>> lines_of;
  for (const CalibratedParameter& p : calibration.parameters) lines_of.emplace_back(p.key, line_of(p));
  lines_of.emplace_back("sub_step_us", fmt::format("sub_step_us = {:g}  # longest integration step [us]",
                                                   calibration.options.sub_step_us));
  std::vector<bool> written(lines_of.size(), false);
  const auto missing = [&] {
    std::string lines;
    for (std::size_t i = 0; i < written.size(); ++i) {
      if (!written[i]) lines += lines_of[i].second + "\n";
    }
    return lines;
  };
  bool in_sim = false;
  std::size_t head = std::string::npos;  // after the line [sim]
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::string content = trimmed(line);
    std::string kept(line);
    if (content.starts_with("[")) in_sim = content.starts_with("[sim]");
    if (in_sim) {
      const std::string key = trimmed(content.substr(0, content.find('=')));
      for (std::size_t i = 0; i < written.size(); ++i) {
        // The old line may have the key in millimetres.
        const auto other = millimetre_key(lines_of[i].first);
        if (key != lines_of[i].first && !(other && key == other->name)) continue;
        kept = lines_of[i].second;
        written[i] = true;
      }
    }
    out += kept + "\n";
    if (in_sim && head == std::string::npos) head = out.size();
  }
  if (head == std::string::npos) return out + "\n[sim]\n" + missing();
  out.insert(head, missing());
  return out;
}

}  // namespace eha::replay
