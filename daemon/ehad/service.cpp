// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/service.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <type_traits>
#include <variant>

#include "core/error.hpp"
#include "daemon/ehad/log.hpp"

namespace eha::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPollInterval = 200ms;
constexpr auto kSweepInterval = 1000ms;

os::FileDescriptor open_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGCHLD}) sigaddset(&signals, number);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  os::FileDescriptor descriptor(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!descriptor) throw IoError("cannot listen for signals: " + error_text(errno));
  return descriptor;
}

/// Writes the member `samples` of ehad-protocol(7). NaN becomes null.
Json samples_json(const play::SampleStream::Part& part) {
  Json blocks = Json::array();
  for (const play::SampleBlock& block : part.blocks) {
    blocks.push_back({block.utc_ns, block.run_s, block.displacement_min_in, block.displacement_max_in,
                      block.applied_min_V, block.applied_max_V});
  }
  return {{"first", part.first},
          {"lost", part.lost},
          {"block_s", static_cast<double>(play::kBlock_ns) * 1e-9},
          {"blocks", std::move(blocks)}};
}

/// Whether a method changes nothing; such requests are logged at level debug.
bool is_read_only(const control::Call& call) {
  return std::holds_alternative<control::StatusCall>(call) || std::holds_alternative<control::WatchCall>(call) ||
         std::holds_alternative<control::QueueCall>(call) || std::holds_alternative<control::RunsCall>(call) ||
         std::holds_alternative<control::MetricsCall>(call);
}

}  // namespace

Service::Service(const Options& options)
    : signals_(open_signals()),
      supervisor_(options, loop_, notifier_),
      server_(
          loop_, options.socket, control::ServerLimits{},
          [this](const control::Peer& peer, const control::Request& request) { on_request(peer, request); },
          [this](control::ClientId client) {
            watchers_.erase(client);
            supervisor_.client_gone(client);
          },
          [this](uid_t uid) { return names_.name(uid); }) {
  loop_.add(signals_.get(), EPOLLIN, [this](std::uint32_t) { on_signal(); });
  spdlog::info("listening at {}; the rig is not armed", options.socket.string());
}

Service::~Service() { loop_.remove(signals_.get()); }

void Service::run() {
  notifier_.ready();
  while (!supervisor_.is_over()) {
    loop_.run_once(time_to_next(Clock::now()));
    const Clock::time_point now = Clock::now();
    if (now >= next_poll_) {
      supervisor_.poll(now);
      next_poll_ = now + kPollInterval;
    }
    if (now >= next_sweep_) {
      server_.sweep(now);
      report_dropped_messages();
      next_sweep_ = now + kSweepInterval;
    }
    feed_watchers(now);
  }
  // Clients that wait for their run receive its end.
  feed_watchers(Clock::time_point::max());
  spdlog::info("stopped");
}

std::chrono::milliseconds Service::time_to_next(Clock::time_point now) const {
  Clock::time_point next = std::min(next_poll_, next_sweep_);
  for (const auto& [client, watcher] : watchers_) next = std::min(next, watcher.due);
  return std::clamp(std::chrono::ceil<std::chrono::milliseconds>(next - now), 0ms, 1000ms);
}

