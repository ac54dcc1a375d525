// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/daemon_feed.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "daemon/acquisition/tick_record.hpp"
#include "daemon/control/client.hpp"

namespace eha::web {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;
using std::chrono::steady_clock;

constexpr auto kRetry = 500ms;
constexpr auto kEventPatience = 200ms;
constexpr auto kQueueInterval = 1s;
constexpr auto kStateInterval = 100ms;
/// Number of finished experiments that are passed on, the newest: an entry with its models has some kilobytes.
constexpr int kMostOver = 50;
/// An ehad that is silent for this long is shown as lost.
constexpr auto kSilence = 2s;

std::string text_of(const Json& document) { return document.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string lost_text(const std::string& why) {
  return text_of({{"daemon", "lost"},
                  {"reason", why},
                  {"status", nullptr},
                  {"units", "in"},
                  {"limits", nullptr},
                  {"queue", Json::array()},
                  {"queue_left_out", 0},
                  {"version", EHA_VERSION}});
}

/// @param queue  the answer to `queue`
std::string state_text(const Json& status, const Json& queue) {
  Json limits = status.at("rig").value("limits", Json());
  if (limits.is_object()) limits["warning_share"] = acquisition::kWarningShare;
  Json shown = status;
  shown.erase("samples");
  return text_of({{"daemon", "connected"},
                  {"status", std::move(shown)},
                  {"units", status.at("rig").value("units", "in")},
                  {"limits", std::move(limits)},
                  {"queue", queue.at("entries")},
                  {"queue_left_out", queue.at("left_out")},
                  {"version", EHA_VERSION}});
}

}  // namespace

DaemonFeed::DaemonFeed(std::filesystem::path socket, OnRuns on_runs)
    : socket_(std::move(socket)),
      on_runs_(std::move(on_runs)),
      lost_state_(std::make_shared<const std::string>(lost_text("ehad has not been reached yet"))),
      silent_state_(std::make_shared<const std::string>(lost_text("ehad is connected, but says nothing"))),
      thread_([this] { follow(); }) {
  pthread_setname_np(thread_.native_handle(), "eha-web-feed");
}

DaemonFeed::~DaemonFeed() {
  stopping_ = true;
  thread_.join();
}

std::shared_ptr<const std::string> DaemonFeed::state() const {
  const std::lock_guard lock(mutex_);
  if (!state_) return lost_state_;
  return steady_clock::now() - heard_ < kSilence ? state_ : silent_state_;
}

std::string DaemonFeed::live(std::int64_t since) const {
  const auto now =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch());
  const std::lock_guard lock(mutex_);
  const LiveBlocks::Part part = blocks_.since(since);
  const Json run = run_.id.empty() ? Json(nullptr) : Json(run_.id);
  return fmt::format(R"({{"first":{},"next":{},"dropped":{},"run":{},"now_ns":{},"blocks":{}}})", part.first, part.next,
                     part.dropped, text_of(run), now.count(), part.blocks);
}

DaemonFeed::Run DaemonFeed::run() const {
  const std::lock_guard lock(mutex_);
  return run_;
}

void DaemonFeed::follow() {
  std::string last;
  while (!stopping_) {
    try {
      follow_once();
    } catch (const std::exception& error) {
      if (last != error.what()) spdlog::warn("{}", error.what());
      last = error.what();
      lose(last);
    }
    std::this_thread::sleep_for(kRetry);
  }
}

void DaemonFeed::follow_once() {
  control::Client events(socket_, kSilence);
  // Uses another connection, because on the first one an answer would interrupt the events.
  control::Client questions(socket_, kSilence);
  if (on_runs_) on_runs_(questions.call("runs").at("folder").get<std::string>());
  events.call("watch", {{"rate_Hz", control::kFastestWatch_Hz}, {"samples", true}});
  spdlog::info("following ehad {} at {}", events.version(), socket_.string());
  Json queue{{"entries", Json::array()}, {"left_out", 0}};
  steady_clock::time_point next_queue{};
  steady_clock::time_point next_state{};
  while (!stopping_) {
    const std::optional<Json> status = events.next_event(kEventPatience);
    if (!status) continue;
    const auto now = steady_clock::now();
    if (now >= next_queue) {
      queue = questions.call("queue", {{"over", kMostOver}});
      next_queue = now + kQueueInterval;
    }
    {
      const std::lock_guard lock(mutex_);
      blocks_.add(status->at("samples"));
      heard_ = now;
    }
    if (now < next_state) continue;
    next_state = now + kStateInterval;
    take(*status, queue);
  }
}

void DaemonFeed::take(const Json& status, const Json& queue) {
  auto text = std::make_shared<const std::string>(state_text(status, queue));
  Run run;
  if (const Json& playing = status.at("run"); playing.is_object()) {
    run.id = playing.value("run", "");
    run.experiment_s = playing.value("experiment_s", 0.0);
  }
  const std::lock_guard lock(mutex_);
  state_ = std::move(text);
  run_ = std::move(run);
}

void DaemonFeed::lose(const std::string& why) {
  auto text = std::make_shared<const std::string>(lost_text(why));
  const std::lock_guard lock(mutex_);
  state_.reset();
  lost_state_ = std::move(text);
  run_ = {};
}

}  // namespace eha::web
