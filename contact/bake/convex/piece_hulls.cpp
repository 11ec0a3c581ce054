// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_hulls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/bake/convex/hull_of_points.h"
#include "contact/shape/mesh/box.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr size_t kFewFaces = 128;        // of a hull: so few are all asked, without a search
constexpr int kBallSteps = 30;           // the radius is then within a tenth of the least
constexpr double kRoundedUp = 1 + 1e-9;  // of a radius, so that it holds for what rounding adds

/// By how much the corners of a triangle lie off the plane of a face: least and most [m].
struct HullReach {
  double least, most;
};

HullReach reach_above(const HullFace& face, const std::array<Vec3, 3>& triangle) {
  HullReach reach{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  for (const Vec3& p : triangle) {
    const double above = dot(face.normal, p) - face.offset;
    reach = {std::min(reach.least, above), std::max(reach.most, above)};
  }
  return reach;
}

}  // namespace

HullData hull_with_width(std::span<const Vec3> points, double width) {
  try {
    return hull_of_points(points).hull;
  } catch (const InputError&) {
    std::vector<Vec3> wider(points.begin(), points.end());
    Vec3 along;
    for (const Vec3& p : points) {
      if (norm(p - points[0]) > norm(along)) along = p - points[0];
    }
    const Vec3 across = width * any_perpendicular(norm(along) > 0 ? normalized(along) : Vec3{1});
    const Vec3 up = norm(along) > 0 ? Vec3{} : Vec3{width};
    for (const Vec3& p : points) {
      wider.push_back(p + across);
      wider.push_back(p + across + up);
    }
    return hull_of_points(wider).hull;
  }
}

void label_faces(HullData& data, std::span<const std::array<Vec3, 3>> triangles,
                 std::span<const uint32_t> numbers, double tolerance) {
  const Hull hull = data.view();
  for (HullFace& face : data.faces) face.is_virtual = 1, face.triangle = kNoTriangle;
  uint32_t start = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    const Vec3 normal = normalized(cross(b - a, c - a));
    start = support_vertex(hull, normal, start);
    uint32_t best = 0;
    double closest = std::numeric_limits<double>::max();
    for_edges_around(hull, start, [&](uint32_t edge) {
      const uint32_t f = hull.edges[edge].face;
      const HullReach reach = reach_above(hull.faces[f], triangles[i]);
      const double off = std::max(reach.most, -reach.least);
      // of the two sides of a flat piece, that which looks where the triangle does
      if (off < closest && dot(hull.faces[f].normal, normal) > 0) best = f, closest = off;
    });
    if (closest > tolerance) continue;
    data.faces[best].is_virtual = 0;
    data.faces[best].triangle = std::min(data.faces[best].triangle, numbers[i]);
  }
}

double distance_to_hull(const Hull& hull, const Vec3& p) {
  double nearest = std::numeric_limits<double>::max();
  bool is_inside = true;
  for (const HullFace& face : hull.faces) {
    const double above = dot(face.normal, p) - face.offset;
    if (above <= 0) continue;
    is_inside = false;
    bool is_over_face = true;
    for (uint32_t e = face.first_edge; e < face.first_edge + face.n_edges; ++e) {
      const Vec3& from = hull.vertices[hull.edges[e].from];
      const Vec3 along = hull.vertices[end_vertex(hull, e)] - from;
      if (dot(cross(face.normal, along), p - from) >= 0) continue;
      is_over_face = false;
      const double share = std::clamp(dot(along, p - from) / norm_squared(along), 0.0, 1.0);
      nearest = std::min(nearest, norm(from + share * along - p));
    }
    if (is_over_face) nearest = std::min(nearest, above);
  }
  return is_inside ? 0 : nearest;
}

double off_hull(const Hull& hull, const std::array<Vec3, 3>& triangle, const Vec3& normal,
                uint32_t& start) {
  // the depth of a point is the least of its depths below all faces. Of a triangle it is at most
  // that of its deepest corner below any one face; a face that looks as the triangle is a good one,
  // and where there are few all are asked
  double depth = std::numeric_limits<double>::max();
  bool is_inside = true;
  const auto ask = [&](const HullFace& face) {
    const HullReach reach = reach_above(face, triangle);
    depth = std::min(depth, -reach.least);
    is_inside = is_inside && reach.most <= 0;
  };
  start = support_vertex(hull, normal, start);
  if (hull.faces.size() <= kFewFaces) {
    for (const HullFace& face : hull.faces) ask(face);
    if (is_inside) return depth;
  } else {
    for_edges_around(hull, start, [&](uint32_t edge) { ask(hull.faces[hull.edges[edge].face]); });
  }
  // the distance to a convex body is a convex function: largest at a corner
  double outside = 0;
  for (const Vec3& p : triangle) outside = std::max(outside, distance_to_hull(hull, p));
  return std::max(depth, outside);
}

void bound_by_ball(Piece& piece, std::span<const Vec3> points) {
  const Box box = box_around(points);
  const auto farthest = [&](const Vec3& from) {
    Vec3 far = points[0];
    for (const Vec3& p : points) {
      if (norm_squared(p - from) > norm_squared(far - from)) far = p;
    }
    return far;
  };
  Vec3 centre = 0.5 * (box.lower + box.upper);
  piece.radius = std::numeric_limits<double>::max();
  for (int step = 1; step <= kBallSteps; ++step) {
    const Vec3 far = farthest(centre);
    const double radius = norm(far - centre) * kRoundedUp;
    if (radius < piece.radius) piece.radius = radius, piece.centre = centre;
    centre += 1.0 / (step + 1) * (far - centre);
  }
}

PieceTreeData pack_pieces(const std::vector<BuiltPiece>& built, uint32_t root, size_t n_triangles,
                          std::vector<uint32_t> level_pieces) {
  PieceTreeData tree;
  tree.level_pieces = std::move(level_pieces);
  tree.leaf_of.assign(n_triangles, kNoPiece);
  std::vector<uint32_t> order{root}, parent_of{kNoPiece};
  for (uint32_t i = 0; i < order.size(); ++i) {
    const BuiltPiece& from = built[order[i]];
    Piece piece = from.facts;
    const auto place = [](const auto& array) { return static_cast<uint32_t>(array.size()); };
    piece.first_vertex = place(tree.vertices), piece.n_vertices = place(from.hull.vertices);
    piece.first_edge = place(tree.edges), piece.n_edges = place(from.hull.edges);
    piece.first_face = place(tree.faces), piece.n_faces = place(from.hull.faces);
    piece.parent = parent_of[i];
    piece.first_child = place(order), piece.n_children = place(from.children);
    const auto append = [](auto& to, const auto& more) {
      to.insert(to.end(), more.begin(), more.end());
    };
    append(tree.vertices, from.hull.vertices);
    append(tree.edges, from.hull.edges);
    append(tree.faces, from.hull.faces);
    append(tree.edge_from, from.hull.edge_from);
    append(order, from.children);
    parent_of.resize(order.size(), i);
    if (from.children.empty()) {
      piece.first_child = 0;
      for (const uint32_t t : from.triangles) tree.leaf_of[t] = i;
    }
    tree.pieces.push_back(piece);
  }
  return tree;
}

}  // namespace haptic
