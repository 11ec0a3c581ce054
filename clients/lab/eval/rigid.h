// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/lab/eval/rigid_judge.h"
#include "clients/lab/eval/scenes/rigid_scenes.h"
#include "clients/lockstep/lockstep.h"

namespace haptic {

struct RigidEval {
  uint64_t ticks = 4000;  // per scene
  uint64_t seed = 1;
  double friction = 0;  // of the object, static and dynamic
  std::string meshes;   // folder with bunny00.off; the scene is skipped without it
  LockstepOptions lockstep;
};

/// The session of a scene: 1000 N/m and 2 N·m/rad; mass and dampers only for
/// renderers that have them.
SessionConfig rigid_session(const RigidScene& scene, Renderer renderer, double friction = 0);

using SeeTick = std::function<void(const ServoFrame&, const ContactSet*)>;

/// Servo, contact and sim in lockstep; `path` is the pose of the tool at time t [s].
void run_rigid(const RigidScene& scene, Renderer renderer, const std::function<Pose(double)>& path,
               uint64_t ticks, const LockstepOptions& lockstep, const SeeTick& see,
               double friction = 0);

/// A hand shakes the tool against the object; every tick is checked.
RigidJudge shake_rigid(const RigidScene& scene, Renderer renderer, const RigidEval& eval);

/// Largest |F| [N] in free space for a hand of 2 m/s that turns the tool at 10 rad/s.
double force_in_free_space(Renderer renderer, const LockstepOptions& lockstep);

/// Largest ratio of tangential to normal force for a box that a hand pushes at 45° into a
/// frictionless plane.
double slant_of_push(Renderer renderer, const LockstepOptions& lockstep);

/// `hapt eval rigid`: both renderers whose tool never enters an object, in every scene,
/// with each friction.
/// Throws MeshError.
void eval_rigid(RigidEval eval, const Rows& all);

}  // namespace haptic
