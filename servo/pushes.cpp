// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/pushes.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

uint32_t count_pushable(const SceneFrame* scene) {
  return scene != nullptr ? std::min(scene->n_responses, kMaxObjects) : 0;
}

void continue_pushes(PushCounters& pushes, int64_t t_ns, bool holds_force, double dt) {
  HAPTIC_ASSERT(dt > 0);
  if (pushes.since_ns == 0) pushes.since_ns = pushes.t_ns = t_ns;
  const double since = static_cast<double>(t_ns - pushes.t_ns) * 1e-9;
  const double total = holds_force ? std::max(std::round(since / dt) - 1, 0.0) : 0;
  const double missed = std::min(total, 1.0 * kReleaseAfterTicks);
  // each at its own tick, the first ones: they last for total dt, (total − 1) dt, … until this one
  const double lasting = missed * (total - 0.5 * (missed - 1)) * dt;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    pushes.impulse_time_W[i] =
        pushes.impulse_time_W[i] + since * pushes.impulse_W[i] + lasting * pushes.last_W[i];
    pushes.impulse_W[i] = pushes.impulse_W[i] + missed * pushes.last_W[i];
  }
  pushes.last_W = {};
  pushes.t_ns = t_ns;
}

void note_pushes(PushCounters& pushes, const Pushing& pushing, double dt) {
  const auto& [scene, placed, rendered, at_W, felt] = pushing;
  // what is not felt may be anything, as after a fault
  if (felt.force == 0 && felt.torque == 0) return;
  if (scene == nullptr) return;
  const bool are_taken = takes_pushes(*scene, kFirstHand, pushes.since_ns, pushes.t_ns);
  for (uint32_t i = 0; i < count_pushable(scene); ++i) {
    if (rendered.push_W[i] == Wrench{}) continue;
    const Wrench push_W = shift(rendered.push_W[i], rendered.X_WP.p - at_W);
    const Wrench given_W{-dt * felt.force * push_W.f, -dt * felt.torque * push_W.t};
    if (are_taken || !is_mobile(*scene, i)) {
      pushes.last_W[i] = shift(given_W, at_W - placed.X_WO[i].p);
      pushes.impulse_W[i] = pushes.impulse_W[i] + pushes.last_W[i];
    } else {
      pushes.forgotten_W += given_W.f;
    }
  }
}

}  // namespace haptic
