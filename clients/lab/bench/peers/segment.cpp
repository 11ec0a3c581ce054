// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/segment.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <limits>

#include "clients/lab/bench/peers/embree_scene.h"

#ifdef HAPTICD_BULLET
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletCollisionCommon.h>
#endif

namespace haptic {
namespace {

#ifdef HAPTICD_EMBREE
class EmbreePeer : public SegmentPeer {
 public:
  explicit EmbreePeer(const TriangleMesh& mesh) : scene_(mesh) {}

  double first_hit(const Vec3& from_O, const Vec3& to_O) override {
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

class CgalPeer : public SegmentPeer {
 public:
  explicit CgalPeer(const TriangleMesh& mesh) {
    const auto point = [&](uint32_t i) {
      const Vec3& v = mesh.vertices[i];
      return Kernel::Point_3(v.x, v.y, v.z);
    };
    triangles_.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles_.emplace_back(point(a), point(b), point(c));
    }
    tree_.insert(triangles_.begin(), triangles_.end());
    tree_.build();
  }

  double first_hit(const Vec3& from_O, const Vec3& to_O) override {
    const Kernel::Point_3 from(from_O.x, from_O.y, from_O.z);
    const Kernel::Segment_3 segment(from, {to_O.x, to_O.y, to_O.z});
    found_.clear();
    tree_.all_intersections(segment, std::back_inserter(found_));
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
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Tree = CGAL::AABB_tree<
      CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::iterator>>>;
  using Found = Tree::Intersection_and_primitive_id<Kernel::Segment_3>::Type;

  Triangles triangles_;
  Tree tree_;
  std::vector<Found> found_;
};

#ifdef HAPTICD_BULLET
class BulletPeer : public SegmentPeer {
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

  double first_hit(const Vec3& from_O, const Vec3& to_O) override {
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

}  // namespace

std::vector<NamedPeer> make_segment_peers(const TriangleMesh& mesh) {
  std::vector<NamedPeer> peers(3);
  peers[0].name = "Embree 3 robust";
  peers[1].name = "CGAL AABB tree";
  peers[2].name = "Bullet";
#ifdef HAPTICD_EMBREE
  peers[0].peer = std::make_unique<EmbreePeer>(mesh);
#endif
  peers[1].peer = std::make_unique<CgalPeer>(mesh);
#ifdef HAPTICD_BULLET
  peers[2].peer = std::make_unique<BulletPeer>(mesh);
#endif
  return peers;
}

}  // namespace haptic
