// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/pair.h"

#include "clients/lab/bench/peers/fcl_pose.h"

#ifdef HAPTICD_FCL
#include <fcl/fcl.h>
#endif

namespace haptic {

#ifdef HAPTICD_FCL
namespace {

using Tree = fcl::BVHModel<fcl::OBBRSSd>;

std::unique_ptr<Tree> tree_of(const TriangleMesh& mesh) {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  for (const Vec3& v : mesh.vertices) vertices.emplace_back(v.x, v.y, v.z);
  for (const auto& [a, b, c] : mesh.triangles) triangles.emplace_back(a, b, c);
  auto tree = std::make_unique<Tree>();
  tree->beginModel();
  tree->addSubModel(vertices, triangles);
  tree->endModel();
  return tree;
}

class FclPeer : public PairPeer {
 public:
  FclPeer(const TriangleMesh& object, const TriangleMesh& tool)
      : object_(tree_of(object)), tool_(tree_of(tool)) {}

  bool collides(const Pose& X_OT) override {
    fcl::CollisionResultd result;
    fcl::collide(tool_.get(), fcl_pose(X_OT), object_.get(), fcl::Transform3d::Identity(),
                 fcl::CollisionRequestd(), result);
    return result.isCollision();
  }
  double distance(const Pose& X_OT) override {
    fcl::DistanceResultd result;
    fcl::distance(tool_.get(), fcl_pose(X_OT), object_.get(), fcl::Transform3d::Identity(),
                  fcl::DistanceRequestd(), result);
    return result.min_distance;
  }

 private:
  std::unique_ptr<Tree> object_, tool_;
};

}  // namespace

std::unique_ptr<PairPeer> make_fcl_peer(const TriangleMesh& object, const TriangleMesh& tool) {
  return std::make_unique<FclPeer>(object, tool);
}
#else
std::unique_ptr<PairPeer> make_fcl_peer(const TriangleMesh&, const TriangleMesh&) {
  return nullptr;
}
#endif

}  // namespace haptic
