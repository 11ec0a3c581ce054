// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <poll.h>

#include <string>

#include "proto/ipc/handout_server.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

/// As eventually(), and serves meanwhile.
template <typename Condition>
bool serve_until(HandoutServer& server, Condition holds) {
  const int64_t give_up = now_ns() + kPatienceNs;
  while (!holds()) {
    if (now_ns() > give_up) return false;
    pollfd waiting{server.poll_fd(), POLLIN, 0};
    poll(&waiting, 1, 1);
    server.serve({});
  }
  return true;
}

/// A session's server, in a runtime folder of its own.
struct Served : TemporaryRuntimeFolder, HandoutServer {
  explicit Served(const std::string& session) : HandoutServer(session) {}
};

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace haptic::test
