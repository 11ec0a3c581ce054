// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "contact/detect/body/cluster_contact.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/voxel.h"
#include "contact/query/point/closest_point.h"
#include "servo/solve/body/soft_proxy.h"
#include "tests/support/meshes.h"

namespace haptic::test {

/// The contact detector.
enum class Asked { kField, kTangentPlanes, kExact };

/// A fixed obstacle at the origin and a tool, with the shapes for all detectors.
struct SoftPair {
  MeshShapeData object, tool;
  VoxmapData map;
  DistanceFieldData field;
  PointshellData shell;
  std::array<VoxelObject, 1> objects;
  double size = 0;  // edge of voxels and cells, and point spacing [m]

  SoftPair(const Soup& object_soup, const Soup& tool_soup, double voxel)
      : object(build_shape(object_soup)), tool(build_shape(tool_soup)), size(voxel) {
    map = build_voxmap(object.mesh.view(), {size, 2});
    ClosestWitness witness;
    const auto distance = [&](const Vec3& p) {
      const ClosestPoint c = closest_point(object.view(), p, 10, witness);
      return c.inside ? -c.distance : c.distance;
    };
    const TriangleMesh mesh = object.mesh.view();
    field = build_distance_field(mesh.lower, mesh.upper, distance, {size, 4 * size, 4 * size});
    shell = build_pointshell(tool.mesh.view(), size);
    objects = {{{map.view(), field.view()}}};
  }
  SoftPair(const SoftPair&) = delete;
};

/// Contact and servo in lockstep: a contact set is computed every `every` ticks at the proxy's pose
/// then, or the hand's for direct rendering, and is available at most `every` ticks later.
class SoftLoop {
 public:
  SoftProxyModel model;
  BodyTick in_force;  // tool and coupling
  VoxelModel voxel;
  int every = 1;  // ticks from one contact set to the next
  SoftProxyState state;
  ContactSet& set() { return *set_; }

  SoftLoop(const SoftPair& pair, Asked asked) : pair_(pair), asked_(asked) {
    voxel.shell = pair.shell.view();
    voxel.objects = pair.objects;
    voxel.reading =
        asked == Asked::kTangentPlanes ? VoxelForce::kTangentPlanes : VoxelForce::kField;
    voxel.trust_radius = pair.size;
    in_force.tool.radius = pair.shell.radius;
    in_force.X_WO.resize(1);
    in_force.V_WO.resize(1);
    detector_ = std::make_unique<VoxelState>(voxel);
  }

  BodySolution tick(const ToolMotion& hand, double dt = 1e-3) {
    if (ticks_++ % every == 0) ask(hand);
    BodyTick now = in_force;
    now.hand = hand;
    now.contacts = set_.get();
    now.dt = dt;
    return solve_soft_proxy(model, state, now);
  }

 private:
  void ask(const ToolMotion& hand) {
    const bool at_hand = model.solver == SoftSolver::kDirect || !state.started;
    const ToolMotion& tool = at_hand ? hand : state.proxy;
    *set_ = {};
    set_->objects.resize(1);
    set_->X_WT = tool.X_WT;
    if (asked_ == Asked::kExact) return ask_exact(tool.X_WT);
    BodyQuestion question;
    question.X_WT = tool.X_WT;
    question.V_WT = tool.V_WT;
    question.X_WO.resize(1);
    question.V_WO.resize(1);
    question.reach = pair_.size;
    detect_voxel(voxel, *detector_, question, *set_);
  }

  /// Each cluster is one contact; there is no linearised wrench.
  void ask_exact(const Pose& X_OT) {
    std::array<PushCluster, 16> clusters;
    PushOptions options;
    options.stiffness = voxel.force.stiffness;
    options.clusters = voxel.clusters;
    const ExactAnswer answer = exact_contacts(pair_.object.view(), pair_.tool.view(), X_OT, options,
                                              memory_, {pairs_, pushes_}, clusters);
    for (size_t i = 0; i < answer.n_clusters; ++i) {
      set_->contacts.push_back(contact_of(clusters[i], 0, {}, X_OT));
    }
    set_->n_active = static_cast<uint32_t>(set_->contacts.size());
  }

  const SoftPair& pair_;
  Asked asked_;
  std::unique_ptr<VoxelState> detector_;
  std::unique_ptr<ContactSet> set_ = std::make_unique<ContactSet>();
  std::vector<TrianglePair> pairs_ = std::vector<TrianglePair>(20000);
  std::vector<PointPush> pushes_ = std::vector<PointPush>(kPushesPerPair * 20000);
  ClusterMemory memory_;
  int ticks_ = 0;
};

/// A ball with bumps all over.
inline Soup make_bumpy_ball(double radius, uint32_t subdivisions) {
  Soup soup = make_icosphere(radius, subdivisions);
  for (Vec3& v : soup.vertices) {
    const Vec3 q = (1 / radius) * v;
    v = (1 + 0.08 * std::sin(9 * q.x) * std::sin(8 * q.y + 1) * std::sin(7 * q.z + 2)) * v;
  }
  return soup;
}

}  // namespace haptic::test
