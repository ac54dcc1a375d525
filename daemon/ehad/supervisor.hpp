// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "config/service_config.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/control/server.hpp"
#include "daemon/ehad/background.hpp"
#include "daemon/ehad/checker.hpp"
#include "daemon/ehad/fitter.hpp"
#include "daemon/ehad/health.hpp"
#include "daemon/ehad/lease.hpp"
#include "daemon/ehad/metrics.hpp"
#include "daemon/ehad/notify.hpp"
#include "daemon/ehad/queue.hpp"
#include "daemon/ehad/rig_keeper.hpp"
#include "daemon/ehad/run_index.hpp"
#include "daemon/ehad/service_options.hpp"
#include "daemon/ehad/suspend_watch.hpp"
#include "daemon/play/play.hpp"
#include "daemon/rig/sleep_inhibitor.hpp"

namespace eha::service {

/// Manages lease, queue and runs; RigKeeper plays an experiment and Fitter fits it. Belongs to the main thread and
/// never blocks it: the rig and the disk have their own threads. Not thread-safe.
class Supervisor {
 public:
  using Clock = std::chrono::steady_clock;
  using Peer = control::Peer;
  /// Answers a request, now or later, with the result or the exception of the function.
  using Answer = std::function<void(const std::function<Json()>&)>;
  /// The same with the result's text, made where it takes nobody's time.
  using Text = std::shared_ptr<const std::string>;
  using TextAnswer = std::function<void(const std::function<Text()>&)>;

  /// Reads the configuration, opens the rig, recovers runs whose process died, and reads the queue.
  /// @throws ConfigError, DeviceError, PermissionError, IoError
  Supervisor(const Options& options, control::EventLoop& loop, Notifier& notifier);
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;
  /// Leaves the rig safe and kills a worker; loses nothing after is_over().
  ~Supervisor();

  // The methods of ehad-protocol(7). A refusal is thrown as an Error, or by the answer's function.
  [[nodiscard]] Json status() const;
  void arm(const Peer& peer, const control::ArmCall& call, Answer answer);
  Json disarm(const Peer& peer);
  Json stop(const Peer& peer, const control::StopCall& call);
  void submit(const Peer& peer, control::SubmitCall call, Answer answer);
  void cancel(const Peer& peer, EntryId id, Answer answer);
  /// @param over  greatest number of finished entries, the newest; none: all
  [[nodiscard]] Json queue(std::optional<std::int64_t> over) const;
  Json hold(const Peer& peer, std::optional<EntryId> only);
  Json release(const Peer& peer, std::optional<EntryId> only);
  void move(const Peer& peer, const control::MoveCall& call, Answer answer);
  /// Lists the runs. Requests that arrive during a reading of the folder wait together for the next one: a reading may
  /// take long, and each run waits for it before its start.
  void runs(TextAnswer answer);
  void acknowledge(const Peer& peer, const std::string& run, Answer answer);
  void remove(const Peer& peer, const std::string& run, Answer answer);
  [[nodiscard]] std::string metrics() const;
  /// @param peer  none: a signal, which only root and the service's own user can send
  void reload(const std::optional<Peer>& peer, Answer answer);

  /// Call when a connection has ended: holds its experiments that were queued without `detach` and
  /// have not begun, and drops those that are still checked.
  void client_gone(control::ClientId client);

  /// The rig's samples, for watchers.
  [[nodiscard]] const play::SampleStream& samples() const noexcept { return rig_.samples(); }

  /// Returns an experiment of the queue, null if there is none of that number; and whether it is over.
  [[nodiscard]] Json entry(EntryId id) const;
  [[nodiscard]] bool entry_is_over(EntryId id) const;

  /// Checks lease, worker, guard, suspend and watchdog. Call several times a second.
  void poll(Clock::time_point now);
  /// Call when a child process has ended.
  void poll_worker();

  /// Ramps out the present run and starts no other; the second call makes the rig safe at once.
  void shut_down();
  [[nodiscard]] bool is_over() const noexcept { return shutting_down_ && !active_; }

