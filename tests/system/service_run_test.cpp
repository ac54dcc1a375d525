// SPDX-License-Identifier: GPL-3.0-or-later
// An experiment's way through the whole service, over its socket, on the simulated rig.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// Starts an experiment of ten minutes on the real clock and waits until it plays.
std::int64_t start_long_run(const Daemon& daemon, Client& client) {
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  const Json playing = follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  EXPECT_EQ(playing.at("state"), "running");
  return entry;
}

TEST(Service, DrivesNothingOnArmAloneThatWasSubmittedBefore) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  std::string experiment = experiment_text("waits");
  const std::size_t model = experiment.find("[[model]]");
  experiment.replace(model, experiment.find("[acceptance]") - model,
                     "[[model]]\nname = \"io\"\nstructure = \"io\"\npoles = 1\nzeros = 0\n");
  const std::int64_t entry = submit(client, experiment);
  client.call("arm");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(client.call("status").at("state"), "armed");
  const std::string state = entry_of(daemon, entry).at("state");
  EXPECT_TRUE(state == "held" || state == "waiting") << state;
  EXPECT_TRUE(!fs::exists(daemon.runs()) || fs::is_empty(daemon.runs())) << "arming started it";
}

TEST(Service, StartsFaultedAndStartsWhatIsHeldOnlyOnItsRelease) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  EXPECT_EQ(client.call("status").at("state"), "faulted");
  const std::int64_t entry = submit(client, experiment_text("one"));
  EXPECT_EQ(client.call("status").at("held"), 1);
  EXPECT_EQ(entry_of(daemon, entry).at("state"), "held");
  EXPECT_EQ(refused(client, "release").code, static_cast<int>(ExitCode::permission)) << "nobody has armed";
  const Json armed = client.call("arm");
  EXPECT_EQ(armed.at("state"), "armed");
  ASSERT_EQ(armed.at("held").size(), 1U);
  EXPECT_EQ(armed.at("held").at(0).at("entry"), entry);
  EXPECT_EQ(entry_of(daemon, entry).at("state"), "held");
  EXPECT_EQ(client.call("release").at("released"), Json::array({entry}));
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("state"), "over");
  EXPECT_EQ(over.at("outcome"), "completed") << over;
  EXPECT_EQ(client.call("status").at("state"), "armed");
}

TEST(Service, PlaysTheSameRecordAsALocalRunAndMovesLatestOnAcceptance) {
  Daemon daemon;
  daemon.start();
  const fs::path experiment = source_file("config/experiments/paper.toml");
  Client(daemon.socket()).call("arm");
  const Ended served = run_eha({"run", experiment, "--fast", "--socket", daemon.socket(), "--json"}, daemon.folder());
  EXPECT_EQ(served.code, 0) << served.err << daemon.log();
  const Ended local = run_eha({"run", experiment, "--fast", "--local", "--rig", daemon.rig_file()}, daemon.folder());
  EXPECT_EQ(local.code, 0) << local.err;
  const fs::path run = Json::parse(served.out).at("run").get<std::string>();
  EXPECT_TRUE(fs::equivalent(run, daemon.runs() / "latest"));
  EXPECT_TRUE(fs::exists(run / "models" / "integrator_lag_valve.json"));
  EXPECT_EQ(content_of(run / "raw.ehalog"), content_of(daemon.folder() / "runs" / "latest" / "raw.ehalog"));
  EXPECT_EQ(content_of(run / "raw.h5"), content_of(daemon.folder() / "runs" / "latest" / "raw.h5"));
}

TEST(Service, RefusesAnExperimentWithFaultsAndNamesThemAll) {
  Daemon daemon;
  daemon.start();
  std::string text = experiment_text("bad");
  text.replace(text.find("duration_s"), 10, "duration_x");
  const TemporaryFolder folder;
  folder.write("bad.toml", text);
  const Ended ended = run_eha({"run", "bad.toml", "--socket", daemon.socket()}, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(ended.err.find("duration_x"), std::string::npos) << ended.err;
  EXPECT_EQ(Client(daemon.socket()).call("queue").at("entries").size(), 0U);
}

TEST(Service, RampsOutOnTheFirstStopAndDisarms) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  const std::int64_t next = submit(client, experiment_text("next"));
  EXPECT_EQ(client.call("stop").at("stopped"), "ramping_out");
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("outcome"), "interrupted");
  EXPECT_EQ(over.at("exit_code"), 130);
  const Json manifest = Json::parse(content_of(fs::path(over.at("folder").get<std::string>()) / "run.json"));
  EXPECT_EQ(manifest.at("report").at("fault"), nullptr);
  EXPECT_EQ(manifest.at("report").at("safe_confirmed"), true);
  // After a stop the next experiment must not move the rig.
  EXPECT_EQ(client.call("status").at("state"), "idle");
  EXPECT_EQ(entry_of(daemon, next).at("state"), "held");
}

