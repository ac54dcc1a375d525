// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/record_labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <map>
#include <set>

namespace eha::batch {
namespace {

constexpr std::array kParts{&RecordParts::rig, &RecordParts::name, &RecordParts::folder};

constexpr std::size_t kStampLength = 16;  // "20261129T105158Z"

bool begins_with_stamp(const std::string& name) {
  if (name.size() < kStampLength || name[8] != 'T' || name[kStampLength - 1] != 'Z') return false;
  for (std::size_t i = 0; i < kStampLength - 1; ++i) {
    if (i != 8 && std::isdigit(static_cast<unsigned char>(name[i])) == 0) return false;
  }
  return true;
}

/// @param used  one bit for each of kParts
std::string joined(const RecordParts& record, std::size_t used) {
  std::string text;
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    const std::string& part = record.*kParts.at(i);
    if ((used >> i & 1U) != 0U && !part.empty()) text += (text.empty() ? "" : " ") + part;
  }
  return text.empty() ? record.name : text;
}

std::vector<std::string> joined(const std::vector<RecordParts>& records, std::size_t used) {
  std::vector<std::string> labels;
  for (const RecordParts& record : records) labels.push_back(joined(record, used));
  return labels;
}

std::map<std::string, std::size_t> counts_of(const std::vector<std::string>& labels) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& label : labels) ++counts[label];
  return counts;
}

/// "10:51:58", with the day before it where the records are not all of one: "2026-11-29 10:51:58".
std::string clock_of(const std::string& stamp, bool is_one_day) {
  const std::string clock = fmt::format("{}:{}:{}", stamp.substr(9, 2), stamp.substr(11, 2), stamp.substr(13, 2));
  return is_one_day ? clock
                    : fmt::format("{}-{}-{} {}", stamp.substr(0, 4), stamp.substr(4, 2), stamp.substr(6, 2), clock);
}

}  // namespace

RecordParts parts_of(const std::string& source, const std::string& rig) {
  std::filesystem::path path = std::filesystem::path(source).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  RecordParts parts{.name = path.filename().string(), .rig = rig, .folder = path.parent_path().filename().string()};
  if (begins_with_stamp(parts.name)) {
    parts.time = parts.name.substr(0, kStampLength);
    if (parts.name.size() > kStampLength + 1) parts.name = parts.name.substr(kStampLength + 1);
  } else if (rig.empty()) {
    parts.name = path.stem().string();
  }
  return parts;
}

std::vector<std::string> labels_of(const std::vector<RecordParts>& records) {
  constexpr std::size_t kName = 0b010;
  std::size_t best = kName;
  const auto told = [&](std::size_t used) { return counts_of(joined(records, used)).size(); };
  const auto parts_in = [](std::size_t used) { return (used & 1U) + (used >> 1U & 1U) + (used >> 2U & 1U); };
  for (std::size_t used = 1; used < (1U << kParts.size()); ++used) {
    const std::size_t more = told(used);
    const std::size_t known = told(best);
    if (more > known || (more == known && parts_in(used) < parts_in(best))) best = used;
  }
  std::vector<std::string> labels = joined(records, best);
  std::set<std::string> days;
  for (const RecordParts& record : records) {
    if (!record.time.empty()) days.insert(record.time.substr(0, 8));
  }
  const auto alike = counts_of(labels);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (alike.at(labels[i]) > 1 && !records[i].time.empty()) {
      labels[i] += " " + clock_of(records[i].time, days.size() == 1);
    }
  }
  const auto still_alike = counts_of(labels);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (still_alike.at(labels[i]) > 1) labels[i] += fmt::format(" (no. {})", i + 1);
  }
  return labels;
}

}  // namespace eha::batch
