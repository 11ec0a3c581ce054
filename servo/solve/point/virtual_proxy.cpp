// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/virtual_proxy.h"

#include <optional>

#include "proto/math/assert.h"
#include "servo/solve/point/shading.h"
#include "servo/solve/point/texture.h"

namespace haptic {
namespace {

/// Where the proxy touched this object in the last tick; none: it did not.
std::optional<Vec3> last_touch(const VirtualProxyState& state, uint32_t object) {
  for (int i = state.n_touched - 1; i >= 0; --i) {
    const TouchedObject& touched = state.touched[static_cast<size_t>(i)];
    if (touched.object == object) return touched.point_O;
  }
  return {};
}

/// Interpolated normals from contact, tilted by the texture along the path.
std::array<Vec3, 3> shading_normals(const Materials& materials, const VirtualProxyState& state,
                                    const ProxyQuestion& question,
                                    const PointProxySolution& solution,
                                    std::array<Vec3, 3>& touch_point_O) {
  std::array<Vec3, 3> normals_W;
  for (size_t i = 0; i < static_cast<size_t>(solution.n_active); ++i) {
    const ProxyPush& push = solution.pushes[i];
    const Contact& contact = question.contacts.contacts[push.contact];
    const TextureConfig& texture = materials.of(question.scene.object_of(push.object)).texture;
    const Pose& X_WO = question.scene.X_WO[push.object];
    touch_point_O[i] = inverse(X_WO) * (solution.proxy_W - question.radius * push.plane.normal);
    if (contact.shading_normal_O == contact.normal_O && texture.kind == TextureKind::kNone) {
      normals_W[i] = push.plane.normal;
      continue;
    }
    const Vec3 from_O = last_touch(state, push.object).value_or(touch_point_O[i]);
    const Vec3 gradient_O =
        steepest_gradient(texture, materials.images, {from_O, touch_point_O[i], contact.normal_O});
    normals_W[i] = rotate(X_WO.q, tilted_normal(contact.shading_normal_O, gradient_O));
  }
  return normals_W;
}

/// Average of the pushing planes' materials, weighted by push; and the object that pushes most.
struct Mixture {
  FrictionLaw law;
  double stiffness_share = 1;
  uint32_t object = 0;
};

Mixture mix_materials(const Materials& materials, const TickScene& scene,
                      const PointProxySolution& solution) {
  Mixture mixture;
  double total = 0, hardest = 0;
  for (const ProxyPush& push : solution.active()) total += norm(push.push_W);
  if (!(total > 0)) return mixture;
  mixture.stiffness_share = 0;
  for (const ProxyPush& push : solution.active()) {
    const MaterialConfig& m = materials.of(scene.object_of(push.object));
    const double say = norm(push.push_W) / total;
    mixture.law.static_ratio += say * m.friction_static;
    mixture.law.dynamic_ratio += say * m.friction_dynamic;
    mixture.law.viscous += say * m.friction_viscous;
    mixture.stiffness_share += say * m.stiffness_share;
    if (say > hardest) hardest = say, mixture.object = push.object;
  }
  return mixture;
}

/// Distributes what shading, friction and softness changed over the planes, weighted by push.
void share_out(const Vec3& tool_W, PointProxySolution& solution) {
  Vec3 sum_W;
  double total = 0;
  for (const ProxyPush& push : solution.active()) {
    sum_W += push.push_W;
    total += norm(push.push_W);
  }
  if (!(total > 0)) return;
  const Vec3 rest_W = solution.proxy_W - tool_W - sum_W;
  for (ProxyPush& push : solution.active()) push.push_W += (norm(push.push_W) / total) * rest_W;
}

void note_touches(const PointProxySolution& solution, const std::array<Vec3, 3>& touch_point_O,
                  VirtualProxyState& state) {
  state.n_touched = solution.n_active;
  for (size_t i = 0; i < static_cast<size_t>(solution.n_active); ++i) {
    state.touched[i] = {solution.pushes[i].object, touch_point_O[i]};
  }
}

}  // namespace

PointProxySolution solve_virtual_proxy(const Materials& materials, VirtualProxyState& state,
                                       const ProxyQuestion& question,
                                       const VirtualProxyTick& tick) {
  HAPTIC_ASSERT(tick.dt > 0 && question.radius >= 0);
  PlanesInForce planes;
  PointProxySolution solution = solve_point_proxy(question, planes);
  if (solution.n_active == 0) {
    state = {};
    return solution;
  }
  std::array<Vec3, 3> touch_point_O;
  const auto normals_W = shading_normals(materials, state, question, solution, touch_point_O);
  note_touches(solution, touch_point_O, state);
  const Vec3 foot_W = shaded_proxy(solution, planes, question.tool_W, normals_W);

  Mixture mixture = mix_materials(materials, question.scene, solution);
  mixture.law.stiffness = tick.stiffness;
  mixture.law.dt = tick.dt;
  Vec3 held_W = hold_by_friction(mixture.law, state.friction, question.tool_W, foot_W,
                                 mixture.object, question.scene.X_WO[mixture.object]);
  // in a corner, sliding along one wall may lead into another
  if (held_W != foot_W && solution.n_active > 1) {
    held_W = project_onto_half_spaces(held_W, planes.view()).x;
  }
  state.held_back_W = solution.held_back_W = held_W - foot_W;
  solution.proxy_W = question.tool_W + mixture.stiffness_share * (held_W - question.tool_W);
  share_out(question.tool_W, solution);
  return solution;
}

}  // namespace haptic