TEST(Service, MakesTheRigSafeAtOnceOnTheSecondStop) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  client.call("stop");
  EXPECT_EQ(client.call("stop").at("stopped"), "safe_at_once");
  const Json over = follow(daemon, entry);
  EXPECT_EQ(over.at("outcome"), "interrupted");
  const Json manifest = Json::parse(content_of(fs::path(over.at("folder").get<std::string>()) / "run.json"));
  EXPECT_EQ(manifest.at("report").at("fault").at("cause"), "second_stop");
  EXPECT_EQ(client.call("status").at("state"), "faulted");
  const std::string told = client.call("arm").at("acknowledged");
  EXPECT_NE(told.find("second_stop"), std::string::npos) << told;
}

TEST(Service, StopsNothingWhenTheExperimentMeantIsNotOn) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  EXPECT_EQ(client.call("stop", {{"entry", entry + 1}}).at("stopped"), "nothing");
  EXPECT_EQ(client.call("status").at("state"), "running");
  EXPECT_EQ(client.call("stop", {{"entry", entry}}).at("stopped"), "ramping_out");
}

TEST(Service, RampsOutAndEndsOnSigterm) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  EXPECT_EQ(daemon.stop(SIGTERM), 0) << daemon.log();
  EXPECT_FALSE(fs::exists(daemon.socket()));
  daemon.start();
  const Json over = entry_of(daemon, entry);
  EXPECT_EQ(over.at("state"), "over");
  EXPECT_EQ(over.at("outcome"), "interrupted");
  EXPECT_NE(over.at("note").get<std::string>().find("(ehad was ended)"), std::string::npos) << over;
}

TEST(Service, RecoversTheRunAndStaysFaultedAfterSigkill) {
  Daemon daemon;
  daemon.start();
  std::int64_t entry = 0;
  {
    Client client(daemon.socket());
    entry = start_long_run(daemon, client);
    // The writer hands its blocks out each 100 ms: by then there is something to recover.
    follow(daemon, entry, [](const Json& snapshot) {
      return !snapshot.at("run").is_null() && snapshot.at("run").at("experiment_s") > 1.0;
    });
  }
  EXPECT_EQ(daemon.stop(SIGKILL), 128 + SIGKILL);
  daemon.start();
  Client client(daemon.socket());
  EXPECT_EQ(client.call("status").at("state"), "faulted");
  const Json over = entry_of(daemon, entry);
  EXPECT_EQ(over.at("state"), "over");
  EXPECT_EQ(over.at("outcome"), "recovered") << over;
  const fs::path run = over.at("folder").get<std::string>();
  EXPECT_GT(Json::parse(content_of(run / "run.json")).at("recovery").at("rows"), 400);
  EXPECT_TRUE(fs::exists(run / "raw.h5"));
  // The state names the death and the run until somebody arms, whoever restarts ehad meanwhile.
  const std::string reason = client.call("status").at("reason");
  EXPECT_EQ(reason, fmt::format("experiment {}: recovered: ehad ended during this run; run {}", entry,
                                over.at("run").get<std::string>()));
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
  daemon.start();
  Client later(daemon.socket());
  EXPECT_EQ(later.call("status").at("reason"), reason);
  EXPECT_EQ(later.call("arm").at("acknowledged"), reason);
  later.call("disarm");
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
  daemon.start();
  Client last(daemon.socket());
  EXPECT_EQ(last.call("status").at("reason"), "ehad has started") << "it was acknowledged";
  // Armed again it does not play it once more.
  last.call("arm");
  EXPECT_EQ(last.call("status").at("run"), nullptr);
}

