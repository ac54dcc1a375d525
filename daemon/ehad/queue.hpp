// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/os/file_descriptor.hpp"
#include "daemon/control/protocol.hpp"

namespace eha::config {
struct RigConfig;
}

namespace eha::service {

using control::EntryId;
using control::Json;

/// States of an experiment: held -> waiting -> running -> fitting -> judging -> over. `waiting` starts automatically
/// when its turn comes; `held` only after its owner has released it. Both may be cancelled, and disarming the rig turns
/// waiting into held. An experiment that did not complete goes from running to over. In `judging` the worker has ended
/// and its result is being read.
enum class EntryState { held, waiting, running, fitting, judging, over, cancelled };

/// Initial conditions of a rehearsal.
struct RehearsedFrom {
  std::shared_ptr<const config::RigConfig> rig;
  std::optional<double> place_in;  ///< position of the rod; none: it was not known
};

/// A submitted experiment. State `running` is saved before the rig moves, so a crash never replays an experiment.
struct Entry {
  EntryId id = 0;
  EntryId place = 0;  ///< smaller ones start earlier, among those of its submitter; 0: same as its number
  EntryState state = EntryState::held;
  std::string name;  ///< the experiment's
  std::string file;  ///< the client's name for it, for messages
  uid_t uid = 0;     ///< who submitted it
  std::string user;
  bool fast = false;                ///< virtual time
  bool accept_travel_risk = false;  ///< played despite the rehearsal's result
  bool is_for_machine = true;       ///< submitted for a rig that moves a machine: somebody has confirmed its motion
  bool only_places = false;         ///< only moves the rod to a place: held by its user only, not by a disarming
  std::string submitted;            ///< UTC
  std::string experiment;           ///< TOML; empty once it is over
  std::string run;                  ///< name of the run folder; empty before
  std::string outcome;              ///< of the run: completed, faulted, ...; "lost" when nothing of it was recorded
  std::string note;                 ///< reason for a bad end, or for a missing fit
  std::vector<std::string> warnings = {};  ///< on a completed run: near a limit, late ticks, ...
  std::optional<double> placed_in = {};    ///< of an experiment that only places the rod: its final position [in]
  double duration_s = 0.0;                 ///< of all repetitions, without the move to the start; 0: not known
  Json rehearsal = {};                     ///< as in `eha check --json`; null if nothing is known
  Json models = Json::array();             ///< as in the run's manifest, after the fit
  int exit_code = 0;                       ///< exit code of `eha run`, once it is over
  bool is_open_fault = false;  ///< ended by a fault or the death of ehad, and nobody has armed the rig since
  bool has_open_slip = false;  ///< the reading of a machine's sensor jumped, and nothing has confirmed the place since
  /// A machine's run that ended by a fault that names_motion(), and since then none was whole, and no ruler read.
  bool missed_motion = false;
  /// Scale [in/V] and offset [in] of a machine's sensor when it began; none before and of a simulated rig.
  std::optional<std::pair<double, double>> calibration = {};
  // Neither is saved: a restart ends every connection, and held experiments are rehearsed again.
  std::uint64_t client = 0;                     ///< connection that must be open at the start; 0: none
  std::optional<RehearsedFrom> rehearsed = {};  ///< of `rehearsal`; none: not since the start of the service
};

/// "waiting", ...
[[nodiscard]] std::string_view to_text(EntryState state) noexcept;

/// Describes the entry for clients, without the experiment's text.
[[nodiscard]] Json describe(const Entry& entry);

/// Describes the end of an experiment that a fault or the death of ehad ended, without advice, which the run has:
/// "experiment 7: faulted: travel_limit ...; run NAME".
[[nodiscard]] std::string bad_end_of(const Entry& entry);

/// Whether two calibrations of a sensor, scale [in/V] and offset [in], show its rod in the same place, within 0.005 in
/// at any volts: the same one in other units or digits.
[[nodiscard]] bool is_same_place(const std::pair<double, double>& one, const std::pair<double, double>& other);

/// The queue's files, one for each experiment, replaced atomically. Blocks on the disk. Not thread-safe.
class QueueStore {
 public:
  /// Creates the folder and locks it. @throws DeviceError  another ehad holds it   @throws IoError, PermissionError
  explicit QueueStore(std::filesystem::path folder);
  QueueStore(const QueueStore&) = delete;
  QueueStore& operator=(const QueueStore&) = delete;

