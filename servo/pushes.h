// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/wire/wire.h"
#include "servo/render/render.h"
#include "servo/safety/safety.h"

namespace haptic {

/// Impulses that the objects have been pushed with (ServoFrame).
struct PushCounters {
  std::array<ObjectPush, kMaxBodies> objects{};  // until t_ns, by SceneObject::response
  std::array<Wrench, kMaxBodies> last_W{};       // part of the impulses, of the last tick
  uint32_t n = 0;                                // of them in use
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
  uint32_t hand;
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