TEST(Service, RecoversTheOtherRunsWhenOneCannotBe) {
  Daemon daemon;
  fs::create_directories(daemon.runs() / "20200101T000000Z-damaged");
  std::ofstream(daemon.runs() / "20200101T000000Z-damaged" / "raw.ehalog") << "not a journal";
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  daemon.stop(SIGKILL);
  daemon.start();
  EXPECT_EQ(entry_of(daemon, entry).at("outcome"), "recovered");
  EXPECT_NE(daemon.log().find("cannot be recovered"), std::string::npos);
}

TEST(Service, GoesOnWhenTheClientIsKilledAndStopsOnItsCtrlC) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const TemporaryFolder folder;
  folder.write("e.toml", quiet_experiment_text("long", 600.0));
  const auto plays = [&] { return client.call("status").at("state") == "running"; };
  const Ended killed = interrupt_eha({"run", "e.toml", "--socket", daemon.socket()}, folder.path(), plays, SIGKILL);
  EXPECT_EQ(killed.code, 128 + SIGKILL);
  EXPECT_TRUE(plays());
  client.call("stop");
  EXPECT_EQ(follow(daemon, 1).at("outcome"), "interrupted");

  client.call("arm");
  const Ended stopped = interrupt_eha({"run", "e.toml", "--socket", daemon.socket()}, folder.path(), plays, SIGINT);
  EXPECT_EQ(stopped.code, 130) << stopped.err;
  EXPECT_NE(stopped.err.find("ramping out"), std::string::npos) << stopped.err;
  EXPECT_EQ(entry_of(daemon, 2).at("outcome"), "interrupted");
  client.call("arm");
  const Ended ended = interrupt_eha({"run", "e.toml", "--socket", daemon.socket()}, folder.path(), plays, SIGTERM);
  EXPECT_EQ(ended.code, 130) << ended.err;
  const auto note_of = [&](int entry) { return entry_of(daemon, entry).at("note").get<std::string>(); };
  EXPECT_NE(note_of(1).find("(eha stop of "), std::string::npos) << note_of(1);
  EXPECT_NE(note_of(2).find("(Ctrl-C of "), std::string::npos) << note_of(2);
  EXPECT_NE(note_of(3).find("(SIGTERM to the command of "), std::string::npos) << note_of(3);
}

/// The process that checks an experiment for the service, if there is one now.
std::optional<pid_t> check_of(const Daemon& daemon) {
  for (const auto& task : fs::directory_iterator(fmt::format("/proc/{}/task", daemon.pid()))) {
    std::istringstream children(content_of(task.path() / "children"));
    for (pid_t child = 0; children >> child;) {
      if (content_of(fmt::format("/proc/{}/cmdline", child)).find("experiment.toml") != std::string::npos) return child;
    }
  }
  return std::nullopt;
}

TEST(Service, QueuesNothingAfterCtrlCDuringTheCheck) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const TemporaryFolder folder;
  folder.write("e.toml", quiet_experiment_text("unwanted", 600.0));
  std::optional<pid_t> check;
  const auto is_checked = [&] {
    if (!check) check = check_of(daemon);
    if (check) kill(*check, SIGSTOP);
    return check.has_value();
  };
  const Ended ended = interrupt_eha({"run", "e.toml", "--socket", daemon.socket()}, folder.path(), is_checked, SIGINT);
  kill(check.value(), SIGCONT);
  EXPECT_EQ(ended.code, 130) << ended.err;
  EXPECT_NE(ended.err.find("interrupted before it was queued; nothing was moved"), std::string::npos) << ended.err;
  EXPECT_TRUE(daemon.logs("not queued: its command ended while it was checked")) << daemon.log();
  EXPECT_TRUE(client.call("queue").at("entries").empty());
  EXPECT_EQ(client.call("status").at("state"), "armed");
}

TEST(Service, OffersTheRunOfAFaultAfterArming) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const Json over = follow(daemon, submit(client, faulting_experiment_text("bad"), false));
  const Ended armed = run_eha({"arm", "--socket", daemon.socket()}, "/");
  EXPECT_EQ(armed.code, 0) << armed.err;
  EXPECT_NE(armed.out.find("eha runs show " + over.at("run").get<std::string>()), std::string::npos) << armed.out;
}

