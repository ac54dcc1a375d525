// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/protocol.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "core/json_shape.hpp"
#include "core/text.hpp"

namespace eha::control {
namespace {

// An object that holds an object, and some spare.
constexpr JsonBounds kRequestBounds{.depth = 4, .values = 1000, .keys_of_object = 100};
constexpr std::size_t kLongestName = 256;
constexpr std::int64_t kGreatestPosition = 1000;
constexpr std::int64_t kGreatestSignal = 64;
constexpr std::int64_t kGreatestUid = 4294967294;                  // 2^32 - 1 is no user
constexpr std::int64_t kGreatestId = (std::int64_t{1} << 53) - 1;  // range that every JSON library preserves

/// Not ordered_json, which looks a key up by a linear search.
using Input = nlohmann::json;

/// Reason for refusing a request; becomes a Refusal.
struct BadRequest {
  std::string message;
};

std::string shown(const Input& value) {
  return shortened(value.dump(-1, ' ', true, Input::error_handler_t::replace), 40);
}

/// Reads the members of `params`, or of an object in it; a member that was not read is an error.
class Params {
 public:
  /// @param path  of the object, for messages
  explicit Params(const Input& values, std::string path = "params") : values_(values), path_(std::move(path)) {}

  [[nodiscard]] const Input* find(std::string_view key) {
    known_.push_back(key);
    const auto found = values_.find(key);
    return found == values_.end() || found->is_null() ? nullptr : &*found;
  }

  [[nodiscard]] std::optional<std::string> text(std::string_view key, std::size_t longest) {
    const Input* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) throw BadRequest{fmt::format("{}.{}: expected a text, got {}", path_, key, shown(*value))};
    auto text = value->get<std::string>();
    if (text.size() > longest) {
      throw BadRequest{fmt::format("{}.{}: expected at most {} bytes, got {}", path_, key, longest, text.size())};
    }
    return text;
  }

  [[nodiscard]] bool boolean(std::string_view key) {
    const Input* value = find(key);
    if (value == nullptr) return false;
    if (!value->is_boolean()) {
      throw BadRequest{fmt::format("{}.{}: expected true or false, got {}", path_, key, shown(*value))};
    }
    return value->get<bool>();
  }

  [[nodiscard]] std::optional<EntryId> entry() {
    const Input* value = find("entry");
    if (value == nullptr) return std::nullopt;
    if (!value->is_number_integer() || *value < 1 || *value > kGreatestId) {
      throw BadRequest{fmt::format("params.entry: expected the number of a queued experiment, got {}", shown(*value))};
    }
    return value->get<EntryId>();
  }

  [[nodiscard]] EntryId required_entry() {
    const auto named = entry();
    if (!named) throw BadRequest{"params.entry: expected the number of a queued experiment, got nothing"};
    return *named;
  }

  /// Reads a whole number from `least` to `greatest`; none if it is missing.
  [[nodiscard]] std::optional<std::int64_t> whole(std::string_view key, std::int64_t least,
                                                  std::int64_t greatest = kGreatestPosition) {
    const Input* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number_integer() || *value < least || *value > greatest) {
      throw BadRequest{fmt::format("{}.{}: expected a whole number from {} to {}, got {}", path_, key, least, greatest,
                                   shown(*value))};
    }
    return value->get<std::int64_t>();
  }

