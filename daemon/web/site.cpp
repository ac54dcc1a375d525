// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/site.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "core/os/files.hpp"
#include "daemon/control/client.hpp"
#include "daemon/web/connection_owner.hpp"
#include "daemon/web/page_files.hpp"
#include "daemon/web/web_server.hpp"

namespace eha::web {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

constexpr const char* kJsonType = "application/json";
/// Content policy of the page: only its own files, no script or style within the HTML.
constexpr const char* kPagePolicy =
    "default-src 'self'; img-src 'self' data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";
/// Content policy of a report, one file with its plots and style: no script, no request.
constexpr const char* kReportPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; sandbox";
constexpr std::string_view kRunsPath = "/runs/";
constexpr std::string_view kStaticPath = "/static/";
constexpr std::size_t kMostRuns = 200;
constexpr auto kRunsInterval = 1s;
/// With the rest of the request's time it is 2 s at most.
constexpr std::chrono::milliseconds kStopPatience{1800};

void set_policy(httplib::Response& response, const char* policy) {
  response.headers.erase("Content-Security-Policy");
  response.set_header("Content-Security-Policy", policy);
}

/// Reads a query's whole number; `otherwise` if it is missing or none.
std::int64_t number_of(const httplib::Request& request, const char* key, std::int64_t otherwise) {
  const std::string text = request.get_param_value(key);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && !text.empty() ? value : otherwise;
}

bool send_page_file(std::string_view name, httplib::Response& response) {
  for (const PageFile& file : page_files()) {
    if (file.name != name) continue;
    set_policy(response, kPagePolicy);
    // Revalidated by the browser after an upgrade.
    response.headers.erase("Cache-Control");
    response.set_header("Cache-Control", "no-cache");
    response.set_content(file.content.data(), file.content.size(), std::string(file.content_type));
    return true;
  }
  return false;
}

const char* type_of(std::string_view path) {
  if (path.ends_with(".json")) return kJsonType;
  return path.ends_with(".csv") ? "text/csv; charset=utf-8" : "application/octet-stream";
}

/// Sends a file in pieces, so that its size needs no memory. A file that shrinks meanwhile ends the connection.
void send_file(RunFile file, const char* type, httplib::Response& response) {
  const auto shared = std::make_shared<RunFile>(std::move(file));
  response.status = 200;
  if (shared->size == 0) {
    response.set_content("", type);
    return;
  }
  response.set_content_provider(
      shared->size, type, [shared](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        constexpr std::size_t kPiece = 32 * 1024;
        std::string piece(std::min(length, kPiece), '\0');
        const std::size_t read =
            os::read_up_to_at(shared->descriptor, piece.data(), piece.size(), offset, "a run's file");
        return read > 0 && sink.write(piece.data(), read);
      });
}

}  // namespace

Site::Site(RunStore& store, const DaemonFeed& feed, ResponseMeter& meter, StopToken& token,
           std::filesystem::path socket)
    : store_(store), feed_(feed), meter_(meter), token_(token), socket_(std::move(socket)) {}

void Site::answer(const httplib::Request& request, httplib::Response& response, uid_t user) {
  const std::string& path = request.path;
  if (request.method == "POST") {
    if (path == "/api/stop") return stop(request, response, user);
    if (path == "/api/token") return check_token(request, response, user);
    return refuse(response, 405, "only /api/stop and /api/token take a POST");
  }
  if (path.starts_with("/api/")) return answer_api(request, response);
  if (path.starts_with(kRunsPath)) return answer_run(path, response);
  const bool is_sent = path == "/"
                           ? send_page_file("index.html", response)
                           : path.starts_with(kStaticPath) && send_page_file(path.substr(kStaticPath.size()), response);
  if (!is_sent) refuse(response, 404, "no such page");
}

void Site::answer_api(const httplib::Request& request, httplib::Response& response) {
  const std::string& path = request.path;
  if (path == "/api/state") {
    response.set_content(*feed_.state(), kJsonType);
  } else if (path == "/api/live") {
    response.set_content(feed_.live(number_of(request, "since", -1)), kJsonType);
  } else if (path == "/api/response") {
    response.set_content(*meter_.ask(), kJsonType);
  } else if (path == "/api/runs") {
    const std::int64_t limit = number_of(request, "limit", 50);
    response.set_content(runs(static_cast<std::size_t>(std::clamp<std::int64_t>(limit, 1, kMostRuns))), kJsonType);
  } else if (path == "/api/stop" || path == "/api/token") {
    refuse(response, 405, "expected a POST");
  } else {
    refuse(response, 404, "no such page");
  }
}

