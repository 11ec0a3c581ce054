// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/segment.h"

#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "clients/lab/bench/peers/embree_scene.h"
#include "clients/lab/support/triangles_cgal.h"

#ifdef HAPTICD_BULLET
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletCollisionCommon.h>
#endif

namespace haptic {
namespace {

#ifdef HAPTICD_EMBREE
class EmbreePeer {
 public:
  explicit EmbreePeer(const TriangleMesh& mesh) : scene_(mesh) {}

  double operator()(const Vec3& from_O, const Vec3& to_O) {
    const Vec3 d_O = to_O - from_O;
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(from_O.x);
    query.ray.org_y = static_cast<float>(from_O.y);
    query.ray.org_z = static_cast<float>(from_O.z);
    query.ray.dir_x = static_cast<float>(d_O.x);
    query.ray.dir_y = static_cast<float>(d_O.y);
    query.ray.dir_z = static_cast<float>(d_O.z);
    query.ray.tfar = 1;
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_.get(), &context, &query);
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : static_cast<double>(query.ray.tfar);
  }

 private:
  EmbreeScene scene_;
};
#endif

class CgalPeer {
 public:
  explicit CgalPeer(const TriangleMesh& mesh) : mesh_(mesh.vertices, mesh.triangles) {}

  double operator()(const Vec3& from_O, const Vec3& to_O) {
    const Kernel::Point_3 from(from_O.x, from_O.y, from_O.z);
    const Kernel::Segment_3 segment(from, {to_O.x, to_O.y, to_O.z});
    found_.clear();
    mesh_.tree.all_intersections(segment, std::back_inserter(found_));
    double best = std::numeric_limits<double>::infinity();
    for (const Found& found : found_) {
      if (const auto* p = boost::get<Kernel::Point_3>(&found.first)) {
        best = std::min(best, CGAL::squared_distance(from, *p));
      } else if (const auto* s = boost::get<Kernel::Segment_3>(&found.first)) {
        best = std::min({best, CGAL::squared_distance(from, s->source()),
                         CGAL::squared_distance(from, s->target())});
      }
    }
    return std::isinf(best) ? -1 : std::sqrt(best / segment.squared_length());
  }

 private:
  using Kernel = CGAL::Simple_cartesian<double>;
  using Found = CgalTriangles<Kernel>::Tree::Intersection_and_primitive_id<Kernel::Segment_3>::Type;

  CgalTriangles<Kernel> mesh_;
  std::vector<Found> found_;
};

#ifdef HAPTICD_BULLET
class BulletPeer {
 public:
  explicit BulletPeer(const TriangleMesh& mesh) {
    for (const Vec3& v : mesh.vertices) {
      for (const double x : {v.x, v.y, v.z}) points_.push_back(static_cast<btScalar>(x));
    }
    for (const Triangle& t : mesh.triangles) {
      for (const uint32_t i : t) corners_.push_back(static_cast<int>(i));
    }
    mesh_ = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(mesh.triangles.size()), corners_.data(), 3 * int{sizeof(int)},
        static_cast<int>(mesh.vertices.size()), points_.data(), 3 * int{sizeof(btScalar)});
    shape_ = std::make_unique<btBvhTriangleMeshShape>(mesh_.get(), true, true);
  }

  double operator()(const Vec3& from_O, const Vec3& to_O) {
    const btVector3 from = vector(from_O), to = vector(to_O);
    Nearest nearest(from, to, 0);
    shape_->performRaycast(&nearest, from, to);
    return nearest.m_hitFraction < 1 ? static_cast<double>(nearest.m_hitFraction) : -1;
  }

 private:
  struct Nearest : btTriangleRaycastCallback {
    using btTriangleRaycastCallback::btTriangleRaycastCallback;
    btScalar reportHit(const btVector3&, btScalar fraction, int, int) override { return fraction; }
  };
  static btVector3 vector(const Vec3& v) {
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
  }

  std::vector<btScalar> points_;
  std::vector<int> corners_;
  std::unique_ptr<btTriangleIndexVertexArray> mesh_;
  std::unique_ptr<btBvhTriangleMeshShape> shape_;
};
#endif

/// A peer that a function may copy.
template <class Peer>
auto searching(const TriangleMesh& mesh) {
  const auto peer = std::make_shared<Peer>(mesh);
  return [peer](const Vec3& from_O, const Vec3& to_O) { return (*peer)(from_O, to_O); };
}

}  // namespace

std::vector<SegmentPeer> make_segment_peers(const TriangleMesh& mesh) {
  std::vector<SegmentPeer> peers{
      {"Embree 3 robust"}, {"CGAL AABB tree", searching<CgalPeer>(mesh)}, {"Bullet"}};
#ifdef HAPTICD_EMBREE
  peers[0].first_hit = searching<EmbreePeer>(mesh);
#endif
#ifdef HAPTICD_BULLET
  peers[2].first_hit = searching<BulletPeer>(mesh);
#endif
  return peers;
}

}  // namespace haptic
