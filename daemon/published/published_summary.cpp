// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/published_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "ident/validation/verdict.hpp"

namespace eha::published {

std::vector<Line> ranked(const StudiedSet& studied, const ScoredTest& scored) {
  std::vector<Line> lines;
  for (const Figure& figure : scored.test->figures) {
    lines.push_back({figure.value, std::string(figure.method), std::string(figure.source)});
  }
  lines.push_back({.value = scored.score, .method = "eha, " + studied.model->name, .source = {}, .is_ours = true});
  const bool greater_is_better = scored.test->measure.greater_is_better;
  std::stable_sort(lines.begin(), lines.end(), [&](const Line& a, const Line& b) {
    if (std::isfinite(a.value) != std::isfinite(b.value)) return std::isfinite(a.value);
    return greater_is_better ? a.value > b.value : a.value < b.value;
  });
  return lines;
}

std::string heading(const ScoredTest& scored) {
  const Test& test = *scored.test;
  std::string text = fmt::format("{}{} of {} rows", test.measure.name,
                                 test.unit.empty() ? "" : fmt::format(" [{}]", test.unit), scored.measured.size());
  if (scored.is_of_estimating_rows) text += "; these rows estimated the model";
  if (scored.with_start_fitted) {
    text += fmt::format("; {:.4g} with a start fitted to all of them, which is no score", *scored.with_start_fitted);
  }
  return text;
}

std::string model_line(const StudiedSet& studied) {
  const ident::Model& model = *studied.model;
  return fmt::format("{} ({}){}, estimated from {} rows in {:.3g} s", model.name,
                     model.verdict ? ident::verdict_word(*model.verdict) : "not judged",
                     studied.is_recommended ? ", recommended" : ", recommended only without the limit on R2",
                     studied.estimating_rows, studied.seconds);
}

std::string absence(const StudiedSet& studied) {
  return fmt::format("{}; from {}", fmt::join(studied.missing_files, ", "), studied.set->fetch);
}

}  // namespace eha::published