TEST(Service, NamesBothRunsThatLatestMayBe) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const Json over = follow(daemon, submit(client, experiment_text("there")));
  const fs::path there = over.at("folder").get<std::string>();
  fs::remove(daemon.runs() / "latest");
  fs::create_directory_symlink(there.filename(), daemon.runs() / "latest");
  const TemporaryFolder folder;
  const std::string name = "20260101T000000Z-here";
  fs::create_directories(folder.path() / "runs" / name);
  fs::copy_file(there / "run.json", folder.path() / "runs" / name / "run.json");
  // The service's run where no other has that name.
  const auto show = [&] { return run_eha({"runs", "show", "latest", "--socket", daemon.socket()}, folder.path()); };
  const Ended of_service = show();
  EXPECT_EQ(of_service.code, 0) << of_service.err;
  EXPECT_NE(of_service.out.find((daemon.runs() / "latest").string()), std::string::npos) << of_service.out;
  fs::create_directory_symlink(name, folder.path() / "runs" / "latest");
  const Ended both = show();
  EXPECT_EQ(both.code, 0) << both.err;
  EXPECT_NE(both.out.find("runs/latest"), std::string::npos) << both.out;
  const std::string note = "latest is runs/latest; the service has another one, " + (daemon.runs() / "latest").string();
  EXPECT_NE(both.err.find(note), std::string::npos) << both.err;
  fs::rename(folder.path() / "runs" / name, folder.path() / "runs" / "renamed");
  const Ended renamed = run_eha({"runs", "show", "renamed", "--socket", daemon.socket()}, folder.path());
  EXPECT_EQ(renamed.code, 0) << renamed.err;
}

TEST(Service, CancelsWhatIsHeldOnTheClientsCtrlC) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const TemporaryFolder folder;
  folder.write("e.toml", experiment_text("waits"));
  const auto waits = [&] { return client.call("status").at("held") == 1; };
  const Ended ended = interrupt_eha({"run", "e.toml", "--socket", daemon.socket()}, folder.path(), waits, SIGINT);
  EXPECT_EQ(ended.code, 130) << ended.err;
  EXPECT_EQ(entry_of(daemon, 1).at("state"), "cancelled");
}

TEST(Service, DisarmsOnAFaultAndHoldsTheQueue) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t bad = submit(client, faulting_experiment_text("bad"), false);
  const std::int64_t good = submit(client, experiment_text("good"));
  EXPECT_EQ(entry_of(daemon, good).at("state"), "waiting");
  const Json over = follow(daemon, bad);
  EXPECT_EQ(over.at("outcome"), "faulted");
  EXPECT_EQ(over.at("exit_code"), static_cast<int>(ExitCode::safety_trip)) << over;
  const std::string note = over.at("note");
  EXPECT_NE(note.find("travel_limit"), std::string::npos) << over;
  EXPECT_NE(note.find("; `eha runs show " + over.at("run").get<std::string>() + "` says what to do"), std::string::npos)
      << "what the record shows is the one remedy: " << note;
  EXPECT_EQ(note.find("lower the excitation"), std::string::npos) << note;
  EXPECT_EQ(client.call("status").at("state"), "faulted");
  EXPECT_EQ(client.call("status").at("lease").at("uid"), geteuid()) << "the holder may be at the rod";
  EXPECT_EQ(entry_of(daemon, good).at("state"), "held");
  // The state says the fault with its limit and the run, for who was not at the terminal.
  const std::string reason = client.call("status").at("reason");
  EXPECT_NE(reason.find("faulted: travel_limit at "), std::string::npos) << reason;
  EXPECT_NE(reason.find("the limit is "), std::string::npos) << reason;
  EXPECT_NE(reason.find("; run " + over.at("run").get<std::string>()), std::string::npos) << reason;
  EXPECT_EQ(client.call("status").at("faulted_run"), over.at("run"));
  client.call("disarm");
  EXPECT_EQ(client.call("status").at("reason"), reason) << "letting go of the rig acknowledges nothing";
  const Json armed = client.call("arm");
  EXPECT_EQ(armed.at("acknowledged"), reason);
  EXPECT_EQ(armed.at("acknowledged_run"), over.at("run"));
  EXPECT_EQ(client.call("status").at("faulted_run"), nullptr);
  const Json again = client.call("arm");
  EXPECT_FALSE(again.contains("acknowledged") || again.contains("acknowledged_run")) << "armed already";
  const std::int64_t other = submit(client, experiment_text("other"));
  EXPECT_EQ(follow(daemon, other).at("outcome"), "completed");
  EXPECT_EQ(entry_of(daemon, good).at("state"), "held") << "the run of another one does not release it";
  client.call("release", {{"entry", good}});
  EXPECT_EQ(follow(daemon, good).at("outcome"), "completed");
}

