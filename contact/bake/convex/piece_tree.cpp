// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "contact/bake/convex/piece_groups.h"
#include "contact/bake/convex/piece_hulls.h"
#include "contact/bake/convex/piece_surgery.h"
#include "contact/bake/convex/surface_pieces.h"
#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/mesh/distinct.h"

namespace haptic {
namespace {

// relative to its extent: how far a hull may leave out points that lie on an edge to rounding
constexpr double kLeftOut = 1e-7;
constexpr int kQuarterings = 3;    // of a triangle that lies under two pieces
constexpr double kMostKept = 0.6;  // of the pieces of a level by the next

double area_of(const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  return 0.5 * norm(cross(b - a, c - a));
}

double mean_edge(const std::vector<Corners>& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) sum += norm(b - a) + norm(c - b) + norm(a - c);
  return sum / static_cast<double>(3 * triangles.size());
}

/// Its hull, ball and resolution, of triangles with these numbers.
void shape_piece(BuiltPiece& piece, const std::vector<Corners>& triangles,
                 const std::vector<uint32_t>& numbers, double tolerance) {
  std::vector<Vec3> points;
  for (const auto& corners : triangles) points.insert(points.end(), corners.begin(), corners.end());
  piece.hull = hull_with_width(points, tolerance);
  label_faces(piece.hull, triangles, numbers, tolerance);
  points.insert(points.end(), piece.hull.vertices.begin(), piece.hull.vertices.end());
  bound_by_ball(piece.facts, points);
  piece.facts.resolution = 1 / mean_edge(triangles);
}

BuiltPiece make_leaf(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles,
                     double tolerance) {
  BuiltPiece leaf;
  leaf.triangles = triangles;
  std::vector<Corners> corners;
  for (const uint32_t t : triangles) {
    corners.push_back(corners_of(mesh, t));
    leaf.facts.area += area_of(corners.back());
  }
  shape_piece(leaf, corners, triangles, tolerance);
  uint32_t start = 0;
  for (const uint32_t t : triangles) {
    const double off = off_hull(leaf.hull.view(), corners_of(mesh, t), mesh.face_normals[t], start);
    leaf.facts.deviation = std::max(leaf.facts.deviation, off);
  }
  return leaf;
}

/// Takes over what the children stand for.
void adopt(BuiltPiece& parent, const std::vector<BuiltPiece>& built,
           std::vector<uint32_t> children) {
  for (const uint32_t child : children) {
    const BuiltPiece& below = built[child];
    parent.triangles.insert(parent.triangles.end(), below.triangles.begin(), below.triangles.end());
    parent.facts.area += below.facts.area;
  }
  parent.children = std::move(children);
}

/// The most that a leaf's hull below this node reaches out of the hull: the distance to a convex
/// body is a convex function, so that it is largest at a vertex.
double reach_of_leaves(const Hull& hull, const std::vector<BuiltPiece>& built,
                       const std::vector<uint32_t>& nodes) {
  double most = 0;
  std::vector<uint32_t> waiting = nodes;
  while (!waiting.empty()) {
    const BuiltPiece& node = built[waiting.back()];
    waiting.pop_back();
    waiting.insert(waiting.end(), node.children.begin(), node.children.end());
    if (!node.children.empty()) continue;
    for (const Vec3& p : node.hull.vertices) most = std::max(most, distance_to_hull(hull, p));
  }
  return most;
}

/// A piece of a coarser level of detail, but for its deviation.
BuiltPiece make_coarse(const std::vector<BuiltPiece>& built, const SimplePiece& simple,
                       std::vector<uint32_t> children, double tolerance) {
  BuiltPiece piece;
  adopt(piece, built, std::move(children));
  shape_piece(piece, simple.corners, simple.triangles, tolerance);
  // what rounding adds, so that the bound holds
  piece.facts.hull_distance =
      reach_of_leaves(piece.hull.view(), built, piece.children) + kLeftOut * 2 * piece.facts.radius;
  return piece;
}

/// The hull of several: a bounding volume, whose deviation is that of its surface.
BuiltPiece make_parent(const TriangleMesh& mesh, const std::vector<BuiltPiece>& built,
                       std::vector<uint32_t> children, double tolerance) {
  BuiltPiece parent;
  std::vector<Vec3> points;
  for (const uint32_t child : children) {
    const BuiltPiece& below = built[child];
    points.insert(points.end(), below.hull.vertices.begin(), below.hull.vertices.end());
    parent.facts.hull_distance = std::max(parent.facts.hull_distance, below.facts.hull_distance);
  }
  adopt(parent, built, std::move(children));
  parent.hull = hull_with_width(points, tolerance);
  std::vector<Corners> corners;
  for (const uint32_t t : parent.triangles) corners.push_back(corners_of(mesh, t));
  label_faces(parent.hull, corners, parent.triangles, tolerance);
  bound_by_ball(parent.facts, points);
  parent.facts.hull_distance += kLeftOut * 2 * parent.facts.radius;
  uint32_t start = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3& normal = mesh.face_normals[parent.triangles[i]];
    parent.facts.deviation =
        std::max(parent.facts.deviation, off_hull(parent.hull.view(), corners[i], normal, start));
  }
  parent.facts.overhang = parent.facts.deviation;
  parent.facts.resolution = 1 / std::sqrt(parent.facts.area);
  return parent;
}

