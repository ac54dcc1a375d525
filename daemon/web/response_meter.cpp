// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/response_meter.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"

namespace eha::web {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;
using std::chrono::steady_clock;

constexpr auto kInterval = 1s;
/// A client is present if it asked within this time.
constexpr auto kInterest = 3s;

void take_lowest_priority() noexcept {
  // If it is refused, the unit's settings apply (Nice=, CPUSchedulingPolicy=).
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19);
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);
}

record::RunHeader header_of(const RunStore& store, const std::string& run) {
  return record::read_run_header(parse_json_text<Json>(store.manifest(run)), run + "/run.json");
}

}  // namespace

ResponseMeter::ResponseMeter(const RunStore& store, const DaemonFeed& feed)
    : store_(store),
      feed_(feed),
      text_(std::make_shared<const std::string>(R"({"run":null})")),
      thread_([this] { work(); }) {
  pthread_setname_np(thread_.native_handle(), "eha-web-meter");
}

ResponseMeter::~ResponseMeter() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::shared_ptr<const std::string> ResponseMeter::ask() {
  const std::lock_guard lock(mutex_);
  const auto now = steady_clock::now();
  if (now - asked_ > kInterest) wake_.notify_all();
  asked_ = now;
  return text_;
}

void ResponseMeter::work() {
  take_lowest_priority();
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    wake_.wait(lock, [this] { return stopping_ || steady_clock::now() - asked_ <= kInterest; });
    if (stopping_) return;
    lock.unlock();
    turn();
    lock.lock();
    wake_.wait_for(lock, kInterval, [this] { return stopping_; });
  }
}

void ResponseMeter::turn() {
  const DaemonFeed::Run driven = feed_.run();
  const std::string run = driven.id.empty() ? store_.newest() : driven.id;
  if (run.empty()) return publish(R"({"run":null})");
  try {
    const std::optional<RunFile> journal = store_.open(run, record::kJournalFile);
    if (!journal) throw DataError(run + ": its journal is missing or cannot be read");
    const bool is_new = run != run_ || (journal->modified_ns != modified_ns_ && journal->size >= next_size_);
    if (is_new) measure(run, *journal);
    const double played = plan_.step_s > 0.0 ? std::floor(driven.experiment_s / plan_.step_s) : 0.0;
    publish(describe(run, plan_, response_, static_cast<std::size_t>(played), driven.id.empty()));
  } catch (const std::exception& error) {
    run_.clear();
    const Json answer{{"run", run},
                      {"periods", 0},
                      {"complete_s", 0.0},
                      {"rows", 0},
                      {"lines", Json::array()},
                      {"usable_band_Hz", nullptr},
                      {"unknown", fmt::format("no frequency response: {}", error.what())}};
    publish(answer.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
}

void ResponseMeter::measure(const std::string& run, const RunFile& journal) {
  if (run != run_) plan_ = plan_periods(header_of(store_, run), run + "/run.json (experiment)");
  run_.clear();
  modified_ns_ = journal.modified_ns;
  response_ = measure_live_response(journal.path(), plan_);
  // Without two periods waits for the second one.
  const std::size_t periods = std::max<std::size_t>(response_.periods, 1);
  const std::size_t needed = plan_.discard + (periods + 1) * plan_.period;
  const std::size_t missing = needed > response_.rows ? needed - response_.rows : 0;
  next_size_ = journal.size + missing * sizeof(acquisition::TickRecord);
  run_ = run;
}

void ResponseMeter::publish(std::string text) {
  const std::lock_guard lock(mutex_);
  text_ = std::make_shared<const std::string>(std::move(text));
}

}  // namespace eha::web
