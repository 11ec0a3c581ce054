// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/voxel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/detect/body/cluster_contact.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kClusterVoxels = 5;    // radius of a cluster, in voxels
constexpr double kLeastFacing = 0.1;    // least cosine between a cluster's normal and the object's
constexpr double kMostCells = 16;       // largest extent, in cells
constexpr double kGrowth = 0.35;        // least growth of distance per step that marks an edge
constexpr double kBetween = 0.92388;    // cos 22.5°, half the angle between two directions
constexpr double kLeastGradient = 0.1;  // least gradient with a meaningful direction
constexpr double kBendReach = 4e-3;     // distance over which a bend is measured [m] …
constexpr double kBendCells = 4;        // … or as many cells, beyond the field's own errors
constexpr double kFieldError = 0.02;    // of a field between its nodes, in cells

/// The rest of the budget is shared by the remaining objects.
uint32_t share_of_budget(const VoxelModel& model, const VoxelState& state, uint32_t object) {
  HAPTIC_ASSERT(object < model.objects.size());
  const uint64_t left = model.budget - std::min<uint64_t>(state.tested, model.budget);
  return static_cast<uint32_t>(left / (model.objects.size() - object));
}

/// Nearer to an object than this a point is reported [m].
double reach_of(const VoxelModel& model, const BodyQuestion& question, uint32_t object) {
  return std::min(model.force.offset + question.reach, model.objects[object].field.band);
}

/// Points come within reach with weight zero.
ClusterOptions cluster_options(const VoxelModel& model, const BodyQuestion& question,
                               uint32_t object) {
  ClusterOptions options = model.clusters;
  options.tolerance = model.reading == VoxelForce::kField
                          ? std::max(reach_of(model, question, object) - model.force.offset, 0.0)
                          : deepest_in_voxel(model.objects[object].map);
  return options;
}

/// The points of one object that touch or approach, in its frame.
std::span<const PointPush> shell_pushes_on(const VoxelModel& model, VoxelState& state,
                                           const BodyQuestion& question, uint32_t object,
                                           ContactSet& set) {
  HAPTIC_ASSERT(object < model.objects.size() && state.coherence.size() == model.objects.size());
  const VoxelObject& shape = model.objects[object];
  const Pose X_OT = question.X_OT(object);
  size_t n = 0;
  if (model.reading == VoxelForce::kTangentPlanes) {
    const auto count = static_cast<uint32_t>(model.shell.x.size());
    const size_t hits = scan_voxels(shape.map, model.shell, shell_in_voxels(shape.map, X_OT), 0,
                                    count, fastest_scan(), state.hits, 0);
    state.tested += count;
    n = pushes_from_voxels(shape.map, model.shell, X_OT, {state.hits.data(), hits}, model.force,
                           state.pushes);
  } else {
    const ShellAnswer answer =
        find_touches(shape.field, model.shell, X_OT,
                     {reach_of(model, question, object), share_of_budget(model, state, object),
                      model.force.offset},
                     state.coherence[object], state.visited, state.touches);
    state.tested += answer.tested;
    if (!answer.is_complete) set.flags |= kContactIterationLimit;
    n = pushes_from_field(model.shell, X_OT, {state.touches.data(), answer.n}, model.force,
                          state.pushes);
  }
  const std::span<const PointPush> pushes(state.pushes.data(), n);
  state.touching += static_cast<uint64_t>(std::count_if(
      pushes.begin(), pushes.end(), [](const PointPush& push) { return push.depth > 0; }));
  // a tangent plane does not bound the depth
  const double layer = model.reading == VoxelForce::kField ? model.force.offset : 0;
  state.is_outside &= std::none_of(pushes.begin(), pushes.end(),
                                   [&](const PointPush& push) { return push.depth > layer; });
  return pushes;
}

/// Direction away from the object at a cluster: the field's gradient, else the cluster's normal.
Vec3 away_from(const VoxelObject& shape, const PushCluster& cluster) {
  if (shape.field.index.empty()) return cluster.normal_O;
  const Vec3 gradient = sample_field(shape.field, cluster.point_O).gradient_O;
  return norm(gradient) > kLeastGradient ? normalized(gradient) : cluster.normal_O;
}

