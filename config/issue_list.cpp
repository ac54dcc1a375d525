// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/issue_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/error.hpp"

namespace eha::config {
namespace {

// A file of thousands of faults is no experiment; each key is looked for among them all.
constexpr std::size_t kMostIssues = 100;

/// Whether `path` is `key` or a key below it.
bool is_within(std::string_view path, std::string_view key) {
  if (!path.starts_with(key)) return false;
  return path.size() == key.size() || path[key.size()] == '.' || path[key.size()] == '[';
}

}  // namespace

void IssueList::add(Position position, const std::string& key, std::string_view expected, std::string_view got) {
  add_text(position, key, fmt::format("expected {}, got {}", expected, got));
}

void IssueList::add_text(Position position, const std::string& key, std::string_view text) {
  issues_.push_back({position, key, std::string(text)});
  if (issues_.size() == kMostIssues) throw_if_any();
}

bool IssueList::clean(std::string_view key) const {
  return std::none_of(issues_.begin(), issues_.end(), [&](const Issue& issue) { return is_within(issue.key, key); });
}

void IssueList::throw_if_any() const {
  if (issues_.empty()) return;
  std::vector<Issue> sorted = issues_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Issue& a, const Issue& b) {
    return std::tie(a.position.line, a.position.column) < std::tie(b.position.line, b.position.column);
  });
  std::vector<std::string> lines;
  for (const Issue& issue : sorted) {
    lines.push_back(
        fmt::format("{}:{}:{}: {}: {}", file_name_, issue.position.line, issue.position.column, issue.key, issue.text));
  }
  if (issues_.size() == kMostIssues) {
    lines.push_back(fmt::format("{}: the first {} faults that were found; there may be more", file_name_, kMostIssues));
  }
  throw ConfigError(std::move(lines));
}

Position position_of(const PositionMap& positions, std::string_view key) {
  while (true) {
    if (const auto found = positions.find(std::string(key)); found != positions.end()) return found->second;
    const std::size_t cut = key.find_last_of(".[");
    if (cut == std::string_view::npos) return {};
    key = key.substr(0, cut);
  }
}

}  // namespace eha::config
