// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/queue.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

Entry entry_of(EntryId id, uid_t uid, EntryState state = EntryState::waiting) {
  Entry entry;
  entry.id = id;
  entry.uid = uid;
  entry.state = state;
  entry.name = "name";
  return entry;
}

TEST(Queue, GivesEachUserItsOldestWaitingExperiment) {
  Queue queue({entry_of(1, 10, EntryState::over), entry_of(2, 10), entry_of(3, 20), entry_of(4, 10)});
  EXPECT_EQ(queue.next_of(10)->id, 2);
  EXPECT_EQ(queue.next_of(20)->id, 3);
  EXPECT_EQ(queue.next_of(30), nullptr);
  queue.next_of(10)->state = EntryState::cancelled;
  EXPECT_EQ(queue.next_of(10)->id, 4);
  EXPECT_EQ(queue.count(EntryState::waiting), 2U);
}

TEST(Queue, KeepsAFaultOpenUntilItIsClosedEvenInItsFile) {
  const test::TemporaryFolder folder;
  Entry faulted = entry_of(2, 10, EntryState::over);
  faulted.outcome = "faulted";
  faulted.note = "travel_limit at 3 s";
  faulted.run = "20261123T100000Z-e";
  faulted.is_open_fault = true;
  faulted.only_places = true;
  EXPECT_EQ(bad_end_of(faulted), "experiment 2: faulted: travel_limit at 3 s; run 20261123T100000Z-e");
  {
    const QueueStore store(folder.path());
    store.save(faulted);
    store.save(entry_of(3, 10, EntryState::over));
  }
  const QueueStore store(folder.path());
  std::vector<std::string> damaged;
  Queue queue(store.load(damaged));
  ASSERT_NE(queue.open_fault(), nullptr);
  EXPECT_EQ(queue.open_fault()->id, 2);
  EXPECT_TRUE(queue.open_fault()->only_places) << "its length is a time-out";
  EXPECT_EQ(queue.close_faults(), std::vector<EntryId>{2});
  EXPECT_EQ(queue.open_fault(), nullptr);
  EXPECT_TRUE(queue.close_faults().empty());
}

TEST(Queue, KeepsAnOpenSlipThroughARestartAndAnyNumberOfLaterEntries) {
  const test::TemporaryFolder folder;
  Entry slipped = entry_of(2, 10, EntryState::over);
  slipped.has_open_slip = true;
  const std::pair in_force{0.31, 2.95};
  slipped.calibration = in_force;
  {
    const QueueStore store(folder.path());
    store.save(slipped);
    store.save(entry_of(3, 10, EntryState::over));
  }
  const QueueStore store(folder.path());
  std::vector<std::string> damaged;
  Queue queue(store.load(damaged));
  for (std::size_t i = 0; i < Queue::kMostOver; ++i) {
    queue.add(entry_of(static_cast<EntryId>(4 + i), 10, EntryState::over));
  }
  static_cast<void>(queue.forget_old(0));
  EXPECT_EQ(queue.open_slip({0.31, 2.93}), nullptr) << "the sensor was calibrated";
  ASSERT_NE(queue.open_slip(in_force), nullptr);
  EXPECT_NE(queue.open_slip({in_force.first * (1.0 + 1e-6), in_force.second}), nullptr) << "the same in other digits";
  EXPECT_EQ(queue.open_slip(in_force)->id, 2);
  EXPECT_TRUE(queue.close_slips({0.31, 2.93}).empty()) << "another calibration says nothing of this one";
  ASSERT_NE(queue.open_slip(in_force), nullptr);
  EXPECT_EQ(queue.close_slips(in_force), std::vector<EntryId>{2});
  EXPECT_EQ(queue.open_slip(in_force), nullptr);
}

TEST(Queue, HoldsWhatWaitsAndStartsNothingThatIsHeld) {
  Queue queue({entry_of(1, 10, EntryState::running), entry_of(2, 10), entry_of(3, 20), entry_of(4, 10)});
  EXPECT_EQ(queue.hold_waiting("disarmed"), 3U);
  EXPECT_EQ(queue.next_of(10), nullptr);
  EXPECT_EQ(queue.of(10, EntryState::held), (std::vector<EntryId>{2, 4}));
  EXPECT_EQ(queue.find(1)->state, EntryState::running);
  queue.find(4)->state = EntryState::waiting;
  EXPECT_EQ(queue.next_of(10)->id, 4);
  EXPECT_EQ(queue.count_queued(), 3U);
  EXPECT_EQ(queue.count_queued(10), 2U);
}