/// Pairs of pieces that share an edge of the mesh.
PiecePairs piece_neighbours(const TriangleMesh& mesh, const std::vector<uint32_t>& piece_of) {
  PiecePairs pairs;
  for (const auto& [left, right] : mesh.edge_faces) {
    if (right == kNoFace || piece_of[left] == piece_of[right]) continue;
    pairs.push_back(std::minmax(piece_of[left], piece_of[right]));
  }
  keep_distinct(pairs);
  return pairs;
}

/// The nodes of a level, and what has been made so far.
struct Building {
  const TriangleMesh& mesh;
  double tolerance;
  std::vector<BuiltPiece> built;
  std::vector<uint32_t> alive;
  uint32_t level = 0;
};

std::vector<uint32_t> places_of_triangles(const Building& b) {
  std::vector<uint32_t> piece_of(b.mesh.triangles.size());
  for (uint32_t place = 0; place < b.alive.size(); ++place) {
    for (const uint32_t t : b.built[b.alive[place]].triangles) piece_of[t] = place;
  }
  return piece_of;
}

/// The surface of a level near a piece: its hull, then those of its neighbours, and where the
/// search for the vertex farthest along a normal begins in each.
struct Surroundings {
  std::vector<const BuiltPiece*> pieces;
  std::vector<uint32_t> starts;
};

/// An upper bound of how far a triangle lies off the nearest of these surfaces, as exact as it must
/// be to see whether it is more than `enough` [m]. One that lies under two pieces is quartered.
double off_surface(Surroundings& around, const Corners& corners, const Vec3& normal, double enough,
                   int quarterings) {
  double off = std::numeric_limits<double>::max();
  for (size_t k = 0; k < around.pieces.size() && off > enough; ++k) {
    const BuiltPiece& piece = *around.pieces[k];
    if (norm(corners[0] - piece.facts.centre) - piece.facts.radius > off) continue;
    off = std::min(off, off_hull(piece.hull.view(), corners, normal, around.starts[k]));
  }
  if (off <= enough || quarterings == 0) return off;
  const auto& [a, b, c] = corners;
  const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  double most = enough;
  for (const Corners& part : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) {
    most = std::max(most, off_surface(around, part, normal, most, quarterings - 1));
  }
  return most;
}

/// The place nearest to a point on the triangles that the pieces stand for.
ClosestPoint on_original(const TriangleMesh& mesh, const Surroundings& around, const Vec3& p) {
  OnTriangle nearest{};
  uint32_t triangle = 0;
  double least = std::numeric_limits<double>::max();
  for (const BuiltPiece* piece : around.pieces) {
    for (const uint32_t t : piece->triangles) {
      const OnTriangle on = closest_on_triangle(mesh, t, p);
      const double distance = norm_squared(on.point - p);
      if (distance < least) least = distance, nearest = on, triangle = t;
    }
  }
  return closest_point_on_triangle(mesh, triangle, nearest, p);
}

/// How far the real faces of a piece lie off the original surface, and how far outside of it, at
/// their corners, the middles of their edges and their centres. Where pieces merged over a gap a
/// face may span it.
void measure_faces(const TriangleMesh& mesh, const Surroundings& around, BuiltPiece& piece) {
  const auto ask = [&](const Vec3& p) {
    const ClosestPoint near = on_original(mesh, around, p);
    piece.facts.deviation = std::max(piece.facts.deviation, near.distance);
    // an open surface has no inside: either side of it is out
    if (!near.inside) piece.facts.overhang = std::max(piece.facts.overhang, near.distance);
  };
  for (const HullFace& face : piece.hull.faces) {
    if (face.is_virtual != 0) continue;
    Vec3 sum;
    for (uint32_t k = 0; k < face.n_edges; ++k) {
      const HullEdge& edge = piece.hull.edges[face.first_edge + k];
      const Vec3& from = piece.hull.vertices[edge.from];
      ask(from);
      ask(0.5 * (from + piece.hull.vertices[piece.hull.edges[edge.next].from]));
      sum += from;
    }
    ask(sum / static_cast<double>(face.n_edges));
  }
}

