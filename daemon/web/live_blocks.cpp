// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/live_blocks.hpp"

#include <algorithm>

namespace eha::web {

using Json = nlohmann::ordered_json;

void LiveBlocks::add(const Json& samples) {
  next_ += samples.at("lost").get<std::int64_t>();
  for (const Json& block : samples.at("blocks")) {
    const auto utc_ns = block.at(0).get<std::int64_t>();
    const Json row = Json::array({block.at(1), block.at(2), block.at(3), block.at(4), block.at(5), block.at(0)});
    blocks_.push_back({next_++, utc_ns, row.dump()});
  }
  while (!blocks_.empty() && (blocks_.size() > kMost || blocks_.back().utc_ns - blocks_.front().utc_ns > kKept_ns)) {
    blocks_.pop_front();
  }
}

LiveBlocks::Part LiveBlocks::since(std::int64_t since) const {
  const bool is_known = since >= 0 && since <= next_;
  const auto begin = std::partition_point(blocks_.begin(), blocks_.end(),
                                          [&](const Block& block) { return is_known && block.number < since; });
  Part part{.first = begin == blocks_.end() ? next_ : begin->number, .next = next_, .blocks = "["};
  for (auto block = begin; block != blocks_.end(); ++block) {
    if (block != begin) part.blocks += ',';
    part.blocks += block->row;
  }
  part.blocks += ']';
  if (is_known) part.dropped = next_ - since - (blocks_.end() - begin);
  return part;
}

}  // namespace eha::web