  [[nodiscard]] std::optional<double> number(std::string_view key) {
    const Input* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number())
      throw BadRequest{fmt::format("{}.{}: expected a number, got {}", path_, key, shown(*value))};
    return value->get<double>();
  }

  [[nodiscard]] std::optional<int> signal() {
    const auto number = whole("signal", 1);
    if (number && *number > kGreatestSignal) {
      throw BadRequest{fmt::format("params.signal: expected a signal's number, got {}", *number)};
    }
    return number ? std::optional<int>(static_cast<int>(*number)) : std::nullopt;
  }

  [[nodiscard]] std::string run() {
    const auto name = text("run", kLongestName);
    if (!name) throw BadRequest{"params.run: expected the name of a run's folder, got nothing"};
    return *name;
  }

  [[nodiscard]] double rate_Hz(double otherwise) {
    const Input* value = find("rate_Hz");
    if (value == nullptr) return otherwise;
    if (!value->is_number() || !(value->get<double>() > 0.0) || value->get<double>() > kFastestWatch_Hz) {
      throw BadRequest{fmt::format("params.rate_Hz: expected a number above 0, at most {}, got {}", kFastestWatch_Hz,
                                   shown(*value))};
    }
    return value->get<double>();
  }

  void finish() const {
    for (const auto& [key, value] : values_.items()) {
      bool is_known = false;
      for (const std::string_view name : known_) is_known = is_known || name == key;
      if (is_known) continue;
      throw BadRequest{fmt::format(
          "{}.{}: {}", path_, shortened(key, 40),
          known_.empty() ? "this method takes no parameters" : "expected a known parameter" + suggestion(key, known_))};
    }
  }

 private:
  const Input& values_;
  std::string path_;
  std::vector<std::string_view> known_;
};

SubmittedExperiment read_experiment(Params& params, const std::string& path) {
  SubmittedExperiment experiment;
  const auto text = params.text("experiment", kLongestExperiment);
  if (!text) throw BadRequest{path + ".experiment: expected the text of an experiment file, got nothing"};
  experiment.text = *text;
  if (const auto name = params.text("name", kLongestName)) experiment.name = shortened(*name, kLongestName);
  return experiment;
}

Call read_submit(Params& params) {
  SubmitCall submit;
  if (const Input* list = params.find("experiments")) {
    if (!list->is_array() || list->empty() || list->size() > kMostExperiments) {
      throw BadRequest{fmt::format("params.experiments: expected a list of 1 to {} experiments", kMostExperiments)};
    }
    submit.is_list = true;
    for (std::size_t i = 0; i < list->size(); ++i) {
      const std::string path = fmt::format("params.experiments[{}]", i);
      if (!(*list)[i].is_object()) throw BadRequest{path + ": expected an object, got " + shown((*list)[i])};
      Params one((*list)[i], path);
      submit.experiments.push_back(read_experiment(one, path));
      one.finish();
    }
  } else {
    submit.experiments.push_back(read_experiment(params, "params"));
  }
  submit.fast = params.boolean("fast");
  submit.accept_travel_risk = params.boolean("accept_travel_risk");
  submit.ruler_in = params.number("ruler_in");
  submit.detach = params.boolean("detach");
  return submit;
}

Call read_move(Params& params) {
  MoveCall move{.entry = params.required_entry()};
  const auto to = params.whole("to", 1);
  const auto by = params.whole("by", -kGreatestPosition);
  if (to.has_value() == by.has_value()) throw BadRequest{"params: expected either to or by"};
  move.to = to.value_or(0);
  move.by = by.value_or(0);
  return move;
}

Call read_watch(Params& params) {
  WatchCall watch;
  watch.rate_Hz = params.rate_Hz(watch.rate_Hz);
  watch.entry = params.entry();
  watch.samples = params.boolean("samples");
  return watch;
}

using Reader = Call (*)(Params&);
constexpr std::array<std::pair<std::string_view, Reader>, 16> kMethods{{
    {"status", [](Params&) -> Call { return StatusCall{}; }},
    {"arm",
     [](Params& params) -> Call {
       return ArmCall{params.number("ruler_in"), params.whole("take_from", 0, kGreatestUid)};
     }},
    {"disarm", [](Params&) -> Call { return DisarmCall{}; }},
    {"submit", read_submit},
    {"stop",
     [](Params& params) -> Call {
       return StopCall{params.entry(), params.signal()};
     }},
    {"cancel", [](Params& params) -> Call { return CancelCall{params.required_entry()}; }},
    {"watch", read_watch},
    {"queue", [](Params& params) -> Call { return QueueCall{params.whole("over", 0)}; }},
    {"hold", [](Params& params) -> Call { return HoldCall{params.entry()}; }},
    {"move", read_move},
    {"release", [](Params& params) -> Call { return ReleaseCall{params.entry()}; }},
    {"runs", [](Params&) -> Call { return RunsCall{}; }},
    {"ack", [](Params& params) -> Call { return AckCall{params.run()}; }},
    {"remove", [](Params& params) -> Call { return RemoveCall{params.run()}; }},
    {"metrics", [](Params&) -> Call { return MetricsCall{}; }},
    {"reload", [](Params&) -> Call { return ReloadCall{}; }},
}};