 private:
  void list_asked_runs();
  /// The present experiment, from the moment it is chosen.
  struct ActiveRun {
    EntryId entry = 0;
    bool playing = false;  ///< in the rig's thread, which owns the state machine meanwhile
    std::shared_ptr<play::RunWatch> watch;
    std::shared_ptr<acquisition::StopRequest> stop;
    std::string stopped_by = {};                   ///< the first stop and its user
    std::optional<Clock::time_point> played = {};  ///< when the loop was seen to have ended
    bool lost_client = false;                      ///< whose connection had to be open until it plays
    bool explores = false;                         ///< before the first row, see config::kLongestExploring_s
    std::string moved = {};  ///< the rod did, or its reading, or a line, before it plays; says how
  };

  /// Experiments of one request; all of them or none enter the queue.
  struct Submission {
    uid_t uid = 0;
    std::vector<Entry> entries;
    bool is_list = false;
    RigKeeper::Config rig;                ///< for the checks
    control::ClientId client = 0;         ///< connection that must be open until they start; 0: none
    std::optional<double> ruler_in = {};  ///< where a ruler shows the rod [in]
    bool characterises = false;           ///< one of them measures the valve
    bool moves_at_once = false;           ///< one of them is a placing
    /// holds_ when it was submitted, if its user could start an experiment then.
    std::optional<std::uint64_t> armed_at = {};
    Answer answer;
    std::size_t checked = 0;
    ListFindings findings = {};
  };

  void load_queue();

  // Steps of an experiment's start: choose it, read the rod's position, rehearse it from there, begin.
  struct Start {
    EntryId entry = 0;
    std::filesystem::path folder;  ///< of its check; one for each attempt, because an earlier one may still be in use
    RigKeeper::Config rig;         ///< for its rehearsal
  };
  using Turn = std::shared_ptr<const Start>;
  void start_next();
  [[nodiscard]] Entry* whose_turn();
  [[nodiscard]] Entry* still_next(const Turn& turn);
  void rehearse_next(const Turn& turn, std::future<double> read);
  void check_next(const Turn& turn, double place_in);
  void finish_rehearsal(const Turn& turn, double place_in, const worker::WorkerEnd& end);
  void start(Entry& entry);
  void begin(EntryId id, std::future<std::filesystem::path> prepared);
  using Prepared = std::shared_ptr<const config::PreparedExperiment>;
  void drive(EntryId id, const std::filesystem::path& folder, const RigKeeper::Config& config,
             std::future<Prepared> ready);
  void finish(EntryId id, std::future<play::FinishedRun> played);
  void give_up(Entry& entry, ExitCode code, const std::string& why);
  void conclude(Entry& entry, const play::FinishedRun& run);
  /// Whether a disarmed rig stays leased.
  enum class LeaseFate { kept, released };
  void disarm_rig(const std::string& why, LeaseFate lease);
  void require_lease(const Peer& peer, std::string_view what) const;
  /// "the lease is alice's for another 594 s (since 10:51; the rig is armed)"; somebody must hold it.
  [[nodiscard]] std::string holder_text() const;
  [[nodiscard]] bool may_start(uid_t uid) const;
  /// Whether it may start now and could all the while since its submission: who arms anew does not expect it.
  [[nodiscard]] bool may_still_start(const Submission& submission) const;
  [[nodiscard]] Json armed_answer(uid_t uid) const;
  /// @throws DeviceError  the card has not confirmed the safe state
  void require_safe() const;
  void poll_guard();
  void poll_rod(Clock::time_point now);
  /// Disarms, once, where the lines of an undriven machine are not sound.
  void note_circuit(acquisition::CircuitAtRest circuit, Clock::time_point now);
  /// After what an undriven machine showed: refuses the experiment about to begin, or disarms, or keeps the reason.
  void drive_nothing(const std::string& why, bool is_at_stake);
  void poll_suspend();
  void prepare_for_sleep();
  void update_inhibitor() noexcept;
  void poll_health(Clock::time_point now);

  void start_fit();
  void finish_fit(EntryId id, const worker::WorkerEnd& end);
  void close_entry(Entry& entry, ExitCode code);
  void forget_old(EntryId kept);
  [[nodiscard]] std::set<std::string> runs_in_use() const;
  void make_room(const std::set<std::string>& in_use, double budget_GiB);
  void account_for(const std::string& run);

