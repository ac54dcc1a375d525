// SPDX-License-Identifier: GPL-3.0-or-later
// Input of ehad's socket: for any bytes in any pieces, lines stay bounded, and each is a request or a refusal that one
// line of JSON can answer. The result does not depend on the pieces.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "daemon/control/line_buffer.hpp"
#include "daemon/control/protocol.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using eha::control::Json;
using eha::control::LineBuffer;
using eha::control::Refusal;
using eha::control::Request;
using eha::fuzz::require;

constexpr std::size_t kLongest = 4096;

/// The lines of a stream that arrives in pieces of `piece` bytes, until one is too long.
std::vector<std::string> lines_of(std::string_view bytes, std::size_t piece) {
  LineBuffer buffer(kLongest);
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    const std::string_view part = bytes.substr(0, piece);
    bytes.remove_prefix(part.size());
    buffer.append(part);
    while (auto line = buffer.next_line()) {
      require(line->size() <= kLongest && line->find('\n') == std::string::npos, "a line is a line, and bounded");
      lines.push_back(std::move(*line));
    }
    if (buffer.is_too_long()) break;
    require(buffer.size() <= kLongest, "no more than a line is kept");
  }
  return lines;
}

void require_one_json_line(const std::string& text) {
  require(!text.empty() && std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n', "one line");
  require(Json::accept(text), "an answer is JSON");
}

void check_request(const std::string& line) {
  const std::variant<Request, Refusal> parsed = eha::control::parse_request(line);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) {
    require(!refusal->message.empty() && refusal->message.size() < 1000, "a refusal says why, in short");
    require(std::all_of(refusal->message.begin(), refusal->message.end(), [](char c) { return c >= ' ' && c <= '~'; }),
            "a refusal has printable characters only");
    require_one_json_line(eha::control::error_line(refusal->id, eha::ExitCode::usage, refusal->message));
    return;
  }
  const auto& request = std::get<Request>(parsed);
  require(request.id >= 0, "an id is no negative number");
  require_one_json_line(eha::control::result_line(request.id, Json{{"method", request.method}}));
  if (const auto* submit = std::get_if<eha::control::SubmitCall>(&request.call)) {
    require(!submit->experiments.empty() && submit->experiments.size() <= eha::control::kMostExperiments,
            "there are some experiments, and not too many");
    for (const eha::control::SubmittedExperiment& experiment : submit->experiments) {
      require(experiment.text.size() <= eha::control::kLongestExperiment, "an experiment is bounded");
      require(std::all_of(experiment.name.begin(), experiment.name.end(), [](char c) { return c >= ' ' && c <= '~'; }),
              "a name is printable");
    }
  }
  if (const auto* watch = std::get_if<eha::control::WatchCall>(&request.call)) {
    require(watch->rate_Hz > 0.0 && watch->rate_Hz <= eha::control::kFastestWatch_Hz, "a watch has a sane rate");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::vector<std::string> lines = lines_of(bytes, std::max<std::size_t>(size, 1));
  const std::vector<std::string> in_pieces = lines_of(bytes, size > 0 ? data[0] % 64U + 1U : 1U);
  require(lines == in_pieces, "how the bytes are cut makes no difference");
  for (const std::string& line : lines) check_request(line);
  return 0;
}
