// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/status_board.hpp"

namespace eha::service {

/// Sums over the runs since the service started.
struct Totals {
  std::uint64_t ticks = 0;
  std::uint64_t late = 0;
  std::uint64_t skipped = 0;
  std::uint64_t dropped = 0;
  std::int64_t latency_max_ns = 0;
  std::array<std::uint64_t, acquisition::kOutcomes.size()> runs{};  ///< by acquisition::Outcome
  std::uint64_t worker_failures = 0;

  void add(const acquisition::RunReport& report);
};

/// The service's present state.
struct MetricsFacts {
  acquisition::State state = acquisition::State::faulted;
  std::size_t waiting = 0;  ///< held ones included
  std::size_t held = 0;
  std::optional<double> lease_remaining_s;
  bool worker_busy = false;
  std::optional<acquisition::Snapshot> snapshot;  ///< of the present run
};

/// Writes the metrics in the text format of Prometheus (version 0.0.4), each with HELP and TYPE.
[[nodiscard]] std::string metrics_text(const Totals& totals, const MetricsFacts& facts);

}  // namespace eha::service
