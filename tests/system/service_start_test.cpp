// SPDX-License-Identifier: GPL-3.0-or-later
// What an experiment must still fulfil when its turn comes: a rehearsal from where the rod stands then, and a client.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "core/os/files.hpp"
#include "daemon/control/socket_address.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

using control::Client;

/// Extends the rod by an inch and a half: harmless from mid-stroke.
constexpr const char* kExtends =
    "schema = 1\nname = \"extends\"\nduration_s = 10.0\n[excitation]\nkind = \"sine\"\noffset_V = 0.8\n"
    "tones = [{ frequency_Hz = 0.2, amplitude_V = 2.0 }]\n[record]\ndiscard_s = 0.0\n[[model]]\nname = \"io\"\n"
    "structure = \"io\"\n";
constexpr double kFar_in = 5.3;

std::string placing_text(double place_in) {
  return fmt::format("schema = 1\nname = \"goto\"\nduration_s = 60.0\n[place]\ndisplacement_in = {}\n", place_in);
}

/// A connection that sends requests without waiting for answers.
class BareConnection {
 public:
  explicit BareConnection(const Daemon& daemon) : descriptor_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_un address = control::socket_address(daemon.socket());
    EXPECT_EQ(connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  BareConnection(const BareConnection&) = delete;
  BareConnection& operator=(const BareConnection&) = delete;
  ~BareConnection() { close(descriptor_); }

  void say(const Json& request) const {
    const std::string line = request.dump() + "\n";
    EXPECT_EQ(::send(descriptor_, line.data(), line.size(), MSG_NOSIGNAL), static_cast<ssize_t>(line.size()));
  }
  void wait_for_answers(int count) const {
    char byte = 0;
    // The greeting comes first.
    for (int lines = 0; lines <= count && recv(descriptor_, &byte, 1, 0) == 1;) lines += byte == '\n' ? 1 : 0;
  }

 private:
  int descriptor_;
};

class ServiceStart : public ::testing::Test {
 protected:
  void SetUp() override {
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
  }

  std::int64_t submit_checked(const std::string& text, bool accept_travel_risk = false) {
    return client_
        ->call("submit", {{"experiment", text},
                          {"name", "extends.toml"},
                          {"fast", true},
                          {"accept_travel_risk", accept_travel_risk},
                          {"detach", true}})
        .at("entry");
  }
  void place_at(double place_in) {
    ASSERT_EQ(follow(daemon_, submit(*client_, placing_text(place_in))).at("outcome"), "completed") << daemon_.log();
  }
  void go_far() { place_at(kFar_in); }
  double rod_in() { return client_->call("status").at("rod").at("displacement_in"); }
  std::string state_of(std::int64_t entry) {
    const Json found = entry_of(daemon_, entry);
    return found.is_object() ? found.at("state").get<std::string>() : "not there";
  }