void Service::on_signal() {
  signalfd_siginfo info{};
  while (read(signals_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
    switch (info.ssi_signo) {
      case SIGCHLD:
        supervisor_.poll_worker();
        break;
      case SIGHUP:
        reload_on_signal();
        break;
      default:
        supervisor_.shut_down();
    }
  }
}

void Service::reload_on_signal() {
  const auto report = [](const std::exception& error) { spdlog::warn("SIGHUP: {}", error.what()); };
  try {
    supervisor_.reload(std::nullopt, [report](const std::function<Json()>& result) {
      try {
        static_cast<void>(result());
      } catch (const std::exception& error) {
        report(error);
      }
    });
  } catch (const std::exception& error) {
    report(error);
  }
}

void Service::on_request(const control::Peer& peer, const control::Request& request) {
  if (!is_read_only(request.call)) {
    audit(peer, fmt::format("{} by {} (uid {}, pid {})", request.method, peer.user, peer.uid, peer.pid));
  }
  try {
    dispatch(peer, request);
  } catch (const Error& error) {
    audit(peer, fmt::format("{} by {} (uid {}, pid {}) refused: {}", request.method, peer.user, peer.uid, peer.pid,
                            error.what()));
    server_.refuse(peer.client, request.id, error.exit_code(), error.what());
  }
}

void Service::audit(const control::Peer& peer, const std::string& text) {
  const std::optional<std::size_t> left_out = audit_.take(peer.uid, Clock::now());
  if (!left_out) return;
  if (*left_out > 0) {
    spdlog::warn("{} log lines on requests of {} (uid {}) were left out: too many", *left_out, peer.user, peer.uid);
  }
  spdlog::info("{}", text);
}

void Service::dispatch(const control::Peer& peer, const control::Request& request) {
  const auto now = [&](const Json& result) { server_.respond(peer.client, request.id, result); };
  const Supervisor::Answer later = [this, peer, id = request.id](const std::function<Json()>& result) {
    answer(peer, id, [&] { server_.respond(peer.client, id, result()); });
  };
  const Supervisor::TextAnswer text_later = [this, peer, id = request.id](const auto& result) {
    answer(peer, id, [&] { server_.respond(peer.client, id, result()); });
  };
  std::visit(
      [&](const auto& call) {
        using T = std::decay_t<decltype(call)>;
        if constexpr (std::is_same_v<T, control::StatusCall>) now(supervisor_.status());
        if constexpr (std::is_same_v<T, control::ArmCall>) supervisor_.arm(peer, call, later);
        if constexpr (std::is_same_v<T, control::DisarmCall>) now(supervisor_.disarm(peer));
        if constexpr (std::is_same_v<T, control::SubmitCall>) supervisor_.submit(peer, call, later);
        if constexpr (std::is_same_v<T, control::StopCall>) now(supervisor_.stop(peer, call));
        if constexpr (std::is_same_v<T, control::CancelCall>) supervisor_.cancel(peer, call.entry, later);
        if constexpr (std::is_same_v<T, control::WatchCall>) watch(peer, request.id, call);
        if constexpr (std::is_same_v<T, control::QueueCall>) now(supervisor_.queue(call.over));
        if constexpr (std::is_same_v<T, control::HoldCall>) now(supervisor_.hold(peer, call.entry));
        if constexpr (std::is_same_v<T, control::MoveCall>) supervisor_.move(peer, call, later);
        if constexpr (std::is_same_v<T, control::ReleaseCall>) now(supervisor_.release(peer, call.entry));
        if constexpr (std::is_same_v<T, control::RunsCall>) supervisor_.runs(text_later);
        if constexpr (std::is_same_v<T, control::AckCall>) supervisor_.acknowledge(peer, call.run, later);
        if constexpr (std::is_same_v<T, control::RemoveCall>) supervisor_.remove(peer, call.run, later);
        if constexpr (std::is_same_v<T, control::MetricsCall>) now({{"text", supervisor_.metrics()}});
        if constexpr (std::is_same_v<T, control::ReloadCall>) supervisor_.reload(peer, later);
      },
      request.call);
}

void Service::answer(const control::Peer& peer, std::int64_t id, const std::function<void()>& respond) {
  try {
    respond();
  } catch (const Error& error) {
    audit(peer, fmt::format("request of {} (uid {}, pid {}) refused: {}", peer.user, peer.uid, peer.pid, error.what()));
    server_.refuse(peer.client, id, error.exit_code(), error.what());
  } catch (const std::exception& error) {
    spdlog::critical("internal error: {}", error.what());
    server_.refuse(peer.client, id, ExitCode::bug, error.what());
  }
}

void Service::watch(const control::Peer& peer, std::int64_t id, const control::WatchCall& call) {
  if (call.entry && supervisor_.entry(*call.entry).is_null()) {
    throw UsageError("experiment " + std::to_string(*call.entry) + ": not in the queue");
  }
  const auto interval = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(1.0 / std::max(call.rate_Hz, 1e-3)));
  watchers_[peer.client] = {id, interval, Clock::now(), call.entry,
                            call.samples ? std::optional(supervisor_.samples().next()) : std::nullopt};
  server_.respond(peer.client, id, {{"rate_Hz", call.rate_Hz}});
}

void Service::feed_watchers(Clock::time_point now) {
  std::optional<Json> status;
  for (auto item = watchers_.begin(); item != watchers_.end();) {
    auto& [client, watcher] = *item;
    const bool is_last = watcher.entry && supervisor_.entry_is_over(*watcher.entry);
    if (now < watcher.due && !is_last) {
      ++item;
      continue;
    }
    if (!status) status = supervisor_.status();
    Json snapshot = *status;
    if (watcher.entry) {
      snapshot["entry"] = supervisor_.entry(*watcher.entry);
      snapshot["last"] = is_last;
    }
    std::uint64_t next_block = 0;
    if (watcher.next_block) {
      const play::SampleStream::Part part = supervisor_.samples().since(*watcher.next_block);
      snapshot["samples"] = samples_json(part);
      next_block = part.first + part.blocks.size();
    }
    // A slow reader misses snapshots, but never the last one. Blocks of samples wait for it while they are kept.
    const bool was_sent = server_.stream(client, control::event_line(watcher.id, snapshot),
                                         is_last ? control::Delivery::always : control::Delivery::when_read);
    if (watcher.next_block && was_sent) watcher.next_block = next_block;
    // Keeps its own grid unless it fell behind.
    watcher.due = std::max(watcher.due + watcher.interval, Clock::now());
    item = is_last ? watchers_.erase(item) : std::next(item);
  }
}

}  // namespace eha::service
