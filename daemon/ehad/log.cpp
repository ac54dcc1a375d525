// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/log.hpp"

#include <spdlog/async.h>
#include <spdlog/async_logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "core/terminal_text.hpp"
#include "daemon/acquisition/fatal_signals.hpp"

namespace eha::service {
namespace {

constexpr std::size_t kMostQueued = 1024;  // messages
constexpr std::size_t kLongestLine = 4000;

/// Returns the text as one line. A client's text may contain newlines, after which it could imitate other messages.
std::string line_of(std::string_view text) {
  std::string line;
  for (const char c : text.substr(0, kLongestLine)) line += c == '\n' ? std::string(" | ") : std::string(1, c);
  if (text.size() > kLongestLine) line += "...";
  return one_line(line);
}

/// Writes to standard error, and counts the flushes that reached it.
class ErrorSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  [[nodiscard]] std::uint64_t flushes() const noexcept { return flushes_.load(); }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string line = line_of({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg clean = message;
    clean.payload = line;
    spdlog::memory_buf_t text;
    formatter_->format(clean, text);
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t count = write(STDERR_FILENO, text.data() + sent, text.size() - sent);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return;
      sent += static_cast<std::size_t>(count);
    }
  }
  void flush_() override { flushes_.fetch_add(1); }

 private:
  std::atomic<std::uint64_t> flushes_{0};
};

/// The sink of the default logger; none before set_up_log().
std::shared_ptr<ErrorSink>& sink() {
  static std::shared_ptr<ErrorSink> instance;
  return instance;
}

/// Writes a level as the number of syslog(3).
class JournalLevel final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& text) override {
    text.push_back('<');
    text.push_back(number(message.level));
    text.push_back('>');
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JournalLevel>();
  }

 private:
  static char number(spdlog::level::level_enum level) {
    switch (level) {
      case spdlog::level::critical:
        return '2';
      case spdlog::level::err:
        return '3';
      case spdlog::level::warn:
        return '4';
      case spdlog::level::info:
        return '6';
      default:
        return '7';
    }
  }
};

/// Whether standard error is the journal's: JOURNAL_STREAM is its device and inode, see systemd.exec(5).
bool is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat facts {};
  if (stream == nullptr || fstat(STDERR_FILENO, &facts) != 0) return false;
  return std::to_string(facts.st_dev) + ":" + std::to_string(facts.st_ino) == stream;
}

}  // namespace

void set_up_log() {
  spdlog::init_thread_pool(kMostQueued, 1, [] {
    acquisition::block_all_but_fatal_signals();
    pthread_setname_np(pthread_self(), "eha-log");
  });
  sink() = std::make_shared<ErrorSink>();
  auto logger = std::make_shared<spdlog::async_logger>("ehad", sink(), spdlog::thread_pool(),
                                                       spdlog::async_overflow_policy::overrun_oldest);
  if (is_journal()) {
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<JournalLevel>('*').set_pattern("%*%v");
    logger->set_formatter(std::move(formatter));
  } else {
    logger->set_pattern("ehad: %l: %v");
  }
  spdlog::set_default_logger(std::move(logger));
}

void report_dropped_messages() {
  static std::size_t reported = 0;
  const auto pool = spdlog::thread_pool();
  if (!pool || pool->queue_size() > kMostQueued / 2) return;
  const std::size_t dropped = pool->overrun_counter();
  if (dropped == reported) return;
  spdlog::warn("{} log messages were dropped because standard error was not read fast enough", dropped - reported);
  reported = dropped;
}

bool flush_log(std::chrono::milliseconds limit) {
  if (!sink()) return true;
  const std::uint64_t before = sink()->flushes();
  spdlog::default_logger()->flush();
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (sink()->flushes() == before) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace eha::service
