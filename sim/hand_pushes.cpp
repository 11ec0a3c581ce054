// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/hand_pushes.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Copies the counters, and leaves what is forgotten.
void copy_counters(SeenCounters& seen, const ServoFrame& frame) {
  seen.t_ns = frame.t_ns;
  seen.since_ns = frame.impulses_since_ns;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    seen.pushes[i].impulse_W = frame.object_impulse_W[i];
    seen.pushes[i].impulse_time_W = frame.object_impulse_time_W[i];
  }
}

bool is_finite(const ServoFrame& frame) {
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    if (!is_finite(frame.object_impulse_W[i])) return false;
    if (!is_finite(frame.object_impulse_time_W[i])) return false;
  }
  return true;
}

}  // namespace

NewPushes take_pushes(SeenCounters& seen, const ServoFrame& frame, int64_t from_ns) {
  NewPushes pushes{};
  if (!is_finite(frame) || frame.t_ns == 0) return pushes;
  if (seen.t_ns == 0 || frame.impulses_since_ns != seen.since_ns) {
    copy_counters(seen, frame);
    return pushes;
  }
  const double between = 1e-9 * static_cast<double>(frame.t_ns - seen.t_ns);
  const double before = 1e-9 * static_cast<double>(frame.t_ns - from_ns);
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    const SeenPush& old = seen.pushes[i];
    const Wrench& J = frame.object_impulse_W[i];
    pushes[i].impulse_W = J + -old.impulse_W;
    // S − S_seen − J_seen (t_frame − t_seen) and, with ΔJ from there on, − ΔJ (t_frame − t₀)
    pushes[i].late_W = frame.object_impulse_time_W[i] + -old.impulse_time_W +
                       -between * old.impulse_W + -before * pushes[i].impulse_W;
  }
  copy_counters(seen, frame);
  return pushes;
}

void forget_pushes(SeenCounters& seen, const ServoFrame& frame, const SceneFrame& last,
                   uint32_t hand) {
  HAPTIC_ASSERT(hand < kMostHands);
  if (!is_finite(frame) || frame.t_ns == 0) return;
  copy_counters(seen, frame);
  const bool is_same_servo = last.seen_t_ns[hand] >= frame.impulses_since_ns;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    const SeenPush& old = last.responses[i].seen[hand];
    seen.pushes[i].forgotten_W = old.forgotten_W;
    if (is_same_servo && last.seen_t_ns[hand] != 0) {
      seen.pushes[i].forgotten_W += frame.object_impulse_W[i].f - old.impulse_W.f;
    }
  }
}

}  // namespace haptic
