// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/contact_model.h"

#include <algorithm>
#include <cmath>

#include "contact/query/triangle/plane_extent.h"
#include "contact/query/triangle/shading_normal.h"
#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kRelativeEpsilon = 1e-10;  // of the largest object: 10⁵ times its rounding

}  // namespace

ContactModel build_contact_model(const SessionConfig& config, const ContactShapes& shapes) {
  HAPTIC_ASSERT(config.n_objects <= kMaxObjects && config.n_objects <= shapes.objects.size());
  HAPTIC_ASSERT(config.servo_rate > 0 && config.proxy_radius >= 0);
  ContactModel model;
  model.n_objects = config.n_objects;
  model.renderer = config.renderer;
  model.servo_period = model.prediction = 1 / config.servo_rate;
  model.radius = config.proxy_radius;
  model.grasp_button = config.map.grasp_button;
  double largest = 0;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.shapes[i] = shapes.objects[i];
    model.X_WO[i] = config.objects[i].X_WO;
    const MaterialConfig& material = config.objects[i].material;
    model.crease_cosine[i] = std::cos(material.crease_angle);
    model.has_friction |= material.friction_static > 0 || material.friction_dynamic > 0;
    largest = std::max(largest, norm(model.shapes[i].mesh.upper - model.shapes[i].mesh.lower));
  }
  model.epsilon = kRelativeEpsilon * largest;
  model.bodies = build_body_model(config, shapes.bodies, shapes.objects);
  model.rigid = god_object_options(config, model.bodies.body);
  return model;
}

PointScene scene_at(const ContactModel& model, const SceneFrame* scene, const ServoFrame& servo,
                    int64_t t_ns) {
  HAPTIC_ASSERT(model.n_objects <= kMaxObjects);
  PointScene now;
  now.shapes = {model.shapes.data(), model.n_objects};
  now.X_WO = model.X_WO;
  now.epsilon = model.epsilon;
  if (scene == nullptr) return now;
  for (uint32_t i = 0; i < std::min(model.n_objects, scene->n_objects); ++i) {
    now.X_WO[i] = object_pose_at(*scene, i, t_ns, push_of(servo));
  }
  return now;
}

std::array<Twist, kMaxObjects> twists_at(const ContactModel& model, const SceneFrame* scene,
                                         const ServoFrame& servo) {
  HAPTIC_ASSERT(model.n_objects <= kMaxObjects);
  std::array<Twist, kMaxObjects> V_WO{};
  if (scene == nullptr) return V_WO;
  for (uint32_t i = 0; i < std::min(model.n_objects, scene->n_objects); ++i) {
    V_WO[i] = object_twist_at(*scene, i, servo.t_ns, push_of(servo));
  }
  return V_WO;
}

Contact contact_at(const PointScene& scene, const FacetContact& at, double crease_cosine) {
  HAPTIC_ASSERT(at.object < scene.shapes.size());
  const TriangleMesh& mesh = scene.shapes[at.object].mesh;
  HAPTIC_ASSERT(at.triangle < mesh.triangles.size());
  HAPTIC_ASSERT(is_unit(at.normal_O));
  Contact c{};
  c.tool_point_T = -scene.radius * at.normal_O;
  c.object_point_O = at.point_O;
  c.normal_O = at.normal_O;
  c.shading_normal_O = crease_cosine < 1
                           ? shading_normal(mesh, at.triangle, at.point_O, crease_cosine)
                           : at.normal_O;
  c.extent = plane_extent(mesh, at.triangle, at.point_O);
  c.object = c.material = at.object;
  c.feature = at.feature.id();
  return c;
}

}  // namespace haptic
