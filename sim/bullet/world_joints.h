// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "proto/math/mat3.h"
#include "proto/wire/wire.h"
#include "sim/bullet/bullet.h"
#include "sim/bullet/constraint_row.h"
#include "sim/bullet/row_constraint.h"
#include "sim/joint/joint.h"

namespace haptic {

/// What hands have pushed the bodies with in this step, about their centres of mass [N·s, N·m·s].
struct PushedMean {
  std::vector<Wrench> impulse_W;  // that each has got at the beginning of the step
  // what is added to that to place it, over the time of the step: it came earlier, or later
  std::vector<Wrench> late_W;

  const Wrench& of(const btRigidBody& body) const {
    return impulse_W[static_cast<size_t>(body.getUserIndex())];
  }
  /// The impulse by which the mean velocity of the step differs from that at its end.
  Wrench beyond_end(const btRigidBody& body, bool moves_by_mean) const {
    const auto i = static_cast<size_t>(body.getUserIndex());
    return late_W[i] + (moves_by_mean ? 0.5 : 0.0) * impulse_W[i];
  }
};

/// What joints do to a body along their coordinates, beside holding it.
struct JointEffect {
  Wrench load_W;               // about its centre of mass
  Twist bias_W;                // acceleration of its centre of mass that their holding alone gives
  bool moves_by_mean = false;  // of the speeds before and after a step
};

/// The joints of a world. Each is a few rows for Bullet's solver: its locks, its dry friction, its
/// nearer end stop.
///
/// A hinge, slider or curve that leads a body's only joint to something that never moves also has a
/// coordinate of its own: its springs, detents and gravity change the speed along it, and after
/// each step the body is put where the coordinate says, with the momentum along it. Bullet's solver
/// would hold such a body with an error that grows with the lever from axis to centre of mass (it
/// sweeps row by row), and lets it drift off the axis by ω² r dt² / 2 per step; so what nobody
/// touches is as exact as its integration, and what touches others shares their rows. A ball that
/// is a body's only joint, at a point that never moves, lets it swing by itself (SwingingBody).
class WorldJoints {
 public:
  /// `bodies` must outlive this; frames of the centres of mass.
  WorldJoints(std::span<const JointConfig> joints,
              std::span<const std::unique_ptr<btRigidBody>> bodies,
              std::span<const uint8_t> never_moves, const Vec3& gravity_W, btDynamicsWorld& world);
  ~WorldJoints();
  WorldJoints(const WorldJoints&) = delete;

  /// Before and after a step of Bullet. `touches`: bodies that contacts hold.
  void before(double dt, const PushedMean& pushed);
  void after(double dt, std::span<const uint8_t> touches);

  /// Moves a body that has a coordinate; false: it has none.
  bool push(uint32_t object, const Wrench& impulse_W);
  bool shift(uint32_t object, const Twist& displacement_W);

  JointState state(size_t joint) const;
  /// Which turn of a hinge its pose means.
  void resume(size_t joint, double position);
  JointEffect effect(uint32_t object) const;

  /// Adds what is held along coordinates: stuck friction, end stops.
  void add_held(std::vector<ConstraintRow>& rows) const;
  /// Adds the locks.
  void add_locks(std::vector<ConstraintRow>& rows) const;

 private:
  struct Kept;
  JointRows rows_of(const Kept& kept) const;
  double weight_at(const Kept& kept, double position) const;
  void lead(Kept& kept, double dt, const PushedMean& pushed);
  void drive(Kept& kept, double dt, const PushedMean& pushed);
  static void bound(Kept& kept, double dt);
  void place(Kept& kept, double position, double speed);
  // of a body that leads or swings, with its rows where it is; null: it does neither
  Kept* leading(uint32_t object) const;

  std::span<const std::unique_ptr<btRigidBody>> bodies_;
  Vec3 gravity_W_;
  btDynamicsWorld& world_;
  std::unique_ptr<btRigidBody> ground_ = std::make_unique<btRigidBody>(0, nullptr, nullptr);
  std::vector<std::unique_ptr<Kept>> joints_;
};

}  // namespace haptic
