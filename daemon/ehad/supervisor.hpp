// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "config/service_config.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/control/server.hpp"
#include "daemon/ehad/background.hpp"
#include "daemon/ehad/health.hpp"
#include "daemon/ehad/lease.hpp"
#include "daemon/ehad/metrics.hpp"
#include "daemon/ehad/notify.hpp"
#include "daemon/ehad/options.hpp"
#include "daemon/ehad/queue.hpp"
#include "daemon/play/play.hpp"
#include "daemon/rig/owned_rig.hpp"
#include "daemon/worker/worker_process.hpp"

namespace eha::service {

/// What the service is: the rig, who may move it, what waits, what runs, what is being fitted. Everything happens in
/// the main thread and blocks it nowhere; experiments are played by a second thread, the disk is used by a third.
/// Not thread-safe.
class Supervisor {
 public:
  using Clock = std::chrono::steady_clock;
  using Peer = control::Peer;
  /// Answers a request, now or later, with what the function returns or throws.
  using Answer = std::function<void(const std::function<Json()>&)>;

  /// Reads the configuration, takes the rig, recovers runs whose process died, and reads the queue.
  /// @throws ConfigError, DeviceError, PermissionError, IoError
  Supervisor(const Options& options, control::EventLoop& loop, Notifier& notifier);
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;
  /// Leaves the rig safe and ends a worker by force; after is_over() nothing is lost.
  ~Supervisor();

  // The methods of ehad-protocol(7). What is refused is thrown as an Error.
  [[nodiscard]] Json status() const;
  Json arm(const Peer& peer);
  Json disarm(const Peer& peer);
  Json stop(const Peer& peer, std::optional<EntryId> only);
  void submit(const Peer& peer, control::SubmitCall call, Answer answer);
  void cancel(const Peer& peer, EntryId id, Answer answer);
  [[nodiscard]] Json queue() const;
  void runs(Answer answer);
  [[nodiscard]] std::string metrics() const;
  Json reload();

  /// An experiment of the queue, null when there is none of that number; and whether it is over.
  [[nodiscard]] Json entry(EntryId id) const;
  [[nodiscard]] bool entry_is_over(EntryId id) const;

  /// To be called several times a second: lease, worker, watchdog.
  void turn(Clock::time_point now);
  /// A child has ended.
  void look_after_worker();

  /// Ramps out what is on and starts nothing any more; the second time it makes the rig safe at once.
  void shut_down();
  [[nodiscard]] bool is_over() const noexcept { return shutting_down_ && !active_; }

 private:
  /// The experiment that is on, from the moment it is chosen.
  struct ActiveRun {
    EntryId entry = 0;
    bool playing = false;  ///< handed to the thread that plays, to which the state machine belongs meanwhile
    Clock::time_point chosen;
    std::shared_ptr<play::RunWatch> watch;
    std::shared_ptr<acquisition::StopRequest> stop;
  };

  struct Fitting {
    EntryId entry = 0;
    std::unique_ptr<worker::WorkerProcess> process;
  };

  void load_configuration();
  void open_rig();
  void close_rig();
  void load_queue();

  void start_next();
  void begin(EntryId id, std::future<std::filesystem::path> prepared);
  void finish(EntryId id, std::future<play::FinishedRun> played);
  void give_up(Entry& entry, ExitCode code, const std::string& why);
  void conclude(Entry& entry, const play::FinishedRun& run);
  void require_arming(const std::string& why);
  void look_after_guard();

  void start_fit();
  void conclude_fit(EntryId id, const worker::WorkerEnd& end);
  void close_entry(Entry& entry, ExitCode code);
  void keep_disk_budget();

  void save(const Entry& entry);
  [[nodiscard]] acquisition::State state() const;
  [[nodiscard]] std::string waiting_reason(const Entry& entry) const;
  [[nodiscard]] std::string status_text() const;
  [[nodiscard]] std::filesystem::path runs_folder() const { return options_.state / "runs"; }

  Options options_;
  Notifier& notifier_;
  std::shared_ptr<const config::RigConfig> rig_config_;
  config::ServiceConfig config_;
  worker::WorkerPrograms programs_;
  QueueStore store_;
  std::unique_ptr<OwnedRig> card_;  ///< none for a simulated rig, which is opened anew for each run
  bool card_is_suspect_ = false;    ///< opened anew before it is armed again
  acquisition::StateMachine machine_;
  Lease lease_;
  Queue queue_;
  std::size_t submissions_ = 0;  ///< being checked, not in the queue yet
  std::optional<ActiveRun> active_;
  std::optional<Fitting> fitting_;
  std::string disarmed_because_ = "ehad has started";
  bool shutting_down_ = false;
  Health health_;
  bool health_was_good_ = true;
  Totals totals_;
  Mailbox mailbox_;
  Background clerk_;                    ///< the disk and the checks
  std::unique_ptr<Background> player_;  ///< experiments
};

}  // namespace eha::service
