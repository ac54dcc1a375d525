// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.hpp"

// The protocol of ehad's socket, ehad-protocol(7): one JSON object on each line. These functions are pure.

namespace eha::control {

inline constexpr int kProtocolVersion = 1;
inline constexpr std::size_t kLongestRequest = 256 * 1024;     ///< of a request's line [bytes]
inline constexpr std::size_t kLongestExperiment = 128 * 1024;  ///< of an experiment's text [bytes]
inline constexpr std::size_t kMostExperiments = 20;            ///< of one submit
inline constexpr double kFastestWatch_Hz = 25.0;

using Json = nlohmann::ordered_json;
using EntryId = std::int64_t;  ///< of an experiment in the queue, from 1

struct StatusCall {};
struct ArmCall {
  std::optional<double> ruler_in = {};         ///< where a ruler shows the rod [in]
  std::optional<std::int64_t> take_from = {};  ///< user id of the holder whose lease root takes over
};
struct DisarmCall {};
struct SubmittedExperiment {
  std::string text;                      ///< TOML
  std::string name = "experiment.toml";  ///< for messages
};
struct SubmitCall {
  std::vector<SubmittedExperiment> experiments;  ///< 1 to kMostExperiments, in their starting order
  bool is_list = false;                          ///< answered with a list
  bool fast = false;                             ///< virtual time
  bool accept_travel_risk = false;               ///< queue even if the rehearsal refuses
  std::optional<double> ruler_in = {};           ///< where a ruler shows the rod [in]
  bool detach = false;                           ///< may start after this connection has ended
};
struct StopCall {
  std::optional<EntryId> entry;    ///< stop only if this one is running
  std::optional<int> signal = {};  ///< by which its command was told to stop
};
struct CancelCall {
  EntryId entry = 0;
};
struct HoldCall {
  std::optional<EntryId> entry;  ///< none: every waiting experiment of the caller
};
struct MoveCall {
  EntryId entry = 0;
  std::int64_t to = 0;  ///< position among those of its submitter, from 1; 0: see `by`
  std::int64_t by = 0;  ///< positions towards the end; negative: towards the front
};
struct WatchCall {
  double rate_Hz = 10.0;
  std::optional<EntryId> entry;  ///< until this one is over
  bool samples = false;          ///< events contain the blocks of samples since the last one
};
struct QueueCall {
  std::optional<std::int64_t> over;  ///< greatest number of completed ones, the newest; none: all
};
struct ReleaseCall {
  std::optional<EntryId> entry;  ///< none: every held experiment of the caller
};
struct RunsCall {};
struct AckCall {
  std::string run;  ///< name of its folder
};
struct RemoveCall {
  std::string run;  ///< name of its folder
};
struct MetricsCall {};
struct ReloadCall {};

using Call = std::variant<StatusCall, ArmCall, DisarmCall, SubmitCall, StopCall, CancelCall, WatchCall, QueueCall,
                          HoldCall, ReleaseCall, MoveCall, RunsCall, AckCall, RemoveCall, MetricsCall, ReloadCall>;

struct Request {
  std::int64_t id = 0;
  std::string method;
  Call call;
};

/// A line that is not a request, and the answer to it.
struct Refusal {
  Json id;              ///< the request's; null if it has no readable one
  std::string message;  ///< printable, at most a few hundred bytes
};

/// Reads one line. Cost and memory: proportional to its length, for any content. Thread-safe.
[[nodiscard]] std::variant<Request, Refusal> parse_request(std::string_view line);

/// JSON as it is sent, on one line.
[[nodiscard]] std::string text_of(const Json& json);

/// Lines to send, with their newline; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string greeting_line();
[[nodiscard]] std::string result_line(std::int64_t id, const Json& result);
/// What stands before and after the text of the result in result_line().
[[nodiscard]] std::pair<std::string, std::string> around_result(std::int64_t id);
[[nodiscard]] std::string error_line(const Json& id, ExitCode code, std::string_view message);
[[nodiscard]] std::string event_line(std::int64_t watch_id, const Json& snapshot);

}  // namespace eha::control