  /// @param damaged  gets a message for each file that cannot be read; it is set aside as NAME.damaged
  /// @throws IoError, PermissionError  the folder cannot be listed
  [[nodiscard]] std::vector<Entry> load(std::vector<std::string>& damaged) const;

  /// @throws IoError, PermissionError
  void save(const Entry& entry) const;
  void remove(EntryId id) const noexcept;

 private:
  [[nodiscard]] std::filesystem::path file_of(EntryId id) const;

  std::filesystem::path folder_;
  os::FileDescriptor lock_;
};

/// The queue in memory. Not thread-safe.
class Queue {
 public:
  static constexpr std::size_t kMostQueued = 100;       ///< held and waiting, of all users
  static constexpr std::size_t kMostQueuedOfUser = 20;  ///< held and waiting, of one user
  static constexpr std::size_t kMostOver = 500;         ///< finished ones that are kept

  explicit Queue(std::vector<Entry> entries = {});

  [[nodiscard]] EntryId take_id() noexcept { return next_id_++; }
  Entry& add(Entry entry);
  [[nodiscard]] Entry* find(EntryId id);
  [[nodiscard]] const std::map<EntryId, Entry>& entries() const noexcept { return entries_; }
  [[nodiscard]] std::size_t count(EntryState state) const;

  /// Entries that are held or waiting.
  [[nodiscard]] std::size_t count_queued() const;
  [[nodiscard]] std::size_t count_queued(uid_t uid) const;
  /// Returns all entries: first the finished ones, oldest first, then each user's others in starting order.
  [[nodiscard]] std::vector<EntryId> in_order() const;
  /// Returns the entries of `uid` in a state, in starting order.
  [[nodiscard]] std::vector<EntryId> of(uid_t uid, EntryState state) const;
  /// Returns the entries of `uid` that are held or waiting, in starting order.
  [[nodiscard]] std::vector<EntryId> queued_of(uid_t uid) const;
  /// Moves a queued entry to a position among those of its submitter, from 1; beyond the last: the last.
  /// @returns the entries whose place has changed
  std::vector<EntryId> move(EntryId id, std::int64_t position);
  /// Holds every waiting entry. @param why  becomes its note   @returns the number of them
  std::size_t hold_waiting(const std::string& why);

  /// Returns the first waiting entry of `uid`; nullptr if there is none.
  [[nodiscard]] Entry* next_of(uid_t uid);
  /// Returns the oldest entry that is to be fitted; nullptr if there is none.
  [[nodiscard]] Entry* next_to_fit();

  /// Returns the newest open fault; nullptr if there is none.
  [[nodiscard]] const Entry* open_fault() const;
  /// Closes every open fault. @returns the entries that have changed
  std::vector<EntryId> close_faults();
  /// Returns the newest entry with an open slip by the calibration in force; nullptr if there is none.
  [[nodiscard]] const Entry* open_slip(const std::pair<double, double>& in_force) const;
  /// Returns the entries that missed_motion by the calibration in force.
  [[nodiscard]] std::vector<EntryId> missed_motion(const std::pair<double, double>& in_force) const;
  /// Forgets these; those by another calibration stay for the day when that is in force again. @returns the entries
  /// that have changed
  std::vector<EntryId> forget_missed_motion(const std::pair<double, double>& in_force);
  /// Closes every open slip by the calibration in force, as above. @returns the entries that have changed
  std::vector<EntryId> close_slips(const std::pair<double, double>& in_force);

  /// Removes the oldest finished entries beyond kMostOver, but never `kept` nor one with an open slip or missed motion.
  /// @returns their numbers
  std::vector<EntryId> forget_old(EntryId kept);

 private:
  /// Takes a mark from the entries of a calibration, or from all. @returns the entries that had it
  std::vector<EntryId> clear(bool Entry::*mark, const std::optional<std::pair<double, double>>& in_force = {});

  std::map<EntryId, Entry> entries_;
  EntryId next_id_ = 1;
};

}  // namespace eha::service
