// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/depth.h"

#include <cmath>
#include <memory>

#include "clients/lab/bench/peers/fcl_pose.h"

#ifdef HAPTICD_BULLET
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <btBulletCollisionCommon.h>
#endif
#ifdef HAPTICD_CCD
#include <ccd/ccd.h>
#include <ccd/quat.h>
#endif
#ifdef HAPTICD_FCL
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#endif

namespace haptic {
namespace {

#ifdef HAPTICD_BULLET
static_assert(sizeof(btScalar) == sizeof(double), "Bullet's double build is the peer");

class BulletPair {
 public:
  BulletPair(const Hull& a, const Hull& b) {
    for (const Vec3& p : a.vertices) a_.addPoint({p.x, p.y, p.z}, false);
    for (const Vec3& p : b.vertices) b_.addPoint({p.x, p.y, p.z}, false);
    for (btConvexHullShape* shape : {&a_, &b_}) shape->setMargin(0), shape->recalcLocalAabb();
  }
  double depth(const Pose& X_AB) {
    const btTransform at_a(btQuaternion::getIdentity());
    const btTransform at_b({X_AB.q.x, X_AB.q.y, X_AB.q.z, X_AB.q.w},
                           {X_AB.p.x, X_AB.p.y, X_AB.p.z});
    btGjkEpaSolver2::sResults found;
    const bool meets =
        btGjkEpaSolver2::Penetration(&a_, at_a, &b_, at_b, at_b.getOrigin(), found, false);
    return meets ? std::fabs(found.distance) : -1;
  }

 private:
  btConvexHullShape a_, b_;
};
#endif

#ifdef HAPTICD_CCD
struct CcdHull {
  const Hull& hull;
  Pose X;
};

void ccd_support(const void* object, const ccd_vec3_t* way, ccd_vec3_t* out) {
  const auto& at = *static_cast<const CcdHull*>(object);
  const Vec3 local = rotate(conjugate(at.X.q), {way->v[0], way->v[1], way->v[2]});
  const Vec3* best = &at.hull.vertices[0];
  for (const Vec3& p : at.hull.vertices) {
    if (dot(local, p) > dot(local, *best)) best = &p;
  }
  const Vec3 p = at.X * *best;
  ccdVec3Set(out, p.x, p.y, p.z);
}

double ccd_depth(const Hull& a, const Hull& b, const Pose& X_AB) {
  ccd_t options;
  CCD_INIT(&options);
  options.support1 = options.support2 = ccd_support;
  options.max_iterations = 500;
  options.epa_tolerance = 1e-9;  // [m]
  const CcdHull at_a{a, {}}, at_b{b, X_AB};
  ccd_real_t depth = 0;
  ccd_vec3_t direction, place;
  const int failed = ccdGJKPenetration(&at_a, &at_b, &options, &depth, &direction, &place);
  return failed == 0 ? depth : -1;
}
#endif

#ifdef HAPTICD_FCL
std::shared_ptr<fcl::Convexd> fcl_hull(const Hull& hull) {
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
  for (const Vec3& p : hull.vertices) vertices->emplace_back(p.x, p.y, p.z);
  auto faces = std::make_shared<std::vector<int>>();
  for (const HullFace& face : hull.faces) {
    faces->push_back(static_cast<int>(face.n_edges));
    for (uint32_t k = 0; k < face.n_edges; ++k) {
      faces->push_back(static_cast<int>(hull.edges[face.first_edge + k].from));
    }
  }
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(hull.faces.size()), faces);
}

double fcl_depth(const fcl::Convexd& a, const fcl::Convexd& b, const Pose& X_AB) {
  fcl::CollisionResultd found;
  fcl::collide(&a, fcl::Transform3d::Identity(), &b, fcl_pose(X_AB),
               fcl::CollisionRequestd(1, true), found);
  return found.isCollision() ? found.getContact(0).penetration_depth : -1;
}

double fcl_distance(const fcl::Convexd& a, const fcl::Convexd& b, const Pose& X_AB) {
  fcl::DistanceResultd found;
  fcl::distance(&a, fcl::Transform3d::Identity(), &b, fcl_pose(X_AB), fcl::DistanceRequestd(true),
                found);
  return found.min_distance;
}
#endif

}  // namespace

std::vector<HullPeer> depth_peers([[maybe_unused]] const Hull& a, [[maybe_unused]] const Hull& b) {
  std::vector<HullPeer> peers;
#ifdef HAPTICD_BULLET
  const auto bullet = std::make_shared<BulletPair>(a, b);
  peers.push_back({"Bullet GJK-EPA", [bullet](const Pose& X) { return bullet->depth(X); }});
#endif
#ifdef HAPTICD_CCD
  peers.push_back({"libccd GJK-EPA", [&a, &b](const Pose& X) { return ccd_depth(a, b, X); }});
#endif
#ifdef HAPTICD_FCL
  peers.push_back({"FCL", [at_a = fcl_hull(a), at_b = fcl_hull(b)](const Pose& X) {
                     return fcl_depth(*at_a, *at_b, X);
                   }});
#endif
  return peers;
}

std::vector<HullPeer> distance_peers([[maybe_unused]] const Hull& a,
                                     [[maybe_unused]] const Hull& b) {
  std::vector<HullPeer> peers;
#ifdef HAPTICD_FCL
  peers.push_back({"FCL", [at_a = fcl_hull(a), at_b = fcl_hull(b)](const Pose& X) {
                     return fcl_distance(*at_a, *at_b, X);
                   }});
#endif
  return peers;
}

}  // namespace haptic
