// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/eval/rigid_judge.h"
#include "clients/eval/scenes/rigid_scenes.h"
#include "clients/lab/lockstep.h"

namespace haptic {

struct RigidEval {
  uint64_t ticks = 4000;  // of each shaking
  uint64_t seed = 1;
  std::string meshes;  // folder with bunny00.off; without it that scene is left out
  LockstepOptions lockstep;
};

/// The session of a scene: frictionless, 1000 N/m and 2 N·m/rad; with mass and dampers only where
/// the renderer has them.
SessionConfig rigid_session(const RigidScene& scene, Renderer renderer);

using SeeTick = std::function<void(const ServoFrame&, const ContactSet*)>;

/// Servo, contact and sim in lockstep, led by a path of the tool in time [s].
void run_rigid(const RigidScene& scene, Renderer renderer, const std::function<Pose(double)>& path,
               uint64_t ticks, const LockstepOptions& lockstep, const SeeTick& see);

/// A hand shakes the tool against the object, judged tick by tick.
RigidJudge shake_rigid(const RigidScene& scene, Renderer renderer, const RigidEval& eval);

/// Largest |F| of a hand of 2 m/s that turns the tool at 10 rad/s where nothing is [N].
double force_in_free_space(Renderer renderer, const LockstepOptions& lockstep);

/// Largest force along a frictionless plane over that across it, of a box that a hand pushes into
/// it at 45°.
double slant_of_push(Renderer renderer, const LockstepOptions& lockstep);

/// The whole of `hapt eval --suite rigid`: both renderers whose tool never enters an object, in
/// every scene. Throws MeshError.
std::vector<Row> eval_rigid(const RigidEval& eval);

}  // namespace haptic
