// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The rules of docs/view-protocol.md on who may ask for what, as functions of texts.
namespace haptic {

struct WebRules {
  uint16_t port = 0;
  std::vector<std::string> hosts;    // of --allow-host: "name" or "name:port"
  std::vector<std::string> origins;  // of --allow-origin: "https://…"
};

/// True if a request may name this Host: one of this machine with the bridge's port, or an allowed
/// one. A page that lets its own name lead to 127.0.0.1 cannot send it.
bool is_host_allowed(const WebRules& rules, std::string_view host);

/// True if the Origin is the bridge itself, under the name in Host, which must be allowed.
bool is_own_origin(std::string_view origin, std::string_view host);
bool is_origin_allowed(const WebRules& rules, std::string_view origin);

/// A target "/path?query" taken apart.
struct Target {
  std::string path, query;
  std::string problem;  // empty: none
};
Target parse_target(std::string_view target);

/// The number of that name in a query "a=1&b=2"; none if it is missing or no finite number.
std::optional<double> number_in(std::string_view query, std::string_view name);

/// Media type by the end of the name.
std::string media_type(std::string_view path);

/// Compares in a time that depends on the lengths alone.
bool is_same_secret(std::string_view a, std::string_view b);

/// Why a line of a page is not passed on to hapticd; empty: it is.
std::string command_problem(std::string_view line);

}  // namespace haptic