  void check(const std::shared_ptr<Submission>& submission);
  void enqueue(const std::shared_ptr<Submission>& submission);
  void end_submission(const Submission& submission);
  void remove_check_folder(const std::filesystem::path& folder);
  void hold_for_lost_client(Entry& entry);
  /// Takes back a run whose folder is made and which does not play yet.
  void take_back(Entry& entry, const std::filesystem::path& folder);
  /// Removes the folder of such a run, and the run from its entry.
  void remove_unplayed(Entry& entry, const std::filesystem::path& folder);
  /// Holds every waiting experiment; refuses a waiting move to a place instead.
  void hold_waiting(const std::string& why);
  void refuse_move(Entry& entry, const std::string& why);
  void refuse(const Submission& submission);
  /// Refuses a held move, which must not begin later, when somebody arms for another purpose.
  /// @throws PermissionError
  void require_arming_of_placing(const Submission& submission) const;
  /// Before the first valve measurement of a machine. @throws UsageError, ConfigError, DeviceError
  void require_ruler(const Submission& submission) const;
  /// Where the sensor shows the rod [in]. @throws DeviceError  it is not known
  [[nodiscard]] double shown_in() const;
  /// Refuses what needs a ruler where nobody has read one. @throws Error (safety_trip)
  void require_no_slip() const;
  void require_no_missed_motion() const;
  void close_slips();
  /// The rod did what the volts asked for, or a ruler has shown where it is.
  void forget_missed_motion();
  void require_room_in_queue(const Peer& peer, std::size_t wanted) const;
  [[nodiscard]] std::optional<double> place_at_start() const;
  [[nodiscard]] Entry& require_own(const Peer& peer, EntryId id, std::string_view what);
  void save(const Entry& entry);
  [[nodiscard]] acquisition::State state() const;
  [[nodiscard]] std::string waiting_reason(const Entry& entry) const;
  [[nodiscard]] std::string status_text() const;
  [[nodiscard]] std::filesystem::path check_folder(EntryId id) const {
    return options_.state / "check" / std::to_string(id);
  }
  [[nodiscard]] std::filesystem::path runs_folder() const { return options_.state / "runs"; }

  Options options_;
  Notifier& notifier_;
  config::ServiceConfig config_;
  QueueStore store_;
  Queue queue_;
  std::vector<TextAnswer> runs_asked_;  ///< waiting for the next reading of the runs' folder
  bool is_listing_runs_ = false;
  std::uint64_t holds_ = 0;                   ///< how often all that waited was held
  std::map<uid_t, std::size_t> submissions_;  ///< of each user: being checked, not yet in the queue
  std::map<control::ClientId, std::shared_ptr<Submission>> attached_;  ///< those of them that need their client
  Lease lease_;
  std::optional<ActiveRun> active_;
  std::uint64_t starts_ = 0;  ///< attempts since the start of the service
  Turn next_;                 ///< the experiment about to begin; a new object for each attempt, none after a disarm
  static constexpr std::string_view kNotConfirmedSafe =
      "THE OUTPUT IS NOT CONFIRMED SAFE: the card has refused the safe voltage; use the emergency stop. ehad tries "
      "again "
      "every second";
  [[nodiscard]] std::string why_disarmed() const;
  std::string disarmed_because_ = "ehad has started";
  std::string stopped_because_;  ///< what has disarmed the rig against its holder's will, for who arms it next
  /// What poll_rod() said of it: the next arming is refused once, for a person to look.
  std::string moved_at_rest_;
  Clock::time_point silent_until_{};  ///< of motion at rest
  bool shutting_down_ = false;
  Health health_;
  bool health_was_good_ = true;
  SuspendWatch suspend_;
  Totals totals_;
  Fitter fitter_;
  Checker checker_;
  std::unique_ptr<RunIndex> index_;  ///< belongs to the disk thread once that exists
  Mailbox mailbox_;
  Background disk_thread_;       ///< files
  Background preparing_thread_;  ///< volts of the next experiment
  SleepInhibitor inhibitor_;
  std::chrono::system_clock::time_point rig_read_ = std::chrono::system_clock::now();  ///< when its file was
  RigKeeper rig_;
};

}  // namespace eha::service
