// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/contact_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/query/triangle/plane_extent.h"
#include "contact/query/triangle/shading_normal.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kRelativeEpsilon = 1e-10;     // of the largest object: 10⁵ times its rounding
constexpr double kMarginOfRadius = 1e-4;       // default margin of a rigid tool, per radius
constexpr uint32_t kMostPiecePairs = 1 << 16;  // in memory, per object
constexpr double kClusterShare = 0.25;         // radius of a cluster from triangles, of the tool's

/// Contacts from which on they share what so many have.
double sharing_of(const ProxyConfig& proxy) {
  constexpr double kCornersOfABox = 4;
  return proxy.sharing == Sharing::kNone ? std::numeric_limits<double>::infinity() : kCornersOfABox;
}

void add_pieces(const SessionConfig& config, const BodyShapes& shapes, ContactModel& model) {
  PieceModel& pieces = model.pieces;
  static_cast<PushOptions&>(pieces) = model.exact;
  if (config.pieces.cluster_radius > 0) pieces.clusters.radius = config.pieces.cluster_radius;
  pieces.tool = shapes.tool_pieces;
  pieces.objects = shapes.pieces;
  pieces.refine.threshold = config.pieces.threshold;
  pieces.refine.carry = config.pieces.carry;
  pieces.refine.bandwidth = config.pieces.bandwidth;
  if (config.pieces.budget > 0) pieces.refine.budget = config.pieces.budget;
  // pieces that a cluster swallows anyhow touch at one place
  pieces.refine.spread = 0.5 * pieces.clusters.radius;
  pieces.search = model.body.radius;
  pieces.tool_radius = norm(model.body.centre_T) + model.body.radius;
  for (const PieceTree& object : pieces.objects) {
    const uint64_t all = uint64_t{object.pieces.size()} * pieces.tool.pieces.size();
    pieces.most_pairs.push_back(static_cast<uint32_t>(std::min<uint64_t>(all, kMostPiecePairs)));
  }
}

void add_maps(const SessionConfig& config, const BodyShapes& shapes, ContactModel& model) {
  HAPTIC_ASSERT(shapes.volumes.size() == model.shapes.size());
  model.volumes = shapes.volumes;
  model.voxel = voxel_model(config.voxel, shapes.shell);
  model.voxel.objects = model.volumes;
  // the proxy may move half a band without any clearance
  model.clearance = {model.tool, model.body, 0.5 * config.voxel.band, {}};
  for (size_t i = 0; i < model.volumes.size(); ++i) {
    const bool is_sheet = !model.shapes[i].mesh.closed;
    const double layer = push_layer(model.voxel, model.volumes[i], is_sheet);
    model.clearance.objects.push_back({model.shapes[i], layer});
  }
}

void add_tool(const SessionConfig& config, const BodyShapes& shapes, ContactModel& model) {
  model.tool = shapes.tool;
  model.body = tool_body(shapes.tool.mesh, config.tool);
  model.exact.stiffness = config.proxy.contact_stiffness;
  model.exact.sharing = sharing_of(config.proxy);
  model.exact.clusters.radius = kClusterShare * model.body.radius;
  if (!shapes.pieces.empty()) add_pieces(config, shapes, model);
  if (!shapes.volumes.empty()) add_maps(config, shapes, model);
}

}  // namespace

GodObject6Options god_object_options(const SessionConfig& config, const ToolBody& body) {
  GodObject6Options options;
  options.k_s = config.rigid.k_s;
  options.margin = config.rigid.margin > 0 ? config.rigid.margin : kMarginOfRadius * body.radius;
  options.moves = config.rigid.moves;
  const Coupling& springs = config.coupling;
  if (springs.translational_stiffness > 0) {
    options.translational_stiffness = springs.translational_stiffness;
  }
  if (springs.rotational_stiffness > 0) {
    options.rotational_stiffness = springs.rotational_stiffness;
  }
  return options;
}

ContactModel build_contact_model(const SessionConfig& config, const ContactShapes& shapes) {
  HAPTIC_ASSERT(config.n_objects <= kMaxObjects && config.n_objects <= shapes.objects.size());
  HAPTIC_ASSERT(config.servo_rate > 0 && config.proxy_radius >= 0);
  ContactModel model;
  model.shapes.assign(shapes.objects.begin(), shapes.objects.begin() + config.n_objects);
  model.hand = config.hand;
  model.n_tools = config.n_tools;
  model.renderer = config.renderer;
  model.servo_period = model.prediction = 1 / config.servo_rate;
  model.radius = config.proxy_radius;
  model.grasp_button = config.map.grasp_button;
  double largest = 0;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.X_WO.push_back(config.objects[i].X_WO);
    const MaterialConfig& material = config.objects[i].material;
    model.crease_cosine[i] = std::cos(material.crease_angle);
    model.has_friction |= material.friction_static > 0 || material.friction_dynamic > 0;
    largest = std::max(largest, norm(model.shapes[i].mesh.upper - model.shapes[i].mesh.lower));
  }
  model.epsilon = kRelativeEpsilon * largest;
  if (!shapes.bodies.tool.mesh.triangles.empty()) add_tool(config, shapes.bodies, model);
  model.rigid = god_object_options(config, model.body);
  model.given = build_given_touch(config);
  return model;
}

PointScene scene_at(const ContactModel& model, const SceneFrame* scene, const ServoFrame& servo,
                    int64_t t_ns) {
  PointScene now;
  now.shapes = model.shapes;
  now.X_WO = model.X_WO;
  now.epsilon = model.epsilon;
  if (scene == nullptr) return now;
  for (uint32_t i = 0; i < std::min(model.shapes.size(), scene->objects.size()); ++i) {
    now.X_WO[i] = object_pose_at(*scene, i, t_ns, push_of(servo, model.hand));
  }
  return now;
}

PerObject<Twist> twists_at(const ContactModel& model, const SceneFrame* scene,
                           const ServoFrame& servo) {
  PerObject<Twist> V_WO(model.shapes.size());
  if (scene == nullptr) return V_WO;
  for (uint32_t i = 0; i < std::min(model.shapes.size(), scene->objects.size()); ++i) {
    V_WO[i] = object_twist_at(*scene, i, servo.t_ns, push_of(servo, model.hand));
  }
  return V_WO;
}

Contact contact_at(const PointScene& scene, const ProxyPlane& facet, const ProxySupport& at,
                   double crease_cosine) {
  HAPTIC_ASSERT(facet.object < scene.shapes.size());
  const TriangleMesh& mesh = scene.shapes[facet.object].mesh;
  HAPTIC_ASSERT(facet.triangle < mesh.triangles.size());
  HAPTIC_ASSERT(is_unit(at.normal_O));
  Contact c{};
  c.tool_point_T = -scene.radius * at.normal_O;
  c.object_point_O = at.point_O;
  c.normal_O = at.normal_O;
  c.shading_normal_O = crease_cosine < 1
                           ? shading_normal(mesh, facet.triangle, at.point_O, crease_cosine)
                           : at.normal_O;
  c.extent = plane_extent(mesh, facet.triangle, at.point_O);
  c.object = facet.object;
  c.feature = at.feature.id();
  return c;
}

}  // namespace haptic
