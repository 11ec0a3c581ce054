// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"
#include "servo/rendered.h"
#include "servo/solve/point/direct.h"

namespace haptic {
namespace {

/// This tick's proxy, by the solver that goes with the detector of the contacts.
PointProxySolution solve_proxy(const ServoModel& model, ServoState& state, Solver solver,
                               const ProxyQuestion& question) {
  if (solver == Solver::kVirtualProxy) {
    VirtualProxyState& kept = keep<VirtualProxyState>(state.proxy);
    ProxyQuestion sphere = question;
    sphere.radius = model.virtual_proxy.radius;
    sphere.held_back_W = kept.held_back_W;
    return solve_virtual_proxy(model.virtual_proxy, kept, sphere,
                               {state.coupling.translational_stiffness, model.dt});
  }
  state.proxy.emplace<std::monostate>();
  if (solver == Solver::kDirect) return solve_direct(question);
  PlanesInForce planes;
  return solve_point_proxy(question, planes);
}

/// Pushes the opposite of the tool's force into the objects that carry it.
void add_impulses(const PointProxySolution& solution, const Vec3& force_W,
                  const std::array<Pose, kMaxObjects>& X_WO, double dt,
                  std::array<Wrench, kMaxObjects>& impulse_W) {
  Vec3 sum_W{};
  for (const ProxyPush& push : solution.active()) sum_W += push.push_W;
  const double length2 = norm_squared(sum_W);
  if (length2 == 0) return;
  // the coupling force is parallel to the sum of the pushes: each plane carries its part
  const double gain = dot(force_W, sum_W) / length2;
  for (const ProxyPush& push : solution.active()) {
    HAPTIC_ASSERT(push.object < kMaxObjects);
    const Vec3 one_W = -dt * gain * push.push_W;
    const Vec3 arm_W = solution.proxy_W - X_WO[push.object].p;
    Wrench& total = impulse_W[push.object];
    total = total + Wrench{one_W, cross(arm_W, one_W)};
  }
}

/// Velocity of what carries the proxy, in W.
Vec3 surface_of(const PointProxySolution& solution, const TickScene& scene) {
  if (solution.n_active == 0) return {};
  const uint32_t object = solution.pushes[0].object;
  return velocity_at(scene.V_WO[object], solution.proxy_W - scene.X_WO[object].p);
}

}  // namespace

Rendered render_point(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const TickScene& scene, const ServoFrame& frame) {
  PointProxySolution proxy;
  proxy.proxy_W = frame.X_WT.p;
  // nothing is known of what a detector without a name has found
  if (input.contacts != nullptr && is_renderer(input.contacts->renderer)) {
    const auto renderer = static_cast<Renderer>(input.contacts->renderer);
    proxy = solve_proxy(model, state, row_of(renderer).solver,
                        {*input.contacts, scene, frame.X_WT.p, 0, {}});
  }

  // the spring is here: this tick's tool pose, no queue in between
  Rendered out;
  out.surface_W = surface_of(proxy, scene);
  out.X_WP = {proxy.proxy_W, frame.X_WT.q};
  out.F_W.f = coupling_force(
      state.coupling, {frame.X_WT.p, proxy.proxy_W, frame.V_WT.v, out.surface_W, proxy.share});
  out.held_back_W = proxy.held_back_W;
  out.n_pushing = proxy.n_active;
  out.finite = proxy.finite;
  out.converged = proxy.converged;
  out.object_impulse_W = state.object_impulse_W;
  add_impulses(proxy, out.F_W.f, scene.X_WO, model.dt, out.object_impulse_W);
  return out;
}

}  // namespace haptic
