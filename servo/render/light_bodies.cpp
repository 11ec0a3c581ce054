// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/light_bodies.h"

#include <algorithm>

#include "proto/config/renderer_needs.h"
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

// Pushed against a wall or an end stop, bodies gain nothing up to 2 in lockstep, whatever their
// latency, and up to 1.5 times what they were given at 4: half of what is harmless
constexpr double kMostStiff = 1;
constexpr double kForget = 10;  // in which a share rises from 0 to 1 while nothing pushes [s]
constexpr double kShared = 4;   // contacts that share no more stiffness: the corners of a box

/// The spring between hand and object: the coupling, or without one that of the contacts.
Coupling spring_of(const ServoModel& model, const RenderQuestion& question) {
  Coupling spring = question.coupling;
  const auto renderer = static_cast<Renderer>(question.contacts.renderer);
  const bool is_direct =
      row_of(renderer).moves == Moves::kSoftBody &&
      question.soft_solver.value_or(solver_of(model.proxy, renderer)) == SoftSolver::kDirect;
  if (!is_direct) return spring;
  const double radius = question.contacts.tool.radius;
  spring.translational_stiffness = kShared * model.soft.contact_stiffness;
  spring.rotational_stiffness = radius * radius * spring.translational_stiffness;
  return spring;
}

/// Pᵀ C P of a wrench at the tool.
double compliance_along(const Coupling& spring, const Wrench& push_W) {
  double sum = 0;
  if (spring.translational_stiffness > 0) {
    sum += norm_squared(push_W.f) / spring.translational_stiffness;
  }
  if (spring.rotational_stiffness > 0) sum += norm_squared(push_W.t) / spring.rotational_stiffness;
  return sum;
}

/// Pᵀ M⁻¹ P of a wrench at an object's origin.
double mobility_along(const ObjectResponse& response, const Wrench& push_W) {
  const Twist moved = moved_by(response.mobility, push_W);
  return dot(push_W.f, moved.v) + dot(push_W.t, moved.w);
}

/// What the client that moves an object lets through of its force [N], 0 to 1.
double kept_of_client(const SceneObject& object, double force) {
  const double kept = std::clamp(1 - object.reduction, 0.0, 1.0);
  const bool is_bound = object.most_force > 0 && kept * force > object.most_force;
  return is_bound ? object.most_force / force : kept;
}

}  // namespace

bool soften_towards_light(const ServoModel& model, const RenderQuestion& question,
                          const SceneFrame* scene, LightBodies& light, Rendered& rendered) {
  HAPTIC_ASSERT(model.dt > 0 && model.sim_period > 0);
  if (scene == nullptr) return false;
  const Coupling spring = spring_of(model, question);
  const double T = model.dt + model.sim_period;
  Wrench pushed_W, softened_W;
  double size = 0, left = 0;
  bool is_any = false;
  const size_t n = std::min(rendered.push_W.size(), scene->objects.size());
  for (uint32_t i = 0; i < n; ++i) {
    double& share = light.share[i];
    const Wrench& push_W = rendered.push_W[i];
    if (push_W == Wrench{}) share = std::min(share + model.dt / kForget, 1.0);
    const ObjectResponse* response = response_of(*scene, i);
    if (response == nullptr || push_W == Wrench{} || !is_finite(push_W)) continue;
    const Vec3 arm_W = rendered.X_WP.p - question.scene.X_WO[i].p;
    const double moves = T * T * mobility_along(*response, shift(push_W, arm_W));
    const double gives = kMostStiff * compliance_along(spring, push_W);
    if (moves > gives) share = std::min(share, gives / moves);
    const double kept = share * kept_of_client(scene->objects[i], share * norm(push_W.f));
    pushed_W = pushed_W + push_W;
    size += norm(push_W.f);
    left += kept * norm(push_W.f);
    rendered.push_W[i] = kept * push_W;
    softened_W = softened_W + rendered.push_W[i];
    is_any = is_any || kept < 1;
  }
  if (!is_any) return false;
  // what a proxy with mass keeps back of the pushes is softened by as much
  const double rest = size > 0 ? left / size : 1;
  rendered.F_W = softened_W + rest * (rendered.F_W + -pushed_W);
  return true;
}

}  // namespace haptic
