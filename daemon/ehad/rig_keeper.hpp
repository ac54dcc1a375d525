// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/acquisition/circuits_at_rest.hpp"
#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/ehad/background.hpp"
#include "daemon/play/sample_stream.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "daemon/rig/owned_rig.hpp"
#include "daemon/rig/rod_view.hpp"
#include "hal/rig.hpp"
#include "hal/safe_action.hpp"

namespace eha::service {

/// State of the card's guard.
enum class GuardState { watching, died };

/// The rig: its configuration, the open card with its guard, and the latched state.
///
/// After construction one thread, "eha-rig", uses the rig: it opens and closes the card, reads it before arming, and
/// plays runs (the loop's own thread makes the ticks while this one waits). It also reads an undriven rig fifty times a
/// second, which moves nothing. Memory shared with the guard is created where the guard is started (OwnedRig) and lives
/// as long as the card is open. The members belong to the main thread.
class RigKeeper {
 public:
  using Config = std::shared_ptr<const config::RigConfig>;
  using Json = nlohmann::ordered_json;
  /// Receives a future that is ready; its get() throws the error, if any.
  using Done = std::function<void(std::future<void>)>;

  /// Reads a rig file that may drive a machine. @throws ConfigError, PermissionError, IoError
  [[nodiscard]] static Config load(const std::filesystem::path& file);

  /// Opens the rig; blocks.
  /// @param snapshot  file of the card's snapshot, for eha-safe
  /// @throws DeviceError, PermissionError, ConfigError as OwnedRig
  RigKeeper(Config config, std::filesystem::path snapshot, Mailbox& mailbox);
  RigKeeper(const RigKeeper&) = delete;
  RigKeeper& operator=(const RigKeeper&) = delete;
  /// Waits for the present run, then leaves the rig safe and closes it.
  ~RigKeeper();

  [[nodiscard]] const Config& config() const noexcept { return config_; }
  [[nodiscard]] bool moves_machine() const noexcept;
  /// Scale [in/V] and offset [in] of the sensor.
  [[nodiscard]] std::pair<double, double> calibration() const;

  /// Valid between runs; during one the run's board has the state.
  [[nodiscard]] acquisition::State state() const noexcept { return machine_.state(); }
  [[nodiscard]] bool is_armed() const noexcept { return machine_.state() == acquisition::State::armed; }

  /// Reopens a suspect card, checks its limits and inputs (daemon/rig/arming.hpp) and arms, unless cancel_arming() was
  /// called before. Only between runs and while no configuration is being applied.
  /// @param done  with DeviceError, PermissionError, ConfigError as OwnedRig, or as require_protecting_limits,
  ///              require_plausible_inputs and require_place_by_ruler; the rig is not armed then
  /// @param ruler_in  where a ruler shows the rod of a machine [in]; none: nobody has said
  void arm(Done done, std::optional<double> ruler_in = {});
  [[nodiscard]] bool is_arming() const noexcept { return arming_; }
  void cancel_arming() noexcept { arming_ = false; }
  /// Arms again after a run that left the rig idle. @returns whether it is armed
  bool rearm() noexcept { return machine_.arm(); }
  void disarm() noexcept { machine_.disarm(); }

  /// Whether a new configuration is being applied. config() is still the old one, so the rig must not be armed.
  [[nodiscard]] bool is_reconfiguring() const noexcept { return reconfiguring_ > 0; }
  /// Replaces the configuration; closes and reopens the rig if the text of its file differs from that of the open rig.
  /// After a failure the old configuration stays, and the rig is reopened before it is armed.
  void reconfigure(Config config, Done done);

  /// Returns the configuration with a simulated rod at the end of the last placing.
  [[nodiscard]] Config config_of_next_run() const;
  /// Call after a placing: a simulated rig, which is reopened for each run, then starts at this position.
  void rod_is_at(double displacement_in);

