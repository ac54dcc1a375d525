// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_follower.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/service_text.hpp"

namespace eha::cli {

using control::Client;

namespace {

/// Interval of the reminders of a held experiment.
constexpr auto kReminder = std::chrono::minutes(1);
/// Without a terminal nobody is asked to arm the rig: a held experiment is not waited for longer.
constexpr auto kLongestUnarmed = std::chrono::seconds(5);
constexpr const char* kOfArming = "eha arm, then ";
constexpr std::string_view kOfLease = "the lease of ";

/// "experiment 7"; a move to a place is none of a user's files: "the move (number 7 of the queue)".
std::string name_of(const nlohmann::ordered_json& entry, std::int64_t experiment) {
  return entry.value("only_places", false) ? fmt::format("the move (number {} of the queue)", experiment)
                                           : fmt::format("experiment {}", experiment);
}

enum class HeldText { first, reminder };

/// Says that a held experiment is not played, and the commands that start it. @param reason  the service's
std::string held_text(const std::string& experiment, const std::string& reason, const std::string& arm,
                      const std::string& release, HeldText kind) {
  if (!reason.starts_with(kOfArming)) {
    if (kind == HeldText::reminder) return fmt::format("{} is still held", experiment);
    return fmt::format(
        "{} is held and waits for {}; type that in another terminal, or Ctrl-C here, which removes it from "
        "the queue",
        experiment, reason);
  }
  const std::string why = wait_of(reason).why;
  return fmt::format("the rig is not armed, and {} is {}held{}; in another terminal: `{} && {}`{}", experiment,
                     kind == HeldText::reminder ? "still " : "", why.empty() ? "" : " (" + why + ")", arm, release,
                     kind == HeldText::reminder  ? ""
                     : isatty(STDIN_FILENO) == 1 ? "; Ctrl-C here removes it from the queue"
                                                 : "; without a terminal this command does not wait for that");
}

}  // namespace

RunFollower::RunFollower(std::filesystem::path socket, Client& client, std::vector<std::int64_t> queued,
                         DisplayUnit unit, Console& console)
    : socket_(std::move(socket)),
      client_(client),
      queued_(std::move(queued)),
      unit_(std::move(unit)),
      console_(console) {}

std::optional<RunFollower::Json> RunFollower::follow(std::int64_t experiment, StopOnSignals& stop, Held held) {
  try {
    return watch(experiment, stop, held);
  } catch (const control::ConnectionLost& lost) {
    console_.end_progress();
    throw DeviceError(fmt::format("{}; {}; its present state is unknown, see {}", lost.what(), last_heard(experiment),
                                  through(socket_, "eha status")));
  }
}

std::optional<RunFollower::Json> RunFollower::watch(std::int64_t experiment, StopOnSignals& stop, Held held) {
  client_.call("watch", {{"entry", experiment}, {"rate_Hz", 10.0}});
  for (;;) {
    stop.notice_lost_terminal();
    if (stop.count() > stops_seen_) {
      stops_seen_ = stop.count();
      if (!pass_on_stop(stop.signal())) return std::nullopt;
    }
    const std::optional<Json> status = client_.next_event(std::chrono::milliseconds(500));
    if (!status) continue;
    last_ = *status;
    last_at_ = std::chrono::steady_clock::now();
    const Json& entry = last_.at("entry");
    if (status->value("last", false) || (held == Held::leave && entry.at("state") == "held")) {
      console_.end_progress();
      return entry;
    }
    show(experiment, last_);
  }
}

void RunFollower::show(std::int64_t experiment, const Json& status) {
  const Json& entry = status.at("entry");
  const std::string state = entry.at("state");
  const Json& run = status.at("run");
  const std::string waits_for = entry.value("waits_for", "");
  const bool waits_for_somebody = waits_for.starts_with(kOfArming) || waits_for.starts_with(kOfLease);
  end_long_wait(experiment, state == "held" && waits_for_somebody ? waits_for : "");
  if (state == "waiting" || state == "held") {
    const std::string reason = entry.value("waits_for", "");
    const std::string name = name_of(entry, experiment);
    const auto now = std::chrono::steady_clock::now();
    if (reason != reason_ || (state == "held" && now - reminded_at_ >= kReminder)) {
      std::string now_played;
      if (!run.is_null()) {
        const RunProgress progress = progress_of(status);
        const auto number = run.at("entry").get<std::int64_t>();
        now_played =
            progress.exploring_at_most_s > 0.0
                ? fmt::format(", experiment {} explores before its {:.0f} s, for {} at most", number, progress.total_s,
                              duration_text(progress.exploring_at_most_s - progress.elapsed_s))
                : fmt::format(", experiment {} is at {:.0f} of {:.0f} s", number, progress.played_s, progress.total_s);
      }
      console_.info(state != "held" ? fmt::format("{} waits for {}{}; Ctrl-C here removes it from the queue", name,
                                                  reason, now_played)
                                    : held_text(name, reason, through(socket_, "eha arm"),
                                                through(socket_, fmt::format("eha queue release {}", experiment)),
                                                reason == reason_ ? HeldText::reminder : HeldText::first));
      reminded_at_ = now;
    }
    reason_ = reason;
    return;
  }
  if (!run.is_null()) {
    const std::int64_t on = run.at("entry");
    if (std::find(queued_.begin(), queued_.end(), on) != queued_.end()) {
      const std::string number = queued_.size() > 1 ? fmt::format("{}: ", on) : "";
      console_.show_run(number + run_line(progress_of(status), unit_, std::chrono::system_clock::now()));
      return;
    }
  }
  if (state != "fitting") return;
  const Json worker = status.value("worker", Json());
  const std::int64_t fitted = worker.is_object() ? worker.value("entry", experiment) : experiment;
  if (fitted == experiment) {
    console_.show_run(name_of(entry, experiment) + " " + progress_text(entry));
  } else if (const std::string reason = fmt::format("the fit of {}", fitted); reason != reason_) {
    console_.info(fmt::format("{} is recorded and waits for {}", name_of(entry, experiment), reason));
    reason_ = reason;
  }
}

void RunFollower::end_long_wait(std::int64_t experiment, const std::string& waits_for) {
  const auto now = std::chrono::steady_clock::now();
  if (waits_for.empty() || isatty(STDIN_FILENO) == 1) {
    unarmed_since_.reset();
    return;
  }
  if (!unarmed_since_) unarmed_since_ = now;
  if (now - *unarmed_since_ < kLongestUnarmed) return;
  pass_on_stop(std::nullopt);
  const bool is_anothers = waits_for.starts_with(kOfLease);
  const std::string why =
      is_anothers
          ? fmt::format("the lease is {}'s", waits_for.substr(kOfLease.size(), waits_for.find(',') - kOfLease.size()))
          : "the rig is not armed";
  throw PermissionError(fmt::format(
      "{}, and experiment {} was removed from the queue; in a script `{}` comes first; with --detach it stays in the "
      "queue, held",
      why, experiment, through(socket_, "eha arm")));
}

bool RunFollower::pass_on_stop(std::optional<int> signal) {
  console_.end_progress();
  // A second connection, because waiting for an answer on the first would skip the last event.
  Client other(socket_);
  bool can_change = false;
  const auto end = [&](std::int64_t number) {
    const Json which{{"entry", number}};
    const Json answer = [&] {
      if (!signal) return other.call("stop", which);
      try {
        return other.call("stop", {{"entry", number}, {"signal", *signal}});
      } catch (const Error& error) {
        if (error.exit_code() != ExitCode::usage) throw;
        return other.call("stop", which);  // an ehad from before an upgrade, which knows no signal, stops all the same
      }
    }();
    if (answer.at("stopped") == "nothing") return;
    can_change = true;
    console_.info(answer.at("stopped") == "safe_at_once" ? "making the rig safe at once"
                                                         : "ramping out, and the rig is disarmed then; Ctrl-C again "
                                                           "makes it safe at once");
  };
  // Ends the driven experiment first.
  for (const std::int64_t number : queued_) end(number);
  const Json queue = other.call("queue");
  for (const Json& entry : queue.at("entries")) {
    const std::int64_t number = entry.at("entry");
    if (std::find(queued_.begin(), queued_.end(), number) == queued_.end()) continue;
    if (entry.at("state") != "waiting" && entry.at("state") != "held") continue;
    try {
      other.call("cancel", {{"entry", number}});
      can_change = true;
    } catch (const control::ConnectionLost&) {
      throw;
    } catch (const Error&) {
      end(number);  // it has started in the meantime
    }
  }
  if (!can_change) console_.info("the run is over; ehad keeps fitting it, see " + through(socket_, "eha status"));
  return can_change;
}

std::string RunFollower::last_heard(std::int64_t number) const {
  if (last_.is_null()) return fmt::format("experiment {} was queued, no status received since", number);
  const Json& entry = last_.at("entry");
  std::string text = fmt::format("heard last, {:.0f} s ago: experiment {} was {}",
                                 std::chrono::duration<double>(std::chrono::steady_clock::now() - last_at_).count(),
                                 number, entry.at("state") == "over" ? "over" : entry.at("state").get<std::string>());
  if (entry.value("only_places", false)) {
    text += ", and a move whose command is gone is not begun";
  } else if (entry.at("state") == "waiting" || entry.at("state") == "held") {
    text += fmt::format(" and does not start before {}", through(socket_, fmt::format("eha queue release {}", number)));
  }
  if (const Json& run = last_.at("run"); !run.is_null() && run.at("entry") == number) {
    const RunProgress progress = progress_of(last_);
    text += fmt::format(", {:.1f} of {:.1f} s played, rig {}, rod at {:.3f} {}", progress.played_s, progress.total_s,
                        last_.value("state", "?"), unit_.factor("in") * progress.displacement_in, unit_.of("in"));
  }
  return text;
}

}  // namespace eha::cli
