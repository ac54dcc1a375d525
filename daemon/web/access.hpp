// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Access control: pure functions of a request's head.

namespace eha::web {

/// Parts of a request's head that access control uses. Every header as sent, none if it is missing; repeated ones are
/// joined.
struct RequestHead {
  std::string_view method;
  std::string_view target;  ///< path and query as sent, not decoded
  std::vector<std::string> host;
  std::vector<std::string> origin;
  std::vector<std::string> fetch_site;  ///< Sec-Fetch-Site
  std::vector<std::string> fetch_mode;  ///< Sec-Fetch-Mode
};

/// Refusal of a request.
struct Denial {
  int status = 0;  ///< of HTTP
  std::string message;
};

/// Whether a text is NAME or NAME:PORT: letters, digits, '.', '-', or an address in brackets.
[[nodiscard]] bool is_host(std::string_view text);

/// Rules against DNS rebinding and against requests that other sites make a browser send:
/// - Host is 127.0.0.1:PORT, localhost:PORT, [::1]:PORT or one of the allowed names (without a port: any port);
/// - Origin, if there is one, is http:// and that Host; a POST must have it;
/// - Sec-Fetch-Site, if there is one, is same-origin or none, but anybody may link to the page itself;
/// - only GET, HEAD and POST; no path that is encoded or longer than 512 bytes.
class AccessRules {
 public:
  AccessRules(std::uint16_t port, const std::vector<std::string>& allowed_hosts);

  /// @returns nothing if the request may be answered. Cost O(names).
  [[nodiscard]] std::optional<Denial> check(const RequestHead& head) const;

 private:
  [[nodiscard]] bool is_allowed(std::string_view host) const;

  std::vector<std::string> hosts_;  ///< lower case
};

}  // namespace eha::web
