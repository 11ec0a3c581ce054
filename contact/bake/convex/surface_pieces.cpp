// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/surface_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "contact/bake/convex/cut_polygon.h"
#include "contact/bake/convex/growing_hull.h"
#include "contact/bake/convex/triangle_boxes.h"

namespace haptic {
namespace {

constexpr uint32_t kNoPieceYet = ~0u;
// a flat piece is given a thickness while it grows, so that its hull contains what stands in a
// notch of it: a thousandth of the mesh, or less than half of what is solid below
constexpr double kThickness = 1e-3, kShareOfSolid = 0.4;
// enough for a machine part that is convex; a finer ball is several pieces, each of which costs the
// square of its triangles
constexpr size_t kMostTrianglesOfPiece = 4096;
constexpr double kFlat = 1e-9;  // 1 − cosine of the angle between triangles that count as coplanar
constexpr double kStraight = 1e-6;  // beyond π: the angle of a corner that is a notch [rad]

/// Whether no part of the triangle has plane.above(p) < −margin.
bool is_above(const Corners& triangle, const Plane& plane, double margin) {
  return plane.above(triangle[0]) >= -margin && plane.above(triangle[1]) >= -margin &&
         plane.above(triangle[2]) >= -margin;
}

/// Where the ray from `from` along `along` (not unit: the ray's length) first meets the triangle,
/// as a share of its length; 1: nowhere (Möller & Trumbore 1997).
double share_to(const Corners& triangle, const Vec3& from, const Vec3& along) {
  const Vec3 u = triangle[1] - triangle[0], v = triangle[2] - triangle[0], w = from - triangle[0];
  const Vec3 q = cross(along, v);
  const double det = dot(u, q);
  if (det == 0) return 1;
  const double s = dot(w, q) / det, t = dot(along, cross(w, u)) / det;
  if (s < 0 || t < 0 || s + t > 1) return 1;
  const double share = dot(v, cross(w, u)) / det;
  return share > 0 && share < 1 ? share : 1;
}

/// A corner of the growing piece on a border of the mesh.
struct BorderCorner {
  double angle = 0;     // of the piece's triangles there [rad]
  bool is_flat = true;  // they are coplanar
};

class Decomposition {
 public:
  explicit Decomposition(const TriangleMesh& mesh)
      : mesh_(mesh),
        boxes_(build_triangle_boxes(mesh)),
        piece_at_vertex_(mesh.vertices.size()),
        is_on_border_(mesh.vertices.size()),
        border_corners_(mesh.vertices.size()) {
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (size_t i = 0; i < 3; ++i) {
        if (neighbour_across(mesh, t, i) != kNoFace) continue;
        is_on_border_[mesh.triangles[t][i]] = is_on_border_[mesh.triangles[t][(i + 1) % 3]] = true;
      }
    }
    size_ = longest_of(mesh.upper - mesh.lower);
    margin_ = kPieceTolerance * size_;
    result_.piece_of.assign(mesh.triangles.size(), kNoPieceYet);
  }

  SurfacePieces run() {
    for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (result_.piece_of[t] == kNoPieceYet) grow(t);
    }
    return std::move(result_);
  }

 private:
  uint32_t number() const { return static_cast<uint32_t>(result_.triangles.size()) - 1; }
  bool is_mine(uint32_t t) const { return t != kNoFace && result_.piece_of[t] == number(); }
  /// Numbers from 1: which piece a vertex was last a corner of.
  bool is_corner(uint32_t vertex) const { return piece_at_vertex_[vertex] == number() + 1; }

  void grow(uint32_t seed) {
    result_.triangles.emplace_back();
    planes_.clear();
    points_.clear();
    hull_.begin(corners_of(mesh_, seed), apex_below(seed));
    join(seed);
    std::deque<uint32_t> waiting;
    const auto offer = [&](uint32_t t) {
      for (size_t side = 0; side < 3; ++side) {
        const uint32_t other = neighbour_across(mesh_, t, side);
        if (other == kNoFace || result_.piece_of[other] != kNoPieceYet) continue;
        const bool is_flat = dot(mesh_.face_normals[t], mesh_.face_normals[other]) > 1 - kFlat;
        is_flat ? waiting.push_front(other) : waiting.push_back(other);
      }
    };
    offer(seed);
    while (!waiting.empty() && result_.triangles.back().size() < kMostTrianglesOfPiece) {
      const uint32_t t = waiting.front();
      waiting.pop_front();
      if (result_.piece_of[t] != kNoPieceYet || !may_join(t)) continue;
      join(t);
      offer(t);
    }
  }

