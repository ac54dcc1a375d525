// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/rig_keeper.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/play/play.hpp"
#include "hal/backends/backend.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

using acquisition::State;
using namespace std::chrono_literals;

constexpr const char* kRigFile = EHA_SOURCE_DIR "/config/rigs/sim.toml";

class RigKeeperTest : public ::testing::Test {
 protected:
  /// Serves the loop until `answer` has come.
  template <typename T>
  void await(const std::optional<T>& answer) {
    for (int i = 0; i < 1000 && !answer; ++i) loop_.run_once(100ms);
    ASSERT_TRUE(answer);
  }

  /// The message of a refusal, empty when the rig is armed.
  std::string arm() {
    std::optional<std::string> answer;
    rig_.arm([&](std::future<void> done) { answer = message_of(std::move(done)); });
    await(answer);
    return answer.value_or("none");
  }

  static std::string message_of(std::future<void> done) {
    try {
      done.get();
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  }

  control::EventLoop loop_;
  Mailbox mailbox_{loop_};
  test::TemporaryFolder of_snapshot_;
  RigKeeper rig_{RigKeeper::load(kRigFile), of_snapshot_.path() / "unused", mailbox_};
};

TEST_F(RigKeeperTest, IsFaultedUntilItIsArmed) {
  EXPECT_EQ(rig_.state(), State::faulted);
  EXPECT_EQ(arm(), "");
  EXPECT_TRUE(rig_.is_armed());
  rig_.disarm();
  EXPECT_EQ(rig_.state(), State::idle);
}

TEST_F(RigKeeperTest, DoesNotArmWhenAStopComesFirst) {
  std::optional<std::string> answer;
  rig_.arm([&](std::future<void> done) { answer = message_of(std::move(done)); });
  EXPECT_TRUE(rig_.is_arming());
  rig_.cancel_arming();
  await(answer);
  EXPECT_NE(answer->find("not armed"), std::string::npos) << *answer;
  EXPECT_EQ(rig_.state(), State::faulted);
  EXPECT_FALSE(rig_.is_arming());
}

TEST_F(RigKeeperTest, KeepsAnArmingStoppedThatAnotherOneFollows) {
  std::optional<std::string> stopped;
  std::optional<std::string> second;
  rig_.arm([&](std::future<void> done) { stopped = message_of(std::move(done)); });
  rig_.cancel_arming();
  rig_.arm([&](std::future<void> done) { second = message_of(std::move(done)); });
  await(stopped);
  EXPECT_NE(stopped->find("a stop came first"), std::string::npos) << *stopped;
  await(second);
  EXPECT_EQ(*second, "");
  EXPECT_TRUE(rig_.is_armed());
}

TEST_F(RigKeeperTest, LendsTheStateToTheRunAndTakesItBack) {
  ASSERT_EQ(arm(), "");
  std::optional<double> answer;
  rig_.play(
      [](OwnedRig* card, acquisition::StateMachine& machine, acquisition::EarlierRuns&) {
        EXPECT_EQ(card, nullptr);
        machine.move_to(State::ramp_in);
        machine.move_to(State::safe_stop);
        machine.move_to(State::faulted);
        play::FinishedRun finished;
        finished.displacement_in = 7.0;
        return finished;
      },
      [&](std::future<play::FinishedRun> played) { answer = played.get().displacement_in; });
  await(answer);
  EXPECT_EQ(*answer, 7.0);
  EXPECT_EQ(rig_.state(), State::faulted);
  EXPECT_FALSE(rig_.rearm()) << "a fault needs an operator";
  EXPECT_EQ(arm(), "");
}

TEST_F(RigKeeperTest, TakesAnotherConfigurationOnceTheRigIsOpen) {
  auto other = std::make_shared<config::RigConfig>(*rig_.config());
  other->name = "other";
  other->text += "\n";
  std::optional<std::string> answer;
  rig_.reconfigure(other, [&](std::future<void> done) { answer = message_of(std::move(done)); });
  EXPECT_NE(rig_.config()->name, "other");
  EXPECT_TRUE(rig_.is_reconfiguring()) << "armed now, it would be judged by the configuration that goes";
  await(answer);
  EXPECT_FALSE(rig_.is_reconfiguring());
  EXPECT_EQ(rig_.config()->name, "other");
}

TEST_F(RigKeeperTest, IsOpenByTheFileThatWasReadLastWhenReloadsOvertakeOneAnother) {
  const RigKeeper::Config first = rig_.config();
  auto other = std::make_shared<config::RigConfig>(*first);
  other->text += "\n";
  hal::begin_at(other->backend, 1.5);
  std::optional<std::string> gone;
  std::optional<std::string> back;
  rig_.reconfigure(other, [&](std::future<void> done) { gone = message_of(std::move(done)); });
  rig_.reconfigure(first, [&](std::future<void> done) { back = message_of(std::move(done)); });
  await(back);
  EXPECT_EQ(rig_.config()->text, first->text);
  std::optional<double> place_in;
  rig_.read_place([&](std::future<double> read) { place_in = read.get(); });
  await(place_in);
  EXPECT_GT(*place_in, 2.0) << "the other file's rod";
}

TEST_F(RigKeeperTest, KeepsNobodyFromArmingByReloadsOfTheSameFile) {
  std::optional<std::string> answer;
  rig_.reconfigure(std::make_shared<config::RigConfig>(*rig_.config()),
                   [&](std::future<void> done) { answer = message_of(std::move(done)); });
  EXPECT_FALSE(rig_.is_reconfiguring());
  ASSERT_TRUE(answer);
  EXPECT_EQ(*answer, "");
}

TEST_F(RigKeeperTest, KeepsItsConfigurationWhenTheNewRigDoesNotOpen) {
  auto other = std::make_shared<config::RigConfig>(*rig_.config());
  other->text += "\n";
  hal::ComediOptions card;
  card.device = "/no/such/card";
  other->backend = card;
  std::optional<std::string> answer;
  rig_.reconfigure(other, [&](std::future<void> done) { answer = message_of(std::move(done)); });
  await(answer);
  EXPECT_NE(*answer, "");
  EXPECT_FALSE(rig_.is_reconfiguring());
  EXPECT_FALSE(hal::moves_machine(rig_.config()->backend));
  EXPECT_EQ(arm(), "");
}

/// Why a service does not open a card with its snapshot in `folder`; there is none to open.
std::string refusal_of_card(const RigKeeper::Config& sim, const std::filesystem::path& folder, Mailbox& mailbox) {
  const auto card = std::make_shared<config::RigConfig>(*sim);
  hal::ComediOptions options;
  options.device = "/no/such/card";
  card->backend = options;
  try {
    const RigKeeper keeper(card, folder / "safe.json", mailbox);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// eha-safe would make the card of the other service safe in place of this one's.
TEST_F(RigKeeperTest, OpensNoCardWhereAnotherServiceKeepsItsSnapshot) {
  const test::TemporaryFolder folder;
  const os::FileDescriptor other = os::open_file(folder.path() / "card.lock", O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(flock(other.get(), LOCK_EX | LOCK_NB), 0);
  const std::string said = refusal_of_card(rig_.config(), folder.path(), mailbox_);
  EXPECT_NE(said.find("another ehad that drives a card"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "safe.json"));
}

/// The folder of the socket is open to all users.
TEST_F(RigKeeperTest, LocksNothingThatOtherUsersCanLock) {
  const test::TemporaryFolder folder;
  const os::FileDescriptor anybodys = os::open_file(folder.path(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(anybodys.get(), LOCK_EX | LOCK_NB), 0);
  const std::string said = refusal_of_card(rig_.config(), folder.path(), mailbox_);
  EXPECT_EQ(said.find("another ehad"), std::string::npos) << said;
  EXPECT_EQ(std::filesystem::status(folder.path() / "card.lock").permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(RigKeeperTest, HasNoGuardToLoseWithoutACard) {
  EXPECT_EQ(rig_.guard(), GuardState::watching);
  EXPECT_FALSE(rig_.notices_dead_guard());
}

}  // namespace
}  // namespace eha::service
