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

/// What an object pushes with, the planes of clients on it included.
PerObject<Wrench> pushes_by_object(const TickScene& scene, const Rendered& rendered) {
  const auto n = static_cast<std::ptrdiff_t>(scene.n_objects());
  PerObject<Wrench> sums_W(rendered.push_W.begin(), rendered.push_W.begin() + n);
  for (size_t body = sums_W.size(); body < rendered.push_W.size(); ++body) {
    const uint32_t object = scene.object_of(static_cast<uint32_t>(body));
    if (object < sums_W.size()) sums_W[object] = sums_W[object] + rendered.push_W[body];
  }
  return sums_W;
}

}  // namespace

bool soften_towards_light(const ServoModel& model, const RenderQuestion& question,
                          const SceneFrame* scene, const Rendered& rendered, LightBodies& light,
                          KeptShares& shares) {
  HAPTIC_ASSERT(model.dt > 0 && model.sim_period > 0);
  if (scene == nullptr) return false;
  const Coupling spring = spring_of(model, question);
  const double T = model.dt + model.sim_period;
  const PerObject<Wrench> pushes_W = pushes_by_object(question.scene, rendered);
  PerObject<double> kept(pushes_W.size(), 1.0);
  bool is_any = false;
  const size_t n = std::min(pushes_W.size(), scene->objects.size());
  for (uint32_t i = 0; i < n; ++i) {
    double& share = light.share[i];
    const Wrench& push_W = pushes_W[i];
    if (push_W == Wrench{}) share = std::min(share + model.dt / kForget, 1.0);
    const ObjectResponse* response = response_of(*scene, i);
    if (response == nullptr || push_W == Wrench{} || !is_finite(push_W)) continue;
    const Vec3 arm_W = rendered.X_WP.p - question.scene.X_WO[i].p;
    const double moves = T * T * mobility_along(*response, shift(push_W, arm_W));
    const double gives = kMostStiff * compliance_along(spring, push_W);
    if (moves > gives) share = std::min(share, gives / moves);
    kept[i] = share * kept_of_client(scene->objects[i], share * norm(push_W.f));
    is_any = is_any || kept[i] < 1;
  }
  for (uint32_t body = 0; body < shares.size() && is_any; ++body) {
    const uint32_t object = question.scene.object_of(body);
    if (object < kept.size()) shares[body] *= kept[object];
  }
  return is_any;
}

}  // namespace haptic