void Site::answer_run(const std::string& path, httplib::Response& response) const {
  const std::string_view rest = std::string_view(path).substr(kRunsPath.size());
  const std::size_t slash = rest.find('/');
  const std::string_view id = rest.substr(0, slash);
  const std::string_view what = slash == std::string_view::npos ? "" : rest.substr(slash + 1);
  constexpr std::string_view kFiles = "files/";
  if (what == "report.html") {
    if (std::optional<RunFile> file = store_.open(id, what)) {
      set_policy(response, kReportPolicy);
      return send_file(std::move(*file), "text/html; charset=utf-8", response);
    }
  } else if (what.starts_with(kFiles) && is_download(what.substr(kFiles.size()))) {
    const std::string_view name = what.substr(kFiles.size());
    if (std::optional<RunFile> file = store_.open(id, name)) {
      response.set_header("Content-Disposition",
                          fmt::format("attachment; filename=\"{}-{}\"", id, name.substr(name.rfind('/') + 1)));
      return send_file(std::move(*file), type_of(name), response);
    }
  }
  refuse(response, 404, "no such file of a run; it may have been removed");
}

std::string Site::runs(std::size_t most) {
  std::shared_ptr<const std::vector<std::string>> list;
  std::chrono::steady_clock::time_point listed;
  const auto take_kept = [&] {
    const std::lock_guard lock(runs_mutex_);
    list = runs_;
    listed = runs_listed_;
  };
  take_kept();
  const auto is_old = [&] { return !list || std::chrono::steady_clock::now() - listed >= kRunsInterval; };
  if (is_old()) {
    // During a reading of a slow disk other requests receive the previous list; the first ones wait for it.
    std::unique_lock listing(listing_, std::defer_lock);
    if (list) {
      static_cast<void>(listing.try_lock());
    } else {
      listing.lock();
      take_kept();
    }
    if (listing && is_old()) {
      std::vector<std::string> texts;
      for (const Json& run : store_.list(kMostRuns)) {
        texts.push_back(run.dump(-1, ' ', false, Json::error_handler_t::replace));
      }
      list = std::make_shared<const std::vector<std::string>>(std::move(texts));
      const std::lock_guard lock(runs_mutex_);
      runs_ = list;
      runs_listed_ = std::chrono::steady_clock::now();
    }
  }
  return fmt::format(
      "[{}]", fmt::join(list->begin(), list->begin() + static_cast<std::ptrdiff_t>(std::min(most, list->size())), ","));
}

bool Site::has_token(const httplib::Request& request, httplib::Response& response, uid_t user) {
  if (!request.get_header_value("Content-Type").starts_with(kJsonType)) {
    refuse(response, 415, "expected Content-Type: application/json");
    return false;
  }
  const std::optional<uid_t> known = user == kUnknownUser ? std::nullopt : std::optional(user);
  switch (token_.check(request.get_header_value("X-Eha-Token"), known, StopToken::Clock::now())) {
    case StopToken::Answer::right:
      return true;
    case StopToken::Answer::wrong:
      spdlog::warn("{}: wrong token of {}", request.path, known ? fmt::format("uid {}", *known) : "an unknown user");
      refuse(response, 401, "the token is missing or wrong; eha stop stops without one");
      return false;
    case StopToken::Answer::too_many:
      refuse(
          response, 429,
          fmt::format("too many wrong tokens from this user; wait {} s, or use eha stop", StopToken::kWindow.count()));
      return false;
  }
  return false;
}

void Site::check_token(const httplib::Request& request, httplib::Response& response, uid_t user) {
  if (has_token(request, response, user)) response.set_content(Json{{"valid", true}}.dump(), kJsonType);
}

void Site::stop(const httplib::Request& request, httplib::Response& response, uid_t user) {
  if (!has_token(request, response, user)) return;
  const auto deadline = std::chrono::steady_clock::now() + kStopPatience;
  const auto left = [&] {
    return std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  };
  std::string what;
  try {
    what = control::Client(socket_, left()).call("stop", Json::object(), left()).at("stopped").get<std::string>();
  } catch (const Error& error) {
    return refuse(response, 503,
                  fmt::format("ehad cannot be reached: use the emergency stop at the rig ({})", error.what()));
  }
  if (what == "nothing") return refuse(response, 409, "nothing was running");
  spdlog::info("stop: {}", what);
  response.set_content(Json{{"stopped", true}, {"result", what}}.dump(), kJsonType);
}

}  // namespace eha::web
