// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "proto/math/mat3.h"
#include "proto/wire/wire.h"
#include "sim/bullet/constraint_row.h"
#include "sim/bullet/world_model.h"

namespace haptic {

/// Where a body is and how it moves.
struct MovingBody {
  Pose X_WO;
  Twist V_WO;       // of the object's origin, in W
  Vec3 centre_W;    // of mass
  Mat3 inertia_W;   // about it
  Wrench joints_W;  // about it: springs, dampers, detents and sliding friction of joints
  Twist bias_W;     // acceleration of the centre of mass that joints give a body as it moves
  bool moves_by_mean = false;  // of its velocities before and after a step; else by that after it
  bool asleep = false;
};

/// Rigid bodies that collide with each other and with still and scripted objects; Bullet in double
/// precision, in one thread. Two worlds that are asked for the same do the same bit for bit.
class BodyWorld {
 public:
  explicit BodyWorld(const WorldModel& model);
  ~BodyWorld();
  BodyWorld(BodyWorld&&) noexcept;
  BodyWorld& operator=(BodyWorld&&) noexcept;

  /// A body is there at once, with this twist of its origin in W; a scripted object at the end of
  /// the next step, with the velocity that takes it there.
  void place(uint32_t object, const Pose& X_WO, const Twist& V_WO);
  /// An impulse at the object's origin, in W [N·s, N·m·s]; wakes the body. `late_W`: an impulse
  /// that the body is shifted by after the step as if it had had it for the step's time; dampers
  /// take the whole way.
  void push(uint32_t object, const Wrench& impulse_W, const Wrench& late_W = {});
  /// Moves a body without changing its velocity; the displacement is that of its origin, in W.
  void shift(uint32_t object, const Twist& displacement_W);
  /// Stops a body for good, where it is.
  void freeze(uint32_t object);
  /// Gravity, contacts and motion for dt [s], by one step; what was pushed before counts as pushed
  /// in it.
  void step(double dt);

  MovingBody motion(uint32_t object) const;
  /// What the bodies have pushed an object without mass with since the last call, about its origin
  /// in W [N·s, N·m·s].
  Wrench take_pushed_by_bodies(uint32_t object);
  /// Contacts that have carried an impulse lately, as what they do not let happen: a row along the
  /// normal, and two across it where friction sticks.
  std::span<const ConstraintRow> rows() const;
  /// Of a joint, in the order of the model.
  JointState joint(size_t joint) const;
  /// After bodies have been placed: the turn of a hinge that its pose means is the one near this.
  void resume_joint(size_t joint, double position);
  size_t n_contacts() const;  // points, of the last step

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace haptic