  void join(uint32_t t) {
    result_.triangles.back().push_back(t);
    result_.piece_of[t] = number();
    planes_.push_back(plane_of(t));
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t vertex = mesh_.triangles[t][i];
      if (is_on_border_[vertex]) border_corners_[vertex] = border_corner(t, i);
      if (is_corner(vertex)) continue;
      piece_at_vertex_[vertex] = number() + 1;
      points_.push_back(mesh_.vertices[vertex]);
    }
  }

  /// What corner i of the triangle makes of that of the piece.
  BorderCorner border_corner(uint32_t t, size_t i) const {
    const Triangle& corner = mesh_.triangles[t];
    const Vec3& at = mesh_.vertices[corner[i]];
    const Vec3 u = mesh_.vertices[corner[(i + 1) % 3]] - at;
    const Vec3 v = mesh_.vertices[corner[(i + 2) % 3]] - at;
    const double angle = std::atan2(norm(cross(u, v)), dot(u, v));
    if (!is_corner(corner[i])) return {angle, true};
    const BorderCorner& before = border_corners_[corner[i]];
    const Vec3& flat_normal = mesh_.face_normals[result_.triangles.back()[0]];
    return {before.angle + angle,
            before.is_flat && dot(flat_normal, mesh_.face_normals[t]) > 1 - kFlat};
  }

  /// Whether the hull would lie over a notch that an open mesh has in a flat part, where there is
  /// nothing that could enter it.
  bool has_notch(uint32_t t) const {
    for (size_t i = 0; i < 3; ++i) {
      if (!is_on_border_[mesh_.triangles[t][i]]) continue;
      const BorderCorner corner = border_corner(t, i);
      if (corner.is_flat && corner.angle > std::numbers::pi + kStraight) return true;
    }
    return false;
  }

  Plane plane_of(uint32_t t) const {
    const Vec3& normal = mesh_.face_normals[t];
    return {normal, dot(normal, mesh_.vertices[mesh_.triangles[t][0]])};
  }

  Vec3 apex_below(uint32_t t) const {
    const auto [a, b, c] = corners_of(mesh_, t);
    const Vec3 middle = (a + b + c) / 3;
    const Vec3 along = -kThickness / kShareOfSolid * size_ * mesh_.face_normals[t];
    Box box{middle, middle};
    box.add(middle + along);
    double share = 1;
    any_near(boxes_, box, [&](uint32_t other) {
      if (other != t) share = std::min(share, share_to(corners_of(mesh_, other), middle, along));
      return false;
    });
    return middle + kShareOfSolid * share * along;
  }

  bool may_join(uint32_t t) {
    size_t n_shared = 0;
    for (size_t side = 0; side < 3; ++side)
      n_shared += is_mine(neighbour_across(mesh_, t, side)) ? 1 : 0;
    size_t n_known = 0;
    uint32_t fresh = 0;
    for (const uint32_t vertex : mesh_.triangles[t]) {
      is_corner(vertex) ? ++n_known : fresh = vertex;
    }
    // a corner that the piece has, without a side that leads to it, would make a ring of the disc
    if (n_shared == 0 || (n_known == 3 && n_shared == 1) || has_notch(t)) return false;
    const Plane plane = plane_of(t);
    const auto above = [&](const Vec3& p) { return plane.above(p) > margin_; };
    if (std::any_of(points_.begin(), points_.end(), above)) return false;
    if (n_known == 3) return true;
    const Vec3& p = mesh_.vertices[fresh];
    const auto sees = [&](const Plane& of) { return of.above(p) > margin_; };
    if (std::any_of(planes_.begin(), planes_.end(), sees)) return false;
    for (const GrowingHull::Gain& gain : hull_.gains(p)) {
      if (is_entered(gain, p, t)) return false;
    }
    hull_.add();
    return true;
  }

  /// Whether what the hull gains contains a part of the surface that lies deeper than the margin in
  /// the whole new hull. The faces that it was gained over, which become inner ones, count.
  bool is_entered(const GrowingHull::Gain& gain, const Vec3& point, uint32_t candidate) {
    const auto& [a, b, c] = gain.face;
    Box box{point, point};
    for (const Vec3& p : gain.face) box.add(p);
    const std::array<Plane, 4> sides{plane_through(a, c, b), plane_through(a, b, point),
                                     plane_through(b, c, point), plane_through(c, a, point)};
    const std::vector<Plane>& around = hull_.planes_around();
    return any_near(boxes_, box, [&](uint32_t t) {
      if (t == candidate || is_mine(t)) return false;
      const Corners corner = corners_of(mesh_, t);
      for (const Plane& side : sides) {
        if (is_above(corner, side, -margin_)) return false;
      }
      for (const Plane& plane : around) {
        if (is_above(corner, plane, margin_)) return false;
      }
      part_.p.assign(corner.begin(), corner.end());
      for (const Plane& side : sides) {
        if (!part_.cut(side, -margin_)) return false;
      }
      for (const Plane& plane : around) {
        if (!part_.cut(plane, margin_)) return false;
      }
      return hull_.all_unseen([&](const Plane& plane) { return part_.cut(plane, margin_); });
    });
  }

  const TriangleMesh mesh_;
  const TriangleBoxes boxes_;
  double size_ = 0, margin_ = 0;
  std::vector<uint32_t> piece_at_vertex_;
  std::vector<bool> is_on_border_;            // of each vertex
  std::vector<BorderCorner> border_corners_;  // of each vertex; its triangles of this piece
  SurfacePieces result_;
  // of the piece that grows
  std::vector<Plane> planes_;
  std::vector<Vec3> points_;
  GrowingHull hull_;
  CutPolygon part_;
};

}  // namespace

SurfacePieces decompose_surface(const TriangleMesh& mesh) {
  return Decomposition(mesh).run();
}

}  // namespace haptic