/// The deviations of the nodes of a level from `first` on. What a piece stands for may have come to
/// lie under a neighbour, so that the neighbours' surfaces count as well.
void measure_deviations(Building& b, size_t first) {
  std::vector<Surroundings> around(b.alive.size());
  for (size_t place = 0; place < b.alive.size(); ++place) {
    around[place].pieces.push_back(&b.built[b.alive[place]]);
  }
  for (const auto& [one, other] : piece_neighbours(b.mesh, places_of_triangles(b))) {
    around[one].pieces.push_back(&b.built[b.alive[other]]);
    around[other].pieces.push_back(&b.built[b.alive[one]]);
  }
  for (size_t place = 0; place < b.alive.size(); ++place) {
    if (b.alive[place] < first) continue;
    BuiltPiece& piece = b.built[b.alive[place]];
    around[place].starts.resize(around[place].pieces.size(), 0);
    for (const uint32_t t : piece.triangles) {
      piece.facts.deviation =
          std::max(piece.facts.deviation,
                   off_surface(around[place], corners_of(b.mesh, t), b.mesh.face_normals[t],
                               piece.facts.deviation, kQuarterings));
    }
    measure_faces(b.mesh, around[place], piece);
  }
}

/// The next level of detail: the nodes of pieces that are as they were stay.
void add_level(Building& b, const std::vector<SimplePiece>& pieces) {
  ++b.level;
  const size_t first = b.built.size();
  std::vector<uint32_t> next;
  for (const SimplePiece& piece : pieces) {
    std::vector<uint32_t> children;
    for (const uint32_t member : piece.members) children.push_back(b.alive[member]);
    if (children.size() == 1 && !piece.has_moved) {
      next.push_back(children[0]);
      continue;
    }
    b.built.push_back(make_coarse(b.built, piece, std::move(children), b.tolerance));
    b.built.back().facts.level = b.level;
    next.push_back(static_cast<uint32_t>(b.built.size()) - 1);
  }
  b.alive = std::move(next);
  measure_deviations(b, first);
}

/// Half as many nodes, hulls of two or more.
void add_hulls(Building& b) {
  ++b.level;
  std::vector<Box> boxes;
  for (const uint32_t node : b.alive) boxes.push_back(box_around(b.built[node].hull.vertices));
  std::vector<uint32_t> next;
  for (const std::vector<uint32_t>& group : group_pieces(
           boxes, piece_neighbours(b.mesh, places_of_triangles(b)), (b.alive.size() + 1) / 2)) {
    next.push_back(b.alive[group[0]]);
    if (group.size() == 1) continue;
    std::vector<uint32_t> children;
    for (const uint32_t member : group) children.push_back(b.alive[member]);
    b.built.push_back(make_parent(b.mesh, b.built, std::move(children), b.tolerance));
    b.built.back().facts.level = b.level;
    next.back() = static_cast<uint32_t>(b.built.size()) - 1;
  }
  b.alive = std::move(next);
}

}  // namespace

PieceTreeData build_piece_tree(const TriangleMesh& mesh, const PieceProgress& progress) {
  if (mesh.triangles.empty()) return {};
  const auto tell = [&](double share) {
    if (progress) progress(share);
  };
  const double tolerance = 2 * kPieceTolerance * longest_of(mesh.upper - mesh.lower);
  const SurfacePieces pieces = decompose_surface(mesh);
  Building b{mesh, tolerance, {}, {}};
  for (const auto& triangles : pieces.triangles) {
    b.built.push_back(make_leaf(mesh, triangles, tolerance));
  }
  b.alive.resize(b.built.size());
  std::iota(b.alive.begin(), b.alive.end(), 0);
  std::vector<uint32_t> level_pieces{static_cast<uint32_t>(b.alive.size())};
  PieceSurgery surgery(mesh, pieces);
  while (b.alive.size() > 1) {
    // half of the work is at the finest level, and half of it is left each time
    tell(1 - static_cast<double>(b.alive.size()) / static_cast<double>(pieces.triangles.size()));
    surgery.simplify((b.alive.size() + 1) / 2);
    if (static_cast<double>(surgery.n_pieces()) > kMostKept * static_cast<double>(b.alive.size())) {
      break;
    }
    add_level(b, surgery.take_level());
    level_pieces.push_back(static_cast<uint32_t>(b.alive.size()));
  }
  while (b.alive.size() > 1) add_hulls(b);
  return pack_pieces(b.built, b.alive[0], mesh.triangles.size(), std::move(level_pieces));
}

}  // namespace haptic
