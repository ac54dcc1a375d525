// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/error.hpp"

// The protocol of ehad's socket, ehad-protocol(7): one JSON object on each line. These functions are pure.

namespace eha::control {

inline constexpr int kProtocolVersion = 1;
inline constexpr std::size_t kLongestRequest = 256 * 1024;     ///< of a request's line [bytes]
inline constexpr std::size_t kLongestExperiment = 128 * 1024;  ///< of an experiment's text [bytes]
inline constexpr double kFastestWatch_Hz = 25.0;

using Json = nlohmann::ordered_json;
using EntryId = std::int64_t;  ///< of an experiment in the queue, from 1

struct StatusCall {};
struct ArmCall {};
struct DisarmCall {};
struct SubmitCall {
  std::string experiment;                ///< TOML
  std::string name = "experiment.toml";  ///< for messages
  bool fast = false;                     ///< virtual time
};
struct StopCall {
  std::optional<EntryId> entry;  ///< stop only if this one is on
};
struct CancelCall {
  EntryId entry = 0;
};
struct WatchCall {
  double rate_Hz = 10.0;
  std::optional<EntryId> entry;  ///< until this one is over
  bool samples = false;          ///< with the blocks of samples since the last event
};
struct QueueCall {};
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
                          ReleaseCall, RunsCall, AckCall, RemoveCall, MetricsCall, ReloadCall>;

struct Request {
  std::int64_t id = 0;
  std::string method;
  Call call;
};

/// A line that is not a request, and the answer to it.
struct Refusal {
  Json id;              ///< the request's; null when it has none that is readable
  std::string message;  ///< printable, at most a few hundred bytes
};

/// Reads one line. Cost and memory: proportional to its length, whatever it contains. Thread-safe.
[[nodiscard]] std::variant<Request, Refusal> parse_request(std::string_view line);

/// Lines to send, with their newline; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string greeting_line();
[[nodiscard]] std::string result_line(std::int64_t id, const Json& result);
[[nodiscard]] std::string error_line(const Json& id, ExitCode code, std::string_view message);
[[nodiscard]] std::string event_line(std::int64_t watch_id, const Json& snapshot);

}  // namespace eha::control