  /// Returns the rod of an undriven rig, read fifty times a second; see RodView.
  [[nodiscard]] Json rod() const { return rod_.describe(config_->limits); }
  /// Returns the same of the present run.
  [[nodiscard]] Json rod(const acquisition::Snapshot& now) const;

  /// Reads the rod position of an undriven rig, after all earlier tasks of the rig's thread.
  /// @param then  receives the position [in]; DeviceError if it cannot be read
  void read_place(std::function<void(std::future<double>)> then);

  /// Samples of the rig: of the readings between runs, and of the runs whose RunWatch refers to it.
  [[nodiscard]] play::SampleStream& samples() noexcept { return samples_; }
  [[nodiscard]] const play::SampleStream& samples() const noexcept { return samples_; }

  /// File of the card's snapshot, for eha-safe.
  [[nodiscard]] const std::filesystem::path& snapshot() const noexcept { return snapshot_; }

  /// Runs `play(card, machine, earlier)` in the rig's thread, which owns the state until `then` is called with the
  /// outcome.
  /// @param play  receives the card (OwnedRig*), nullptr for a simulated rig, which is reopened for each run; returns a
  ///              play::FinishedRun
  template <typename Play, typename Then>
  void play(Play play, Then then) {
    thread_->ask(
        [this, play = std::move(play)]() mutable {
          idle_blocks_.finish();
          // Seen since the run was begun, and rest_ is where the rod stands now.
          if (card_ && moved_in_.load() != 0.0) {
            throw RodMoved("the rod's reading moved while nothing drove it: nothing is driven");
          }
          if (card_ && circuit_.load() != acquisition::CircuitAtRest::sound) {
            throw DeviceError(std::string(acquisition::sentence_of(circuit_.load())));
          }
          auto finished = [&] {
            try {
              return play(card_.get(), machine_, earlier_);
            } catch (...) {  // it may have been driven until now
              off_since_ = std::chrono::steady_clock::now();
              throw;
            }
          }();
          // Until rod_is_at() a simulated rod would be seen where it was before the placing.
          if (finished.only_placed && std::isfinite(finished.displacement_in)) replica_.reset();
          // Nobody compared the rod's readings while the files were written.
          rest_ = {finished.ended, finished.displacement_in, finished.velocity_in_per_s};
          off_since_ = finished.ended;
          return finished;
        },
        std::move(then));
  }

  /// The place was compared with a ruler, or the sensor calibrated: the next run counts slips and lacking way from 0.
  void forget_slips() {
    thread_->ask(
        [this] {
          earlier_.slipped_in = 0.0;
          earlier_.lacking = {};
        },
        [](std::future<void>) {});
  }

  /// Where the rod of a machine was when it was last read; belongs to the rig's thread, so call it in play().
  [[nodiscard]] const std::optional<RodAtRest>& rest() const noexcept { return rest_; }

  /// Call after a run whose end the card has not confirmed: makes it safe, or else leaves it to the guard, which opens
  /// it anew and tries again and again. The next arm() opens it.
  void close_unsafe();
  /// Writes the safe state to an undriven machine: a stop is one whatever is thought of the rig.
  void make_safe();
  /// Whether a card was closed that had not confirmed the safe state, and none has since. Thread-safe.
  [[nodiscard]] bool is_unsafe() const noexcept { return is_unsafe_; }
  /// Call several times a second: opens such a card anew, once a second, until it is safe.
  void poll_unsafe(std::chrono::steady_clock::time_point now);

  /// Marks the card to be reopened, with a new guard, before the rig is armed again.
  void mark_suspect() noexcept { is_suspect_ = true; }

  /// Whether the guard lives. Costs one waitid().
  [[nodiscard]] GuardState guard() const noexcept;
  /// Whether the guard has died since the card was opened. Returns true once, and marks the card as suspect.
  [[nodiscard]] bool notices_dead_guard() noexcept;

