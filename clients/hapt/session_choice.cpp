// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/session_choice.h"

#include "clients/hapt/options.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kRetryPeriod = 50'000'000;  // [ns]

/// True if waiting longer changes nothing: all processes of the session run, or several sessions do
/// and none is named.
bool is_settled(const std::string& name) {
  if (name.empty() && running_sessions().size() > 1) return true;
  try {
    return say_to_session(name, "status").find("\"runs\": false") == std::string::npos;
  } catch (const HandoutError&) {
    return false;
  }
}

}  // namespace

void add_session(Command& command, SessionChoice& session) {
  command.option("--session NAME", session.name, "which session; needed only if several run");
  add_duration(command, "--wait TIME", session.wait, "for the session to come up, at most");
}

const std::string& once_up(const SessionChoice& session) {
  if (session.wait <= 0) return session.name;
  const int64_t end_ns = now_ns() + static_cast<int64_t>(session.wait * kNsPerSecond);
  while (!is_settled(session.name) && now_ns() < end_ns && !stop_requested()) {
    sleep_until(now_ns() + kRetryPeriod);
  }
  return session.name;
}

}  // namespace haptic
