// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/point_solver.h"

#include "servo/solve/point/direct.h"

namespace haptic {
namespace {

/// Adds the parts of the tool's force by the objects that carry it.
void add_parts(const PointProxySolution& solution, const Vec3& force_W,
               PerObject<Wrench>& parts_W) {
  Vec3 sum_W{};
  for (const ProxyPush& push : solution.active()) sum_W += push.push_W;
  const double length2 = norm_squared(sum_W);
  if (length2 == 0) return;
  // the coupling force is parallel to the sum of the pushes: each plane carries its part
  const double gain = dot(force_W, sum_W) / length2;
  for (const ProxyPush& push : solution.active()) {
    parts_W[push.object].f += gain * push.push_W;
  }
}

/// Velocity of what carries the proxy, in W.
Vec3 surface_of(const PointProxySolution& solution, const TickScene& scene) {
  if (solution.n_active == 0) return {};
  const uint32_t object = solution.pushes[0].object;
  return velocity_at(scene.V_WO[object], solution.proxy_W - scene.X_WO[object].p);
}

}  // namespace

ProxyQuestion point_question(const RenderQuestion& question) {
  return {question.contacts, question.scene, question.X_WT.p, 0, {}};
}

Rendered rendered_point(const RenderQuestion& question, const PointProxySolution& proxy) {
  // the spring is here: this tick's tool pose, no queue in between
  Rendered out(question.scene);
  out.surface_W = surface_of(proxy, question.scene);
  out.X_WP = {proxy.proxy_W, question.X_WT.q};
  out.F_W.f = coupling_force(question.coupling, {question.X_WT.p, proxy.proxy_W, question.V_WT.v,
                                                 out.surface_W, proxy.share});
  out.held_back_W = proxy.held_back_W;
  out.n_pushing = proxy.n_active;
  out.finite = proxy.finite;
  out.converged = proxy.converged;
  add_parts(proxy, out.F_W.f, out.push_W);
  return out;
}

Rendered PointProxySolver::render(const ServoModel&, const RenderQuestion& question,
                                  ContactSolvers&) {
  PlanesInForce planes;
  return rendered_point(question, solve_point_proxy(point_question(question), planes));
}

Rendered DirectSolver::render(const ServoModel&, const RenderQuestion& question, ContactSolvers&) {
  return rendered_point(question, solve_direct(point_question(question)));
}

Rendered VirtualProxySolver::render(const ServoModel& model, const RenderQuestion& question,
                                    ContactSolvers&) {
  ProxyQuestion sphere = point_question(question);
  sphere.radius = model.proxy_radius;
  sphere.held_back_W = state.held_back_W;
  const VirtualProxyTick tick{question.coupling.translational_stiffness, model.dt};
  return rendered_point(question, solve_virtual_proxy(model.materials, state, sphere, tick));
}

}  // namespace haptic
