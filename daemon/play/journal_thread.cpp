// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/journal_thread.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "daemon/acquisition/fatal_signals.hpp"

namespace eha::play {
namespace {

using acquisition::RecordQueue;
using acquisition::TimeBase;

constexpr auto kSynchronise = std::chrono::seconds(1);
constexpr auto kPollMonotonic = std::chrono::milliseconds(10);
constexpr auto kPollVirtual = std::chrono::microseconds(200);

std::int64_t utc_now_ns() {
  using std::chrono::nanoseconds;
  return std::chrono::duration_cast<nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

JournalThread::JournalThread(RecordQueue& queue, record::JournalWriter& journal, const record::FolderWatch& folder,
                             TimeBase time_base, RunWatch& watch)
    : queue_(queue),
      journal_(journal),
      folder_(folder),
      time_base_(time_base),
      watch_(watch),
      batch_(RecordQueue::kCapacity / 8),
      thread_([this] { run(); }) {
  pthread_setname_np(thread_.native_handle(), "eha-writer");
}

bool JournalThread::hangs() {
  const std::uint64_t turns = watch_.writer_turns.load(std::memory_order_relaxed);
  const auto now = std::chrono::steady_clock::now();
  if (turns != turns_seen_) {
    turns_seen_ = turns;
    turned_ = now;
  }
  return time_base_ == TimeBase::monotonic && now - turned_ > kWriterPatience;
}

std::string JournalThread::finish() {
  loop_ended_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
  if (!error_.empty() || (write_error_.empty() && room_error_.empty())) return error_;
  if (!room_error_.empty() && journal_is_sound()) {
    return room_error_ + ": the run was ended while its last rows had room, and every row is kept";
  }
  if (journal_is_sound()) return write_error_ + ": the run was ended; later this worked, and every row is kept";
  return fmt::format("{}: the {} rows before are kept, as far as they reached the disk; {} later ones are lost",
                     write_error_, journal_.rows(), journal_.pending());
}

void JournalThread::run() {
  acquisition::block_all_but_fatal_signals();
  const acquisition::SignalStack signal_stack;
  if (watch_.samples != nullptr) blocks_.emplace(*watch_.samples, BlockMaker::Kind::run);
  for (;;) {
    watch_.writer_turns.fetch_add(1, std::memory_order_relaxed);
    const bool was_last = loop_ended_.load(std::memory_order_acquire);
    const std::size_t count = queue_.pop(batch_.data(), batch_.size());
    if (blocks_) show(count);
    write(count);
    if (!queue_.writer_failed()) keep_room();
    if (error_.empty()) look_at_folder();
    if (count > 0) continue;
    if (was_last) break;
    if (time_base_ == TimeBase::monotonic) {
      std::this_thread::sleep_for(kPollMonotonic);
    } else {
      std::this_thread::sleep_for(kPollVirtual);
    }
  }
  if (blocks_) blocks_->finish();
}

void JournalThread::show(std::size_t count) {
  if (count == 0) return;
  // The newest record is younger than one period, because the thread takes all available ones.
  const std::int64_t now_ns = utc_now_ns();
  const std::int64_t newest_ns = batch_[count - 1].scheduled_ns;
  for (std::size_t i = 0; i < count; ++i) {
    const acquisition::TickRecord& tick = batch_[i];
    const std::int64_t age_ns = time_base_ == TimeBase::monotonic ? newest_ns - tick.scheduled_ns : 0;
    blocks_->add({tick.scheduled_ns, now_ns - age_ns, tick.displacement_in, tick.applied_V});
  }
}

void JournalThread::write(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) played_ += batch_[i].state == acquisition::State::running ? 1U : 0U;
  try {
    if (count > 0 || !is_written_) journal_.append({batch_.data(), count});
    is_written_ = true;
    keep_fault(count);
    synchronise();
  } catch (const std::exception& error) {
    is_written_ = false;
    if (write_error_.empty()) write_error_ = error.what();
    queue_.report_writer_failure();
  }
  // The last rows may wait for their block to be full.
  watch_.journal_rows.store(played_ - std::min(played_, journal_.pending()), std::memory_order_release);
}

void JournalThread::keep_fault(std::size_t count) {
  if (has_fault_ || count == 0 || batch_[count - 1].fault == acquisition::Fault::none) return;
  journal_.write_pending();
  has_fault_ = true;
  synchronised_ = {};  // at once
}

void JournalThread::synchronise() {
  // A run in virtual time can be repeated, so it is synchronised to the disk once, at its end.
  const auto now = std::chrono::steady_clock::now();
  if (time_base_ != TimeBase::monotonic || !is_synchronised_ || now - synchronised_ < kSynchronise) return;
  try {
    journal_.synchronise();
    synchronised_ = now;
  } catch (const std::exception& error) {
    is_synchronised_ = false;  // which rows are on the disk is not known
    if (write_error_.empty()) write_error_ = error.what();
    queue_.report_writer_failure();
  }
}

void JournalThread::keep_room() {
  try {
    journal_.keep_room();
  } catch (const std::exception& error) {
    room_error_ = error.what();
    queue_.report_writer_failure();
  }
}

void JournalThread::look_at_folder() {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_ < kFolderInterval) return;
  looked_ = now;
  try {
    folder_.check(journal_.rows());
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

void JournalThread::fail(std::string message) {
  if (error_.empty()) error_ = std::move(message);
  queue_.report_writer_failure();
}

}  // namespace eha::play
