// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/wire/wire.h"
#include "servo/render/render.h"
#include "servo/safety/safety.h"

namespace haptic {

/// Objects up to the last one that the scene says a push can move; 0: no scene has come.
uint32_t count_pushable(const SceneFrame* scene);

/// Impulses that the objects have been pushed with (ServoFrame).
struct PushCounters {
  std::array<Wrench, kMaxObjects> impulse_W{};
  std::array<Wrench, kMaxObjects> impulse_time_W{};  // until t_ns
  std::array<Wrench, kMaxObjects> last_W{};          // part of impulse_W, of the last tick
  Vec3 forgotten_W;
  int64_t since_ns = 0;  // the first tick
  int64_t t_ns = 0;      // this tick
};

/// Brings the impulses and their integral up to this tick. A device that holds a force (not one
/// that holds a place) holds that of the last tick over those that were missed since, until hapticd
/// lets go (kReleaseAfterTicks): so each of them has pushed as it did.
void continue_pushes(PushCounters& pushes, int64_t t_ns, bool holds_force, double dt);

/// The pushes of the objects on a proxy, and how the hand feels them.
struct Pushing {
  const SceneFrame* scene;  // null: none has come
  const TickScene& placed;  // where the objects are
  const Rendered& rendered;
  Vec3 felt_at_W;  // the point about which the hand feels the torque
  FeltShare felt;
};

/// Counts what the objects that can be pushed are pushed with in this tick: the opposite of what
/// they push the proxy with, as far as the hand feels it. What no sim moves a body by is forgotten:
/// it is not given to the body later.
void note_pushes(PushCounters& pushes, const Pushing& pushing, double dt);

}  // namespace haptic
