// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "proto/math/units.h"
#include "proto/wire/renderer.h"
#include "servo/solve/body/constrained6.h"
#include "servo/solve/body/god_object6.h"
#include "tests/support/meshes.h"

namespace haptic::test {

/// A touching contact of a tool at X_WG with an object at the origin.
struct TouchPoint {
  Vec3 tool_point_T, normal;
  double gap = 0;
};

/// A contact set of a renderer whose tool never enters an object.
inline std::unique_ptr<ContactSet> rigid_set(const Pose& X_WG,
                                             const std::vector<TouchPoint>& touches) {
  auto set = std::make_unique<ContactSet>();
  *set = {};
  set->objects.resize(1);
  set->X_WG = X_WG;
  set->tool = {0.1, {1e-4, 1e-4, 1e-4}, {}, 0.05};
  for (const TouchPoint& touch : touches) {
    Contact c{};
    c.tool_point_T = touch.tool_point_T;
    c.object_point_O = X_WG * touch.tool_point_T - touch.gap * touch.normal;
    c.normal_O = c.shading_normal_O = touch.normal;
    c.feature = set->contacts.size() + 1;
    set->contacts.push_back(c);
  }
  set->n_active = static_cast<uint32_t>(touches.size());
  return set;
}

/// Corners of a square of half side `a`, at z = `bottom` of the tool, on the floor.
inline std::vector<TouchPoint> corners_on_floor(double a, double bottom, double gap = 0) {
  std::vector<TouchPoint> touches;
  for (const double x : {-a, a}) {
    for (const double y : {-a, a}) touches.push_back({{x, y, bottom}, {0, 0, 1}, gap});
  }
  return touches;
}

/// Contacts all around a tool of this radius: few or many, on a plane, around a peg, some duplicate
/// or opposite; gaps of at most `reach`.
inline std::vector<TouchPoint> random_touches(Random& random, double radius, double reach) {
  const size_t n = 1 + random.index(random.index(3) == 0 ? kMaxContacts : 8);
  const size_t arrangement = random.index(4);
  const Vec3 axis = random.direction();
  std::vector<TouchPoint> touches;
  while (touches.size() < n) {
    TouchPoint t{random.uniform(0, radius) * random.direction(), random.direction(),
                 random.index(2) == 0 ? 0 : random.uniform(0, reach)};
    if (arrangement == 1) t.normal = axis;
    if (arrangement == 2) t.normal = normalized(cross(axis, t.normal));
    if (!touches.empty() && random.index(5) == 0) t = touches[random.index(touches.size())];
    if (!touches.empty() && random.index(5) == 0) {
      t = touches[random.index(touches.size())];
      t.normal = -t.normal;
    }
    touches.push_back(t);
  }
  return touches;
}

/// Two rings of contacts around a peg of 5 mm.
inline std::vector<TouchPoint> wall_of_hole(double gap) {
  std::vector<TouchPoint> wall;
  for (const double z : {-0.02, 0.02}) {
    for (int i = 0; i < 12; ++i) {
      const Vec3 out{std::cos(30 * i * kDegree), std::sin(30 * i * kDegree), 0};
      wall.push_back({0.005 * out + Vec3{0, 0, z}, -out, gap});
    }
  }
  return wall;
}

/// The materials of an object with that friction.
inline Materials rough(double friction) {
  Materials materials;
  materials.of_object[0].friction_static = materials.of_object[0].friction_dynamic = friction;
  return materials;
}

/// A solver with its state from tick to tick.
class RigidLoop {
 public:
  explicit RigidLoop(Renderer renderer) : renderer_(renderer) {
    tick.coupling = {800, 0, 2, 0, 0, 0};
    tick.X_WO.resize(1);
    tick.V_WO.resize(1);
  }
  Constrained6Model model;
  Materials materials;
  BodyTick tick;  // poses and twists of the objects, weight, dt
  GodObject6State god_object;
  Constrained6State constrained;

  BodySolution step(const ToolMotion& hand, const ContactSet& set) {
    tick.hand = hand;
    tick.contacts = &set;
    return renderer_ == Renderer::kGodObject6
               ? solve_god_object6(materials, god_object, solvers_.coulomb, tick)
               : solve_constrained6(model, materials, constrained, solvers_, tick);
  }
  /// With a hand at rest.
  BodySolution hold(const Pose& X_WT, const ContactSet& set) {
    return step(ToolMotion{X_WT, {}}, set);
  }

 private:
  Renderer renderer_;
  ContactSolvers solvers_;
};

}  // namespace haptic::test