  /// Waits until an experiment is in a state. @returns whether that happened in time
  bool reaches(std::int64_t entry, const std::string& state) {
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (state_of(entry) != state && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return state_of(entry) == state;
  }

  void expect_refused(const Json& over) {
    EXPECT_EQ(over.at("outcome"), "refused") << over;
    EXPECT_EQ(over.at("exit_code"), static_cast<int>(ExitCode::configuration));
    EXPECT_EQ(over.at("run"), "") << "nothing was played";
    const std::string note = over.at("note");
    EXPECT_NE(note.find("rehearsed before playing, from "), std::string::npos) << note;
    EXPECT_NE(note.find("extends.toml: 100 % of the rehearsed rods reach a limit"), std::string::npos) << note;
  }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
};

TEST_F(ServiceStart, RehearsesAgainWhereAPlacingHasMovedTheRodMeanwhile) {
  const std::int64_t extends = submit_checked(kExtends);
  const std::int64_t after = submit(*client_, quiet_experiment_text("after", 2.0));
  client_->call("arm");
  go_far();
  client_->call("release");
  expect_refused(follow(daemon_, extends));
  EXPECT_NEAR(rod_in(), 5.3, 0.03);
  EXPECT_EQ(client_->call("status").at("state"), "idle");
  EXPECT_EQ(state_of(after), "held") << "as after every refusal";
}

TEST_F(ServiceStart, DoesNotRehearseFromWhereAnotherExperimentHasTheRodOnItsWay) {
  // Out by an inch and a half first: too far from where the rod is then.
  const std::string out_and_back =
      "schema = 1\nname = \"out\"\nduration_s = 20.0\n[excitation]\nkind = \"sine\"\n"
      "tones = [{ frequency_Hz = 0.05, amplitude_V = 3.8 }]\n[record]\ndiscard_s = 0.0\n[[model]]\nname = \"io\"\n"
      "structure = \"io\"\n";
  client_->call("arm");
  const std::int64_t first = submit(*client_, out_and_back, false);
  ASSERT_TRUE(reaches(first, "running")) << daemon_.log();
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (rod_in() < 4.5 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_GE(rod_in(), 4.5);
  EXPECT_NO_THROW(submit(*client_, out_and_back));
  client_->call("stop");
  follow(daemon_, first);
}

TEST_F(ServiceStart, RehearsesAgainInAnotherOrder) {
  client_->call("arm");
  const std::int64_t on = submit(*client_, quiet_experiment_text("on", 600.0), false);
  const std::int64_t extends = submit_checked(kExtends);
  const std::int64_t far = submit(*client_, placing_text(kFar_in));
  client_->call("move", {{"entry", far}, {"to", 1}});
  // A move that only waits would be refused by the stop.
  client_->call("hold");
  client_->call("stop");
  follow(daemon_, on);
  client_->call("arm");
  client_->call("release");
  EXPECT_EQ(follow(daemon_, far).at("outcome"), "completed");
  expect_refused(follow(daemon_, extends));
}

TEST_F(ServiceStart, SaysFromWhereItWasRehearsedInTheUnitOfTheRig) {
  const std::string rig = content_of(daemon_.rig_file());
  std::ofstream(daemon_.rig_file()) << "units = \"mm\"\n" << rig;
  client_->call("reload");
  const std::int64_t extends = submit_checked(kExtends);
  client_->call("arm");
  go_far();
  client_->call("release");
  const std::string note = follow(daemon_, extends).at("note");
  EXPECT_NE(note.find("rehearsed before playing, from 134."), std::string::npos) << note;
  EXPECT_EQ(note.find(" in: "), std::string::npos) << note;
}

TEST_F(ServiceStart, RehearsesAgainWithARigFileThatWasReloaded) {
  const std::int64_t extends = submit_checked(kExtends);
  std::string rig = content_of(daemon_.rig_file());
  const std::string limit = "travel_max_in = 5.75";
  rig.replace(rig.find(limit), limit.size(), "travel_max_in = 3.50");
  std::ofstream(daemon_.rig_file()) << rig;
  client_->call("reload");
  client_->call("arm");
  client_->call("release");
  expect_refused(follow(daemon_, extends));
  EXPECT_NEAR(rod_in(), 2.95, 0.01);
}

TEST_F(ServiceStart, PlaysAllTheSameWhatWasSubmittedWithTheRiskAccepted) {
  const std::int64_t extends = submit_checked(kExtends, true);
  daemon_.stop(SIGTERM);
  daemon_.start();
  client_ = std::make_unique<Client>(daemon_.socket());
  client_->call("arm");
  go_far();
  client_->call("release");
  const Json over = follow(daemon_, extends);
  EXPECT_EQ(over.at("outcome"), "faulted") << over;
  EXPECT_EQ(over.at("rehearsal").at("chance_of_trip"), 1.0) << "it was rehearsed from there";
}

TEST_F(ServiceStart, StartsNothingThatIsHeldCancelledOrStoppedWhileItIsRehearsed) {
  for (const std::string method : {"hold", "cancel", "stop", "disarm"}) {
    const std::int64_t extends = submit_checked(kExtends);
    client_->call("arm");
    go_far();
    Json params = Json::object();
    if (method == "hold" || method == "cancel") params["entry"] = extends;
    // Both are in the socket long before the rehearsal, which takes a process, is over.
    BareConnection both(daemon_);
    both.say({{"id", 1}, {"method", "release"}, {"params", {{"entry", extends}}}});
    both.say({{"id", 2}, {"method", method}, {"params", params}});
    both.wait_for_answers(2);
    EXPECT_EQ(state_of(extends), method == "cancel" ? "cancelled" : "held") << method;
    client_->call("arm");
    EXPECT_EQ(follow(daemon_, submit(*client_, quiet_experiment_text("next", 2.0))).at("outcome"), "completed")
        << "what comes after it starts";
    EXPECT_EQ(state_of(extends), method == "cancel" ? "cancelled" : "held") << method;
    place_at(2.95);
    client_->call("disarm");
    if (method != "cancel") client_->call("cancel", {{"entry", extends}});
  }
}

TEST_F(ServiceStart, RehearsesAnewWhatWasStoppedAndReleasedMeanwhile) {
  const std::int64_t extends = submit_checked(kExtends);
  client_->call("arm");
  go_far();
  BareConnection quick(daemon_);
  int id = 0;
  for (int i = 0; i < 10; ++i) {
    quick.say({{"id", ++id}, {"method", "release"}, {"params", {{"entry", extends}}}});
    quick.say({{"id", ++id}, {"method", "stop"}});
    quick.say({{"id", ++id}, {"method", "arm"}});
  }
  quick.say({{"id", ++id}, {"method", "release"}, {"params", {{"entry", extends}}}});
  quick.wait_for_answers(id);
  expect_refused(follow(daemon_, extends));
}

TEST_F(ServiceStart, HoldsWhatItsClientLeftBeforeItBegan) {
  client_->call("arm");
  const std::int64_t on = submit(*client_, quiet_experiment_text("on", 8.0), false);
  std::int64_t attached = 0;
  {
    Client other(daemon_.socket());
    attached =
        other.call("submit", {{"experiment", quiet_experiment_text("attached", 2.0)}, {"fast", true}}).at("entry");
    EXPECT_EQ(state_of(attached), "waiting");
  }
  ASSERT_TRUE(reaches(attached, "held"));
  const std::int64_t detached = submit(*client_, quiet_experiment_text("detached", 2.0));
  EXPECT_EQ(follow(daemon_, on).at("outcome"), "completed");
  EXPECT_EQ(follow(daemon_, detached).at("outcome"), "completed") << "it needs no client";
  const Json left = entry_of(daemon_, attached);
  EXPECT_EQ(left.at("state"), "held");
  const std::string lost = "the connection of the command that submitted it was lost before it began";
  EXPECT_EQ(left.at("note"), lost);
  EXPECT_NE(left.at("waits_for").get<std::string>().find(lost), std::string::npos) << left;
  client_->call("release", {{"entry", attached}});
  EXPECT_EQ(follow(daemon_, attached).at("outcome"), "completed");
}

TEST_F(ServiceStart, GoesOnWithARunWhoseClientIsGone) {
  client_->call("arm");
  std::int64_t attached = 0;
  {
    Client other(daemon_.socket());
    attached = other.call("submit", {{"experiment", quiet_experiment_text("attached", 2.0)}}).at("entry");
    ASSERT_TRUE(daemon_.logs("runs in ")) << daemon_.log();
  }
  EXPECT_EQ(follow(daemon_, attached).at("outcome"), "completed");
}

TEST_F(ServiceStart, MovesARodByALittleOnlyFromWhereThatWasAskedFor) {
  client_->call("arm");
  const std::int64_t far = submit(*client_, placing_text(4.0), true);
  const std::int64_t little = submit(*client_, placing_text(3.05) + "from_in = 2.95\n");
  EXPECT_EQ(follow(daemon_, far).at("outcome"), "completed");
  const Json over = follow(daemon_, little);
  EXPECT_EQ(over.at("outcome"), "refused");
  EXPECT_NE(over.at("note").get<std::string>().find("it was asked for from 2.950 in, and the rod now stands at "),
            std::string::npos)
      << over;
  client_->call("arm");
  EXPECT_EQ(follow(daemon_, submit(*client_, placing_text(3.9) + "from_in = 4.0\n")).at("outcome"), "completed");
}

TEST_F(ServiceStart, DropsWhatItsClientLeftWhileItWasChecked) {
  client_->call("arm");
  {
    BareConnection bare(daemon_);
    bare.wait_for_answers(0);
    bare.say({{"id", 1},
              {"method", "submit"},
              {"params", {{"experiment", quiet_experiment_text("left", 2.0)}, {"fast", true}}}});
  }
  EXPECT_TRUE(daemon_.logs("(\"left\" of ")) << daemon_.log();
  EXPECT_TRUE(daemon_.logs("not queued: its command ended while it was checked")) << daemon_.log();
  EXPECT_TRUE(client_->call("queue").at("entries").empty());
}

TEST_F(ServiceStart, RefusesAMoveInsteadOfHoldingIt) {
  client_->call("arm");
  const std::int64_t on = submit(*client_, quiet_experiment_text("on", 600.0), false);
  const std::int64_t waits = submit(*client_, placing_text(3.2), false);
  client_->call("stop");
  const Json over = follow(daemon_, waits);
  EXPECT_EQ(over.at("outcome"), "refused");
  EXPECT_NE(over.at("note").get<std::string>().find("a move to a place is never held"), std::string::npos) << over;
  EXPECT_EQ(follow(daemon_, on).at("outcome"), "interrupted");
}

TEST_F(ServiceStart, RefusesAMoveWhoseRigIsDisarmedDuringItsCheck) {
  for (int i = 0; i < 10; ++i) {
    client_->call("arm");
    const BareConnection bare(daemon_);
    bare.say({{"id", 1}, {"method", "submit"}, {"params", {{"experiment", placing_text(3.2)}, {"detach", true}}}});
    // In any order: before it is read, during its check, before it begins.
    client_->call("stop");
    bare.wait_for_answers(1);
    for (const Json& entry : client_->call("queue").at("entries")) {
      EXPECT_EQ(entry.at("state"), "over") << i << ": " << entry;
      EXPECT_NE(entry.at("outcome"), "completed") << i << ": " << entry;
    }
  }
}

TEST_F(ServiceStart, HoldsWhatAKilledCommandHadQueued) {
  client_->call("arm");
  const std::int64_t on = submit(*client_, quiet_experiment_text("on", 600.0), false);
  std::ofstream(daemon_.folder() / "waits.toml") << quiet_experiment_text("waits", 2.0);
  const std::int64_t waits = on + 1;
  const Ended killed = interrupt_eha(
      {"run", "waits.toml", "--socket", daemon_.socket()}, daemon_.folder(),
      [&] {
        const Json entry = entry_of(daemon_, waits);
        return entry.is_object() && entry.at("state") == "waiting";
      },
      SIGKILL);
  ASSERT_EQ(killed.code, 128 + SIGKILL) << killed.err;
  EXPECT_TRUE(reaches(waits, "held"));
  EXPECT_EQ(state_of(on), "running");
}

TEST_F(ServiceStart, WaitsForNobodyToArmTheRigWithoutATerminal) {
  std::ofstream(daemon_.folder() / "quiet.toml") << quiet_experiment_text("quiet", 2.0);
  const Ended ended = run_eha({"run", "quiet.toml", "--fast", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::permission)) << ended.err;
  EXPECT_NE(ended.err.find("the rig is not armed, and experiment "), std::string::npos) << ended.err;
  for (const Json& entry : client_->call("queue").at("entries")) EXPECT_NE(entry.at("state"), "held") << entry;
}

TEST_F(ServiceStart, WaitsForNobodysLeaseWithoutATerminal) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  daemon_.open_to_all();
  connect_as(65534, daemon_)->call("arm");
  std::ofstream(daemon_.folder() / "quiet.toml") << quiet_experiment_text("quiet", 2.0);
  const Ended ended = run_eha({"run", "quiet.toml", "--fast", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::permission)) << ended.err;
  EXPECT_NE(ended.err.find("the lease is nobody's, and experiment "), std::string::npos) << ended.err;
  for (const Json& entry : client_->call("queue").at("entries")) EXPECT_NE(entry.at("state"), "held") << entry;
}

TEST_F(ServiceStart, WarnsAtArmingOfARigFileThatWasEditedAndNotRead) {
  EXPECT_EQ(run_eha({"arm", "--socket", daemon_.socket()}, daemon_.folder()).err.find("was edited"), std::string::npos);
  std::ofstream(daemon_.rig_file(), std::ios::app) << "# narrower\n";
  const Ended armed = run_eha({"arm", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_NE(armed.err.find("was edited since ehad read it, and the limits of before are in force"), std::string::npos)
      << armed.err;
}

TEST_F(ServiceStart, SaysWhatBecameOfTheRigFileThatItHasRead) {
  const std::vector<std::string> arm{"arm", "--socket", daemon_.socket()};
  const std::string sound = os::read_file(daemon_.rig_file());
  std::ofstream(daemon_.rig_file()) << sound;
  EXPECT_EQ(run_eha(arm, daemon_.folder()).err.find("since ehad read it"), std::string::npos) << "the same content";
  std::ofstream(daemon_.rig_file()) << sound << "command_max_V = = 3\n";
  const Ended torn = run_eha(arm, daemon_.folder());
  EXPECT_NE(torn.err.find("was edited since ehad read it and is not valid now, so that nothing begins to move ("),
            std::string::npos)
      << torn.err;
  EXPECT_NE(torn.err.find("correct it, then `eha reload"), std::string::npos) << torn.err;
  std::filesystem::remove(daemon_.rig_file());
  const Ended gone = run_eha(arm, daemon_.folder());
  EXPECT_NE(gone.err.find("is gone since ehad read it, and the limits of before are in force; put it back"),
            std::string::npos)
      << gone.err;
  const Ended status = run_eha({"status", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_NE(status.out.find("is gone since ehad read it"), std::string::npos) << status.out;
}

TEST_F(ServiceStart, MovesNothingOnLimitsWiderThanThoseOfTheEditedRigFile) {
  client_->call("arm");
  std::ofstream(daemon_.folder() / "quiet.toml") << quiet_experiment_text("quiet", 2.0);
  const std::string sound = os::read_file(daemon_.rig_file());
  std::ofstream(daemon_.rig_file(), std::ios::app) << "# a remark\n";
  const Ended remarked = run_eha({"goto", "3.2in", "--fast", "--socket", daemon_.socket()}, daemon_.folder());
  EXPECT_EQ(remarked.code, 0) << "an edit that narrows nothing: " << remarked.err;
  std::string narrower = sound;
  const std::string wide = "command_max_V = 5.0";
  ASSERT_NE(narrower.find(wide), std::string::npos);
  std::ofstream(daemon_.rig_file()) << narrower.replace(narrower.find(wide), wide.size(), "command_max_V = 3.0");
  for (std::vector<std::string> words : std::vector<std::vector<std::string>>{
           {"goto", "3.2in"}, {"jog", "+0.2in"}, {"run", "quiet.toml"}, {"characterise"}}) {
    words.insert(words.end(), {"--fast", "--socket", daemon_.socket()});
    const Ended refused = run_eha(words, daemon_.folder());
    EXPECT_EQ(refused.code, static_cast<int>(ExitCode::configuration)) << words.front() << refused.err;
    EXPECT_NE(refused.err.find("command_max 3 V (5 V in force)"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("eha disarm, eha reload, eha arm"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(client_->call("stop").at("stopped"), "disarmed");
  EXPECT_EQ(client_->call("disarm").at("state"), "idle");
  client_->call("reload");
  client_->call("arm");
  EXPECT_EQ(run_eha({"goto", "3.2in", "--fast", "--socket", daemon_.socket()}, daemon_.folder()).code, 0);
}

TEST_F(ServiceStart, GivesUpAHeldExperimentWhoseRigFileWasNarrowedMeanwhile) {
  const std::int64_t held = submit(*client_, quiet_experiment_text("held", 2.0), false);
  client_->call("arm");
  std::string text = os::read_file(daemon_.rig_file());
  const std::string wide = "command_max_V = 5.0";
  std::ofstream(daemon_.rig_file()) << text.replace(text.find(wide), wide.size(), "command_max_V = 3.0");
  client_->call("release", {{"entry", held}});
  EXPECT_TRUE(reaches(held, "over"));
  const Json entry = entry_of(daemon_, held);
  EXPECT_EQ(entry.at("outcome"), "refused") << entry;
  EXPECT_NE(entry.at("note").get<std::string>().find("command_max 3 V (5 V in force)"), std::string::npos) << entry;
}

TEST_F(ServiceStart, HoldsWhatACommandWithoutItsTerminalHadQueued) {
  // As `su -c` begins it: in a session of its own, so that the kernel does not tell it that the terminal is gone.
  os::FileDescriptor terminal(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_TRUE(terminal && grantpt(terminal.get()) == 0 && unlockpt(terminal.get()) == 0);
  client_->call("arm");
  const std::int64_t on = submit(*client_, quiet_experiment_text("on", 600.0), false);
  std::ofstream(daemon_.folder() / "waits.toml") << quiet_experiment_text("waits", 2.0);
  const std::int64_t waits = on + 1;
  const std::string command =
      fmt::format("cd '{0}' && setsid -f '{1}' run waits.toml --socket '{2}' <{3} >{3} 2>{3}",
                  daemon_.folder().string(), EHA_PROGRAM, daemon_.socket().string(), ptsname(terminal.get()));
  ASSERT_EQ(std::system(command.c_str()), 0);
  ASSERT_TRUE(reaches(waits, "waiting"));
  terminal.close();
  EXPECT_TRUE(reaches(waits, "held"));
  EXPECT_EQ(state_of(on), "running");
}

}  // namespace
}  // namespace eha::test