/// How far the object continues around a cluster, by doubling steps in eight directions along the
/// plane. A distance changes by no more than the way: where it has grown by g at a step s, the
/// surface has begun to turn away before s − g. So extent = cos 22.5° · the largest s − g, until g
/// exceeds kGrowth · s. 0: there is no field.
double extent_at(const VoxelObject& shape, const PushCluster& cluster) {
  if (shape.field.index.empty()) return 0;
  HAPTIC_ASSERT(shape.field.cell > 0);
  const Vec3 n = cluster.normal_O;
  const Vec3 u = normalized(cross(n, std::fabs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(n, u), d = std::sqrt(0.5) * (u + v), e = std::sqrt(0.5) * (u - v);
  const double here = sample_field(shape.field, cluster.point_O).distance;
  double extent = 0.5 * shape.field.cell;
  for (double step = shape.field.cell; step <= kMostCells * shape.field.cell; step *= 2) {
    double growth = 0;
    for (const Vec3& way : {u, v, d, e, -u, -v, -d, -e}) {
      growth =
          std::max(growth, sample_field(shape.field, cluster.point_O + step * way).distance - here);
    }
    extent = std::max(extent, kBetween * (step - growth));
    if (growth > kGrowth * step) break;
  }
  return extent;
}

/// Least curvature of the object below a cluster, from second differences of its field over 4 mm or
/// four cells along four lines in the plane; as in plane_patch.h, 0 where it is not convex or
/// nothing is known. Ours.
double curvature_at(const VoxelObject& shape, const PushCluster& cluster, const Vec3& away_O) {
  if (shape.field.index.empty()) return 0;
  const double step = std::max(kBendReach, kBendCells * shape.field.cell);
  const FieldSample here = sample_field(shape.field, cluster.point_O);
  const Vec3 u =
      normalized(cross(away_O, std::fabs(away_O.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(away_O, u);
  const double half = std::sqrt(0.5);
  double mean = 0, least = std::numeric_limits<double>::infinity();
  std::array<double, 4> bends{};
  const std::array<Vec3, 4> ways{u, half * (u + v), v, half * (v - u)};
  for (size_t k = 0; k < ways.size(); ++k) {
    const FieldSample there = sample_field(shape.field, cluster.point_O + step * ways[k]);
    const FieldSample back = sample_field(shape.field, cluster.point_O - step * ways[k]);
    if (!there.is_near || !back.is_near) return 0;
    bends[k] = (there.distance + back.distance - 2 * here.distance) / (step * step);
    mean += 0.25 * bends[k];
    least = std::min(least, bends[k]);
  }
  const double across = std::hypot(0.5 * (bends[0] - bends[2]), 0.5 * (bends[1] - bends[3]));
  const double error = 2 * kFieldError * shape.field.cell / (step * step);
  const double curvature = std::min(mean - across, least);
  return curvature > error ? curvature : 0;
}

/// Curvature of the gap below a cluster as the tool slides: that of both surfaces, which roll on
/// each other (contact_reach.h); the tool's is how much the cluster's normals diverge.
double curvature_of(const VoxelObject& shape, const PushCluster& cluster, const Vec3& away_O) {
  if (!(cluster.bulge > 0)) return 0;
  const double object = curvature_at(shape, cluster, away_O);
  return object > 0 ? object * cluster.bulge / (object + cluster.bulge) : 0;
}

/// Braking matrix of the points that approach an object, about the tool's origin, in O.
Mat6 braking_on(const VoxelModel& model, const BodyQuestion& question, uint32_t object,
                std::span<const PointPush> pushes) {
  if (!(model.damping > 0)) return {};
  const Pose& X_WO = question.X_WO[object];
  const Pose X_OW = inverse(X_WO);
  const Twist& V_WO = question.V_WO[object];
  const Vec3 v_W = question.V_WT.v - velocity_at(V_WO, question.X_WT.p - X_WO.p);
  const Twist V_O{rotate(X_OW.q, v_W), rotate(X_OW.q, question.V_WT.w - V_WO.w)};
  return braking_matrix(pushes, V_O, X_OW * question.X_WT.p, model.damping, model.braking);
}

/// Stores the linearised wrench of these points on the tool, about its origin, in W.
void linearise_on(const VoxelModel& model, const BodyQuestion& question, uint32_t object,
                  std::span<const PointPush> pushes, const Mat6& B_O, ContactSet& set) {
  const Pose& X_WO = question.X_WO[object];
  const LinearPush sum = sum_pushes(pushes, question.X_OT(object).p);
  const Mat3 R = to_matrix(X_WO.q);
  set.F0_W = {R * sum.F0_O.f, R * sum.F0_O.t};
  set.K = rotated(R, sum.K).a;
  set.B = rotated(R, B_O).a;
  set.wrench_object = object;
  set.trust_radius = model.trust_radius;
}

/// Moves the contacts of the object with the wrench to the front; those of an object are
/// contiguous.
void put_first(uint32_t object, ContactSet& set) {
  const auto end = set.contacts.end();
  const auto is_its = [&](const Contact& c) { return c.object == object; };
  const auto first = std::find_if(set.contacts.begin(), end, is_its);
  std::rotate(set.contacts.begin(), first, std::find_if_not(first, end, is_its));
}

}  // namespace

VoxelModel voxel_model(const VoxelConfig& config, const Pointshell& shell) {
  HAPTIC_ASSERT(config.size > 0);
  VoxelModel model;
  model.shell = shell;
  model.reading = config.field != 0 ? VoxelForce::kField : VoxelForce::kTangentPlanes;
  model.force.stiffness = config.stiffness;
  // the same offset as in the baked map
  model.force.offset = config.offset_layers * config.size;
  model.clusters.radius = kClusterVoxels * config.size;
  if (config.budget > 0) model.budget = config.budget;
  model.damping = config.braking;
  model.braking = config.braking_along;
  model.trust_radius = config.size;
  return model;
}

double push_layer(const VoxelModel& model, const VoxelObject& object, bool is_sheet) {
  if (model.reading == VoxelForce::kField) {
    const DistanceField& field = object.field;
    // half of a sheet's thickness lies on either side of it
    return (is_sheet ? 0.5 * field.cell : 0) - way_to(model.force.offset, {0, false}, field.cell);
  }
  // diagonals of the voxel that is met, of the layers, and of a proximity voxel
  return std::sqrt(3.0) * (model.force.offset + 2 * object.map.size);
}

VoxelState::VoxelState(const VoxelModel& model)
    : visited(model.shell.nodes.size() + 1),
      touches(model.shell.x.size()),
      hits(model.shell.x.size() + 64),
      pushes(model.shell.x.size()),
      clusters(model.objects.size()) {
  for (size_t i = 0; i < model.objects.size(); ++i) coherence.emplace_back(model.shell);
}

void detect_voxel(const VoxelModel& model, VoxelState& state, const BodyQuestion& question,
                  ContactSet& set) {
  HAPTIC_ASSERT(model.objects.size() <= kMaxObjects);
  HAPTIC_ASSERT(model.trust_radius > 0 && question.reach >= 0);
  state.tested = state.touching = 0;
  state.is_outside = true;
  set.contacts.clear();
  set.n_active = 0;
  set.F0_W = {};
  set.K = set.B = {};
  set.trust_radius = 0;
  // force, or if nothing is pressed, damping
  std::pair hardest{0.0, 0.0};
  const auto clusters_of = [&](uint32_t object, std::span<PushCluster> room) {
    const VoxelObject& shape = model.objects[object];
    const auto pushes = shell_pushes_on(model, state, question, object, set);
    const size_t found = cluster_pushes(pushes, cluster_options(model, question, object),
                                        state.clusters[object], room);
    if (found == room.size()) set.flags |= kContactTruncated;
    size_t n = 0;
    double pressed = 0;
    for (PushCluster& cluster : room.first(found)) {
      // a side of the tool beside the place of contact would hold, or pull, a tool that leaves
      const Vec3 away_O = away_from(shape, cluster);
      if (dot(away_O, cluster.normal_O) < kLeastFacing) continue;
      // what does not push yet comes nearer as the object lies, not as the tool's points face it
      if (!(cluster.depth > 0)) cluster.normal_O = away_O;
      pressed += cluster.stiffness * std::max(cluster.depth, 0.0);
      room[n++] = cluster;
    }
    const Mat6 B_O = braking_on(model, question, object, pushes);
    const std::pair hard{pressed, -(B_O(0, 0) + B_O(1, 1) + B_O(2, 2))};
    if (hard > hardest) {
      hardest = hard;
      linearise_on(model, question, object, pushes, B_O, set);
    }
    return n;
  };
  const auto describe = [&](uint32_t object, const PushCluster& cluster, Contact& c) {
    c.shading_normal_O = away_from(model.objects[object], cluster);
    c.extent = extent_at(model.objects[object], cluster);
    c.curvature = curvature_of(model.objects[object], cluster, c.shading_normal_O);
  };
  // if clusters had to mix normals for lack of room, a solver that uses clusters alone would lose
  // their torque
  add_clusters(question, model.objects.size(), kMaxContacts, set, clusters_of, describe);
  if (set.trust_radius > 0) put_first(set.wrench_object, set);
}

}  // namespace haptic