TEST(Service, ListsItsRunsAlsoWhereThereAreOthers) {
  Daemon daemon;
  daemon.start();
  std::filesystem::create_directories(daemon.folder() / "runs");
  const std::string own = "no runs in " + daemon.runs().string();
  for (const auto& words : {std::vector<std::string>{"runs"}, {"runs", "list"}}) {
    std::vector<std::string> through = words;
    through.insert(through.end(), {"--socket", daemon.socket()});
    const Ended asked = run_eha(through, daemon.folder());
    EXPECT_EQ(asked.code, 0) << asked.err;
    EXPECT_NE(asked.out.find(own), std::string::npos) << asked.out;
    ::setenv("EHA_SOCKET", daemon.socket().c_str(), 1);
    const Ended here = run_eha(words, daemon.folder());
    ::unsetenv("EHA_SOCKET");
    EXPECT_NE(here.out.find("no runs in runs"), std::string::npos) << here.out;
    EXPECT_NE(here.err.find("the service keeps its own in " + daemon.runs().string() + ": eha runs --socket "),
              std::string::npos)
        << here.err;
  }
}

TEST(Service, RefusesToReloadWhileArmedAndSaysSo) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  EXPECT_EQ(refused(client, "reload").code, static_cast<int>(ExitCode::permission));
  daemon.send(SIGHUP);
  EXPECT_TRUE(daemon.logs("SIGHUP: not reloaded: the rig is armed"));
  client.call("disarm");
  daemon.send(SIGHUP);
  EXPECT_TRUE(daemon.hears("RELOADING=1"));
  EXPECT_TRUE(daemon.hears("READY=1"));
  EXPECT_TRUE(daemon.logs("configuration reloaded"));
}

TEST(Service, KeepsItsConfigurationWhenTheNewOneHasFaults) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::string sound = os::read_file(daemon.rig_file());
  std::ofstream(daemon.rig_file()) << "schema = 1\nname = \"other\"\n";
  const Refused answer = refused(client, "reload");
  EXPECT_EQ(answer.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(answer.message.find("rig.toml:"), std::string::npos) << answer.message;
  const Ended said = run_eha({"reload", "--socket", daemon.socket()}, daemon.folder());
  EXPECT_EQ(said.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(said.err.find("the configuration that ehad has read before stays in force"), std::string::npos) << said.err;
  EXPECT_EQ(client.call("status").at("rig").at("name"), "simulated rig");
  client.call("arm");
  EXPECT_THROW(submit(client, experiment_text("one")), Error) << "nobody can tell the limits that the file means";
  std::ofstream(daemon.rig_file()) << sound;
  EXPECT_EQ(follow(daemon, submit(client, experiment_text("one"))).at("outcome"), "completed");
}

TEST(Service, FeedsItsWatchdogAndTellsItsState) {
  Daemon daemon;
  daemon.start();
  EXPECT_TRUE(daemon.hears("WATCHDOG=1"));
  Client(daemon.socket()).call("arm");
  EXPECT_TRUE(daemon.hears("STATUS=armed by "));
}

TEST(Service, IsRefusedAFolderThatAnotherOneWorksIn) {
  Daemon daemon;
  daemon.start();
  const TemporaryFolder other;
  const std::string command = std::string(EHAD_PROGRAM) + " --rig " + daemon.rig_file().string() + " --state " +
                              (daemon.folder() / "state").string() + " --socket " + (other.path() / "s").string() +
                              " 2>" + (other.path() / "err").string();
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(ExitCode::device_unavailable));
  EXPECT_NE(content_of(other.path() / "err").find("another ehad"), std::string::npos);
}

}  // namespace
}  // namespace eha::test
