// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/sample_stream.hpp"

#include <algorithm>
#include <cmath>

namespace eha::play {

void SampleStream::add(const SampleBlock& block) {
  const std::lock_guard lock(mutex_);
  blocks_[next_++ % kKept] = block;
}

std::uint64_t SampleStream::next() const {
  const std::lock_guard lock(mutex_);
  return next_;
}

SampleStream::Part SampleStream::since(std::uint64_t number) const {
  Part part;
  part.blocks.reserve(kKept);  // not while a writer waits
  const std::lock_guard lock(mutex_);
  const std::uint64_t oldest = next_ > kKept ? next_ - kKept : 0;
  part.first = std::min(std::max(number, oldest), next_);
  part.lost = number < oldest ? oldest - number : 0;
  for (std::uint64_t i = part.first; i < next_; ++i) part.blocks.push_back(blocks_[i % kKept]);
  return part;
}

void BlockMaker::add(const Sample& sample) {
  const std::int64_t number = sample.time_ns / kBlock_ns;
  if (number != number_) finish();
  number_ = number;
  block_.utc_ns = sample.utc_ns;
  if (kind_ == Kind::run) block_.run_s = static_cast<double>(sample.time_ns) * 1e-9;
  // fmin and fmax ignore a NaN.
  block_.displacement_min_in = std::fmin(block_.displacement_min_in, sample.displacement_in);
  block_.displacement_max_in = std::fmax(block_.displacement_max_in, sample.displacement_in);
  block_.applied_min_V = std::fmin(block_.applied_min_V, sample.applied_V);
  block_.applied_max_V = std::fmax(block_.applied_max_V, sample.applied_V);
}

void BlockMaker::finish() {
  if (number_ >= 0) stream_.add(block_);
  number_ = -1;
  block_ = {};
}

}  // namespace eha::play
