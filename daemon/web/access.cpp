// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/text.hpp"

namespace eha::web {
namespace {

constexpr std::size_t kLongestTarget = 512;
constexpr std::size_t kLongestShown = 60;

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

bool is_name_character(char c) {
  return (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '-' || c == '.' || c == '_';
}

/// Returns the name of "name:port", and whether there is a port.
struct SplitHost {
  std::string_view name;
  bool has_port = false;
};

SplitHost split(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  const bool has_port = colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos &&
                        (host.front() == '[' || host.find(':') == colon);
  return {has_port ? host.substr(0, colon) : host, has_port};
}

}  // namespace

bool is_host(std::string_view text) {
  if (text.empty() || text.size() > 255) return false;
  const SplitHost host = split(text);
  if (host.has_port) {
    const std::string_view port = text.substr(host.name.size() + 1);
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (port.empty() || port.size() > 5 || !std::all_of(port.begin(), port.end(), is_digit)) return false;
  }
  if (host.name.size() > 2 && host.name.front() == '[' && host.name.back() == ']') {
    const std::string_view address = host.name.substr(1, host.name.size() - 2);
    return std::all_of(address.begin(), address.end(),
                       [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0 || c == ':'; });
  }
  return !host.name.empty() && std::all_of(host.name.begin(), host.name.end(), is_name_character);
}

AccessRules::AccessRules(std::uint16_t port, const std::vector<std::string>& allowed_hosts) {
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
    hosts_.push_back(fmt::format("{}:{}", name, port));
    // A browser omits the usual port.
    if (port == 80) hosts_.emplace_back(name);
  }
  for (const std::string& name : allowed_hosts) hosts_.push_back(lower(name));
}

bool AccessRules::is_allowed(std::string_view host) const {
  if (!is_host(host)) return false;
  const std::string asked = lower(host);
  const std::string name(split(asked).name);
  // A name without a port allows every port.
  return std::find(hosts_.begin(), hosts_.end(), asked) != hosts_.end() ||
         std::find(hosts_.begin(), hosts_.end(), name) != hosts_.end();
}

std::optional<Denial> AccessRules::check(const RequestHead& head) const {
  if (head.method != "GET" && head.method != "HEAD" && head.method != "POST") {
    return Denial{405, fmt::format("method {}: expected GET, HEAD or POST", shortened(head.method, kLongestShown))};
  }
  if (head.host.size() != 1 || !is_allowed(head.host.front())) {
    return Denial{403,
                  fmt::format("the address \"{}\" is not one of this page; open http://{}, or start eha-web with "
                              "--allow-host NAME",
                              head.host.empty() ? "" : shortened(head.host.front(), kLongestShown), hosts_.front())};
  }
  const bool is_post = head.method == "POST";
  if (head.origin.size() > 1 || (is_post && head.origin.empty()) ||
      (!head.origin.empty() && lower(head.origin.front()) != "http://" + lower(head.host.front()))) {
    return Denial{403, fmt::format("the origin \"{}\" is not this page",
                                   head.origin.empty() ? "" : shortened(head.origin.front(), kLongestShown))};
  }
  const std::string_view path = head.target.substr(0, head.target.find('?'));
  if (!head.fetch_site.empty()) {
    const std::string& site = head.fetch_site.front();
    const bool is_link = !is_post && path == "/" && !head.fetch_mode.empty() && head.fetch_mode.front() == "navigate";
    if (site != "same-origin" && site != "none" && !is_link) {
      return Denial{403, "the request comes from another site; open the page itself"};
    }
  }
  if (head.target.size() > kLongestTarget) {
    return Denial{414, fmt::format("the path has {} bytes; expected at most {}", head.target.size(), kLongestTarget)};
  }
  if (path.find('%') != std::string_view::npos || path.find('\\') != std::string_view::npos ||
      path.find("..") != std::string_view::npos) {
    return Denial{404, "no such page"};
  }
  return std::nullopt;
}

}  // namespace eha::web