Call read_call(const std::string& method, const Input& values) {
  std::vector<std::string_view> names;
  for (const auto& [name, read] : kMethods) {
    names.push_back(name);
    if (name != method) continue;
    Params params(values);
    Call call = read(params);
    params.finish();
    return call;
  }
  throw BadRequest{
      fmt::format("method \"{}\": expected a known one{}", shortened(method, 40), suggestion(method, names))};
}

Input parse_shallow(std::string_view line) {
  const JsonShape shape = json_shape(line, kRequestBounds, JsonKeys::unique);
  switch (shape.fault) {
    case JsonFault::too_deep:
      throw BadRequest{fmt::format("a request nests at most {} levels", kRequestBounds.depth)};
    case JsonFault::too_many_values:
      throw BadRequest{fmt::format("a request holds at most {} values", kRequestBounds.values)};
    case JsonFault::too_many_keys:
      throw BadRequest{fmt::format("a request has at most {} keys in an object", kRequestBounds.keys_of_object)};
    case JsonFault::repeated_key:
      throw BadRequest{fmt::format("{}: the key is there twice", shortened(shape.key, 40))};
    case JsonFault::none:
    case JsonFault::syntax:
      break;
  }
  const Input request = Input::parse(line, nullptr, false);
  if (request.is_discarded()) throw BadRequest{"not JSON; expected {\"id\":1,\"method\":\"status\"} on one line"};
  if (!request.is_object())
    throw BadRequest{"expected an object {\"id\":1,\"method\":\"status\"}, got " + shown(request)};
  return request;
}

std::string dump_line(const Json& line) { return text_of(line) + "\n"; }

}  // namespace

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::variant<Request, Refusal> parse_request(std::string_view line) {
  Json id;
  try {
    const Input object = parse_shallow(line);
    const auto found = object.find("id");
    if (found == object.end() || !found->is_number_integer() || *found < 0 || *found > kGreatestId) {
      throw BadRequest{fmt::format("id: expected a whole number from 0 to {}, got {}", kGreatestId,
                                   found == object.end() ? "nothing" : shown(*found))};
    }
    id = found->get<std::int64_t>();
    Request request{.id = id.get<std::int64_t>(), .method = {}, .call = {}};
    const auto method = object.find("method");
    if (method == object.end() || !method->is_string()) throw BadRequest{"method: expected a text"};
    request.method = method->get<std::string>();
    const auto params = object.find("params");
    if (params != object.end() && !params->is_object()) {
      throw BadRequest{"params: expected an object, got " + shown(*params)};
    }
    request.call = read_call(request.method, params != object.end() ? *params : Input::object());
    for (const auto& [key, value] : object.items()) {
      if (key == "id" || key == "method" || key == "params") continue;
      throw BadRequest{fmt::format("{}: expected id, method and params only", shortened(key, 40))};
    }
    return request;
  } catch (const BadRequest& bad) {
    return Refusal{id, bad.message};
  }
}

std::string greeting_line() { return dump_line({{"ehad", EHA_VERSION}, {"protocol", kProtocolVersion}}); }

std::string result_line(std::int64_t id, const Json& result) { return dump_line({{"id", id}, {"result", result}}); }

std::pair<std::string, std::string> around_result(std::int64_t id) {
  return {fmt::format("{{\"id\":{},\"result\":", id), "}\n"};
}

std::string error_line(const Json& id, ExitCode code, std::string_view message) {
  return dump_line({{"id", id}, {"error", {{"code", static_cast<int>(code)}, {"message", message}}}});
}

std::string event_line(std::int64_t watch_id, const Json& snapshot) {
  return dump_line({{"watch", watch_id}, {"snapshot", snapshot}});
}

}  // namespace eha::control
