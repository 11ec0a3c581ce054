// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/web/http_rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "proto/ipc/control_socket.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

bool contains(const std::vector<std::string>& texts, const std::string& text) {
  return std::any_of(texts.begin(), texts.end(),
                     [&](const std::string& one) { return lower(one) == text; });
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

struct MediaType {
  std::string_view ending, type;
};
constexpr std::array<MediaType, 10> kMediaTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".txt", "text/plain; charset=utf-8"},
    {".woff2", "font/woff2"},
}};

constexpr std::array<std::string_view, 6> kWords{"pause",  "resume",      "arm",
                                                 "disarm", "clear-fault", "set"};

}  // namespace

bool is_host_allowed(const WebRules& rules, std::string_view host) {
  const std::string name = lower(host);
  const std::string port = ":" + std::to_string(rules.port);
  for (const char* own : {"127.0.0.1", "localhost", "[::1]"}) {
    if (name == own + port) return true;
    // browsers leave out the port that belongs to http
    if (rules.port == 80 && name == own) return true;
  }
  if (name.empty()) return false;
  if (contains(rules.hosts, name)) return true;
  return name.ends_with(port) && contains(rules.hosts, name.substr(0, name.size() - port.size()));
}

bool is_own_origin(std::string_view origin, std::string_view host) {
  return !host.empty() && lower(origin) == "http://" + lower(host);
}

bool is_origin_allowed(const WebRules& rules, std::string_view origin) {
  return contains(rules.origins, lower(origin));
}

Target parse_target(std::string_view target) {
  Target out;
  const std::string_view path = target.substr(0, target.find('?'));
  out.path = path;
  if (path.size() < target.size()) out.query = target.substr(path.size() + 1);
  if (path.empty() || path.front() != '/') {
    out.problem = "a path begins with /";
  } else if (path.find("..") != path.npos || path.find_first_of("%\\") != path.npos ||
             std::any_of(target.begin(), target.end(), is_control)) {
    out.problem = "a path has no .., %, \\ or control character";
  }
  return out;
}

std::optional<double> number_in(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(pair.size() + 1, query.size()));
    if (pair.substr(0, pair.find('=')) != name || pair.size() <= name.size()) continue;
    const auto number = number_from<double>(pair.substr(name.size() + 1));
    return number && std::isfinite(*number) ? number : std::nullopt;
  }
  return std::nullopt;
}

std::string media_type(std::string_view path) {
  for (const MediaType& row : kMediaTypes) {
    if (path.ends_with(row.ending)) return std::string(row.type);
  }
  return "application/octet-stream";
}

bool is_same_secret(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  const size_t n = std::min(a.size(), b.size());
  for (size_t i = 0; i < n; ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

std::string command_problem(std::string_view line) {
  if (line.size() > kLongestCommand) {
    return "a command has at most " + std::to_string(kLongestCommand) + " bytes";
  }
  if (std::any_of(line.begin(), line.end(), is_control)) {
    return "a command is one line without control characters";
  }
  const std::string_view word = line.substr(0, line.find(' '));
  if (std::find(kWords.begin(), kWords.end(), word) != kWords.end()) return "";
  return "a page cannot say '" + shown(word) +
         "'; it can say pause, resume, arm, disarm, clear-fault and set KEY VALUE";
}

}  // namespace haptic
