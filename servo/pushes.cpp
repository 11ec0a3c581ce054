// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/pushes.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

void continue_pushes(PushCounters& pushes, int64_t t_ns, bool holds_force, double dt) {
  HAPTIC_ASSERT(dt > 0);
  if (pushes.since_ns == 0) pushes.since_ns = pushes.t_ns = t_ns;
  const double since = static_cast<double>(t_ns - pushes.t_ns) * 1e-9;
  const double total = holds_force ? std::max(std::round(since / dt) - 1, 0.0) : 0;
  const double missed = std::min(total, 1.0 * kReleaseAfterTicks);
  // each at its own tick, the first ones: they last for total dt, (total − 1) dt, … until this one
  const double lasting = missed * (total - 0.5 * (missed - 1)) * dt;
  for (uint32_t k = 0; k < pushes.n; ++k) {
    auto& [impulse_W, impulse_time_W] = pushes.objects[k];
    impulse_time_W = impulse_time_W + since * impulse_W + lasting * pushes.last_W[k];
    impulse_W = impulse_W + missed * pushes.last_W[k];
    pushes.last_W[k] = {};
  }
  pushes.t_ns = t_ns;
}

void note_pushes(PushCounters& pushes, const Pushing& pushing, double dt) {
  const auto& [hand, scene, placed, rendered, at_W, felt] = pushing;
  if (scene == nullptr) return;
  pushes.n = std::max(pushes.n, static_cast<uint32_t>(scene->responses.size()));
  // what is not felt may be anything, as after a fault
  if (felt.force == 0 && felt.torque == 0) return;
  const size_t n = std::min(rendered.push_W.size(), scene->objects.size());
  for (uint32_t i = 0; i < n; ++i) {
    if (rendered.push_W[i] == Wrench{} || response_of(*scene, i) == nullptr) continue;
    const Wrench push_W = shift(rendered.push_W[i], rendered.X_WP.p - at_W);
    const Wrench given_W{-dt * felt.force * push_W.f, -dt * felt.torque * push_W.t};
    if (takes_pushes(*scene, i, hand, pushes.since_ns, pushes.t_ns) || !is_mobile(*scene, i)) {
      const uint32_t k = scene->objects[i].response;
      pushes.last_W[k] = shift(given_W, at_W - placed.X_WO[i].p);
      pushes.objects[k].impulse_W = pushes.objects[k].impulse_W + pushes.last_W[k];
    } else {
      pushes.forgotten_W += given_W.f;
    }
  }
}

}  // namespace haptic
