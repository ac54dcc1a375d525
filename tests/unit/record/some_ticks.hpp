// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "daemon/acquisition/tick_record.hpp"

namespace eha::record {

/// Ticks with every member different from row to row: 3 before the experiment, `rows` of it, 2 after it.
inline std::vector<acquisition::TickRecord> some_ticks(std::size_t rows, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::vector<acquisition::TickRecord> ticks(rows + 5);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    acquisition::TickRecord& tick = ticks[k];
    tick.sequence = static_cast<std::uint32_t>(k);
    tick.scheduled_ns = static_cast<std::int64_t>(k) * 1'000'000;
    tick.lateness_ns = static_cast<std::int32_t>(random() % 100'000);
    tick.execution_ns = static_cast<std::uint32_t>(random() % 100'000);
    tick.feedback_code = static_cast<std::uint32_t>(random());
    tick.command_code = static_cast<std::uint32_t>(random());
    tick.digital_inputs = static_cast<std::uint32_t>(random());
    tick.flags = static_cast<std::uint16_t>(random() % 2);
    tick.state = k < 3          ? acquisition::State::ramp_in
                 : k < rows + 3 ? acquisition::State::running
                                : acquisition::State::ramp_out;
    tick.repetition = tick.state == acquisition::State::running ? 1 : 0;
    tick.requested_V = static_cast<double>(random()) * 1e-19;
    tick.applied_V = static_cast<double>(random()) * 1e-19;
    tick.displacement_in = static_cast<double>(random()) * 1e-19;
  }
  return ticks;
}

/// Whether two sequences of ticks are the same to the bit, NaN included.
inline bool same_bits(const std::vector<acquisition::TickRecord>& a, const std::vector<acquisition::TickRecord>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(acquisition::TickRecord)) == 0);
}

}  // namespace eha::record