  /// Whether the reading of an undriven machine's rod has moved by more than 0.1 in within half a second: the
  /// hydraulics are on against the command, the sensor has slipped, or somebody moves the rod. Returns how far [in]
  /// once.
  [[nodiscard]] std::optional<double> notices_motion() noexcept;
  /// Whether the lines of an undriven machine showed that somebody must arm it anew. Returns what, once.
  [[nodiscard]] acquisition::CircuitAtRest notices_circuit() noexcept;

  /// Counts up while the rig's thread is idle. Thread-safe.
  [[nodiscard]] std::uint64_t idle_beats() const noexcept { return thread_->beats(); }

 private:
  void open(const config::RigConfig& config);
  void close() noexcept;
  /// Tries to make a card safe whose snapshot a process before this one left, before anything overwrites it.
  /// @throws Error  it is not confirmed safe: left_ is kept
  void make_left_card_safe(std::chrono::milliseconds patience);
  /// @throws DeviceError, PermissionError, IoError  another service keeps its snapshot in this one's folder, or the
  ///                                                lock is another user's
  void hold_folder();
  void read_idle_rig();
  /// Where the sensor shows the rod of the open rig [in]. @throws DeviceError  it cannot be read
  double read_rod();
  /// Reads the rig and passes the reading to the rod's view and the sample stream.
  hal::RigStatus read(hal::Rig& rig, hal::RigReading& reading);
  /// Looks at a reading of an undriven card, and reads once more where it has moved.
  void note_rest(hal::Rig& rig, const hal::RigReading& reading);
  /// Compares the rod of a card that was opened anew with where it was before. @throws RodMoved
  void require_rest_of_before(const config::RigConfig& config);

  Config config_;
  std::filesystem::path snapshot_;
  os::FileDescriptor lock_;            ///< of the snapshot's folder; none before a card is opened
  std::unique_ptr<OwnedRig> card_;     ///< none for a simulated rig
  std::unique_ptr<hal::Rig> replica_;  ///< a simulated rig for reading between runs; each run opens its own
  std::string opened_text_;            ///< text of the open rig's file, empty: closed; belongs to the rig's thread
  RodView rod_;
  play::SampleStream samples_;
  play::BlockMaker idle_blocks_{samples_, play::BlockMaker::Kind::idle};  ///< belongs to the rig's thread
  std::optional<double> placed_in_;                                       ///< of a simulated rig
  int reads_left_out_ = 0;                                                ///< of a card that does not answer
  std::optional<RodAtRest>
      rest_;               ///< at most half a second old, or the end of the last run; belongs to the rig's thread
  std::string rest_text_;  ///< of the rig file by which rest_ was read
  std::atomic<double> moved_in_{};                     ///< until it is noticed
  std::chrono::steady_clock::time_point off_since_{};  ///< end of the last run; belongs to the rig's thread
  std::atomic<acquisition::CircuitAtRest> circuit_{};  ///< until it is noticed
  /// A card of the process before this one that is not confirmed safe; belongs to the rig's thread. The rig file may
  /// name another one since.
  std::optional<hal::SafeAction> left_;
  std::string failed_try_;  ///< why the last try to make a card safe failed
  bool is_suspect_ = false;
  bool is_making_safe_ = false;
  std::atomic<bool> is_unsafe_{false};
  std::chrono::steady_clock::time_point next_try_{};  ///< to open an unsafe card
  bool arming_ = false;
  std::uint64_t arming_number_ = 0;  ///< number of the newest arm(); an earlier cancelled one stays cancelled
  int reconfiguring_ = 0;
  int reopening_ = 0;  ///< number of tasks that may replace card_; the main thread does not use it meanwhile
  acquisition::StateMachine machine_;
  acquisition::EarlierRuns earlier_;  ///< the runs so far; belongs to the rig's thread
  std::unique_ptr<Background> thread_;
};

}  // namespace eha::service
