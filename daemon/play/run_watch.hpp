// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>

#include "daemon/acquisition/status_board.hpp"
#include "daemon/play/sample_stream.hpp"

namespace eha::play {

/// The state of a run in progress, for a watchdog and for displays. Thread-safe to read at any time.
struct RunWatch {
  enum class Phase : std::uint8_t {
    preparing,  ///< the rig is not driven yet
    playing,    ///< the board changes every tick, and the writer's count several times a second
    draining,   ///< the loop has ended, the writer has not
    closing,    ///< the files are made from the journal; this takes longer for a longer record
  };
  acquisition::StatusBoard board;
  std::atomic<Phase> phase{Phase::preparing};
  std::atomic<std::uint64_t> writer_turns{0};  ///< grows unless the writer hangs in a call on the disk
  std::atomic<std::uint64_t> journal_rows{0};  ///< of the experiment, in the journal
  SampleStream* samples = nullptr;  ///< receives the run's samples; must outlive the run; none: nobody follows
};

}  // namespace eha::play
