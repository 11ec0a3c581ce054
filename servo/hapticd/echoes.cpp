// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/echoes.h"

#include <utility>

#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr int64_t kEchoPatienceNs = 1000 * kMs;  // until a client gets an error

enum class Echo { kNone, kTaken, kDone };

Echo echo_of(const Echoes::Change& change, const Echoes::FrameOf& frame_of) {
  Echo echo = Echo::kDone;
  for (const Echoes::Revision& revision : change.revisions) {
    const ServoFrame& servo = frame_of(revision.hand);
    if (servo.control_revision < revision.number) return Echo::kNone;
    if (change.clears_fault && servo.fault != 0) echo = Echo::kTaken;
  }
  return echo;
}

std::string text_of(Echo echo, const Echoes::Change& change) {
  if (echo == Echo::kDone) {
    return change.warning.empty() ? "ok" : "ok; warning: " + change.warning;
  }
  if (echo == Echo::kTaken) {
    return "error: the fault is still there; hold the handle stiller than 0.1 m/s (the request "
           "waits), see the log for its cause";
  }
  return "error: the servo did not apply it within a second (the request waits); see hapt status";
}

}  // namespace

void Echoes::await(Change change, int64_t t_ns) {
  waiting_.push_back({std::move(change), t_ns + kEchoPatienceNs});
}

void Echoes::answer(int64_t t_ns, const FrameOf& frame_of, const Answer& say) {
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    const Echo echo = echo_of(waiting.change, frame_of);
    if (echo != Echo::kDone && t_ns < waiting.give_up_ns) return false;
    say(waiting.change.peer, text_of(echo, waiting.change));
    return true;
  });
}

}  // namespace haptic