TEST(Queue, MovesAnExperimentAmongThoseOfItsSubmitterOnly) {
  Queue queue({entry_of(1, 10, EntryState::over), entry_of(2, 10), entry_of(3, 20), entry_of(4, 10),
               entry_of(5, 10, EntryState::held)});
  EXPECT_EQ(queue.move(5, 1), (std::vector<EntryId>{5, 2, 4}));
  EXPECT_EQ(queue.queued_of(10), (std::vector<EntryId>{5, 2, 4}));
  EXPECT_EQ(queue.next_of(10)->id, 2) << "the held one starts nothing";
  EXPECT_EQ(queue.move(2, 100), (std::vector<EntryId>{4, 2}));
  EXPECT_EQ(queue.next_of(10)->id, 4);
  EXPECT_EQ(queue.next_of(20)->id, 3);
  EXPECT_TRUE(queue.move(4, 2).empty()) << "it is there already";
  EXPECT_TRUE(queue.move(1, 1).empty()) << "it is over";
  EXPECT_EQ(queue.in_order().front(), 1);
  queue.add(entry_of(queue.take_id(), 10));
  EXPECT_EQ(queue.queued_of(10), (std::vector<EntryId>{5, 4, 2, 6})) << "a new one goes to the end";
}

TEST(Queue, NeverGivesANumberTwice) {
  Queue queue({entry_of(7, 1)});
  EXPECT_EQ(queue.take_id(), 8);
  EXPECT_EQ(queue.take_id(), 9);
}

TEST(Queue, ForgetsTheOldestThatAreOverAndNoOthers) {
  Queue queue;
  queue.add(entry_of(queue.take_id(), 1));
  for (std::size_t i = 0; i < Queue::kMostOver + 2; ++i) queue.add(entry_of(queue.take_id(), 1, EntryState::over));
  EXPECT_EQ(queue.forget_old(2), (std::vector<EntryId>{3, 4})) << "not the one that has just ended";
  EXPECT_EQ(queue.find(3), nullptr);
  queue.add(entry_of(queue.take_id(), 1, EntryState::cancelled));
  EXPECT_EQ(queue.forget_old(0), (std::vector<EntryId>{2}));
  EXPECT_NE(queue.find(1), nullptr);
  EXPECT_EQ(queue.find(2), nullptr);
  EXPECT_TRUE(queue.forget_old(0).empty());
}

TEST(QueueStore, GivesBackWhatWasSaved) {
  const test::TemporaryFolder folder;
  Entry entry = entry_of(12, 1000, EntryState::fitting);
  entry.file = "a.toml";
  entry.user = "alice";
  entry.fast = true;
  entry.submitted = "2026-01-01T00:00:00Z";
  entry.experiment = "schema = 1\n\"\xc3\xa4\"\n";
  entry.run = "run";
  entry.outcome = "completed";
  entry.note = "note";
  entry.models = Json::array({{{"name", "io"}, {"accepted", true}}});
  entry.exit_code = 3;
  {
    const QueueStore store(folder.path() / "queue");
    store.save(entry_of(12, 1));
    store.save(entry);
    store.save(entry_of(3, 2));
    store.save(entry_of(4, 2));
    store.remove(4);
  }
  std::vector<std::string> damaged;
  const std::vector<Entry> loaded = QueueStore(folder.path() / "queue").load(damaged);
  ASSERT_EQ(loaded.size(), 2U);
  EXPECT_TRUE(damaged.empty());
  EXPECT_EQ(loaded[0].id, 3);
  EXPECT_EQ(describe(loaded[1]), describe(entry));
  EXPECT_EQ(loaded[1].experiment, entry.experiment);
}

TEST(QueueStore, SetsADamagedFileAsideAndLoadsTheOthers) {
  const test::TemporaryFolder folder;
  const QueueStore store(folder.path());
  store.save(entry_of(1, 1));
  store.save(entry_of(3, 1));
  folder.write("00000002.json", "{\"schema\": \"eha-queue/1\", \"entry\"");
  folder.write("00000003.json", "{\"schema\": \"eha-queue/2\"}");
  std::vector<std::string> damaged;
  const std::vector<Entry> loaded = store.load(damaged);
  ASSERT_EQ(loaded.size(), 1U);
  EXPECT_EQ(damaged.size(), 2U);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "00000002.json.damaged"));
}

TEST(QueueStore, BelongsToOneProcess) {
  const test::TemporaryFolder folder;
  const QueueStore store(folder.path());
  EXPECT_THROW(QueueStore(folder.path()), DeviceError);
}

TEST(QueueStore, LocksNothingThatOtherUsersCanOpen) {
  namespace fs = std::filesystem;
  const test::TemporaryFolder folder;
  const fs::path lock = folder.write("lock", "");
  fs::permissions(lock, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  const os::FileDescriptor of_a_member = os::open_file(lock, O_RDONLY);
  {
    const QueueStore store(folder.path());
    EXPECT_EQ(fs::status(lock).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_THROW(QueueStore(folder.path()), DeviceError);
  }
  ASSERT_EQ(flock(of_a_member.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_NO_THROW(QueueStore(folder.path())) << "it is not the file of before";
}

}  // namespace
}  // namespace eha::service
