// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/pushes/hand_pushes.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

/// The counters of a response; a servo that has not seen it yet has none.
ObjectPush counter_of(const ServoFrame& frame, size_t response) {
  return response < frame.pushes.size() ? frame.pushes[response] : ObjectPush{};
}

/// Copies the counters, and leaves what is forgotten.
void copy_counters(SeenCounters& seen, const ServoFrame& frame) {
  seen.t_ns = frame.t_ns;
  seen.since_ns = frame.impulses_since_ns;
  for (size_t k = 0; k < seen.pushes.size(); ++k) {
    const auto [impulse_W, impulse_time_W] = counter_of(frame, k);
    seen.pushes[k] = {impulse_W, impulse_time_W, seen.pushes[k].forgotten_W, frame.t_ns};
  }
}

}  // namespace

bool has_finite_counters(const ServoFrame& frame) {
  return std::ranges::all_of(frame.pushes, [](const ObjectPush& push) {
    return is_finite(push.impulse_W) && is_finite(push.impulse_time_W);
  });
}

NewPushes take_pushes(SeenCounters& seen, const ServoFrame& frame, int64_t from_ns) {
  NewPushes pushes{};
  if (!has_finite_counters(frame) || frame.t_ns == 0) return pushes;
  if (seen.t_ns == 0 || frame.impulses_since_ns != seen.since_ns) {
    copy_counters(seen, frame);
    return pushes;
  }
  const double between = 1e-9 * static_cast<double>(frame.t_ns - seen.t_ns);
  const double before = 1e-9 * static_cast<double>(frame.t_ns - from_ns);
  for (size_t k = 0; k < std::min(pushes.size(), frame.pushes.size()); ++k) {
    const SeenPush& old = seen.pushes[k];
    const auto& [J, S] = frame.pushes[k];
    pushes[k].impulse_W = J + -old.impulse_W;
    // S − S_seen − J_seen (t_frame − t_seen) and, with ΔJ from there on, − ΔJ (t_frame − t₀)
    pushes[k].late_W =
        S + -old.impulse_time_W + -between * old.impulse_W + -before * pushes[k].impulse_W;
  }
  copy_counters(seen, frame);
  return pushes;
}

void forget_pushes(SeenCounters& seen, const ServoFrame& frame, const SceneFrame& last,
                   uint32_t hand) {
  HAPTIC_ASSERT(hand < last.n_hands);
  if (!has_finite_counters(frame) || frame.t_ns == 0) return;
  copy_counters(seen, frame);
  const size_t n = last.n_hands > 0 ? last.seen.size() / last.n_hands : 0;
  for (size_t k = 0; k < std::min(n, seen.pushes.size()); ++k) {
    const SeenPush& old = last.seen[k * last.n_hands + hand];
    seen.pushes[k].forgotten_W = old.forgotten_W;
    if (is_counted(&old, frame.impulses_since_ns)) {
      seen.pushes[k].forgotten_W += counter_of(frame, k).impulse_W.f - old.impulse_W.f;
    }
  }
}

}  // namespace haptic
