// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "contact/bake/convex/piece_groups.h"
#include "contact/bake/convex/piece_hulls.h"
#include "contact/bake/convex/surface_pieces.h"

namespace haptic {
namespace {

// relative to its extent: how far a hull may leave out points that lie on an edge to rounding
constexpr double kLeftOut = 1e-7;

double area_of(const TriangleMesh& mesh, uint32_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3& p = mesh.vertices[a];
  return 0.5 * norm(cross(mesh.vertices[b] - p, mesh.vertices[c] - p));
}

double mean_edge(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles) {
  double sum = 0;
  for (const uint32_t t : triangles) {
    const Triangle& corner = mesh.triangles[t];
    for (size_t i = 0; i < 3; ++i) {
      sum += norm(mesh.vertices[corner[i]] - mesh.vertices[corner[(i + 1) % 3]]);
    }
  }
  return sum / static_cast<double>(3 * triangles.size());
}

BuiltPiece make_leaf(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles,
                     double tolerance) {
  BuiltPiece leaf;
  leaf.triangles = triangles;
  std::vector<uint32_t> corners;
  for (const uint32_t t : triangles) {
    corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    leaf.facts.area += area_of(mesh, t);
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::vector<Vec3> points;
  for (const uint32_t v : corners) points.push_back(mesh.vertices[v]);
  leaf.hull = hull_with_width(points, tolerance);
  label_faces(leaf.hull, mesh, triangles, tolerance);
  bound_by_ball(leaf.facts, points);
  for (const Vec3& p : points) {
    leaf.facts.deviation = std::max(leaf.facts.deviation, distance_to_hull(leaf.hull.view(), p));
  }
  leaf.facts.deviation =
      std::max(leaf.facts.deviation, depth_in_hull(leaf.hull.view(), mesh, triangles));
  leaf.facts.resolution = 1 / mean_edge(mesh, triangles);
  return leaf;
}

BuiltPiece make_parent(const TriangleMesh& mesh, const std::vector<BuiltPiece>& built,
                       std::vector<uint32_t> children, double tolerance) {
  BuiltPiece parent;
  std::vector<Vec3> points;
  for (const uint32_t child : children) {
    const BuiltPiece& below = built[child];
    points.insert(points.end(), below.hull.vertices.begin(), below.hull.vertices.end());
    parent.triangles.insert(parent.triangles.end(), below.triangles.begin(), below.triangles.end());
    parent.facts.area += below.facts.area;
  }
  parent.children = std::move(children);
  parent.hull = hull_with_width(points, tolerance);
  label_faces(parent.hull, mesh, parent.triangles, tolerance);
  bound_by_ball(parent.facts, points);
  for (const uint32_t child : parent.children) {
    parent.facts.hull_distance =
        std::max(parent.facts.hull_distance, built[child].facts.hull_distance);
  }
  parent.facts.hull_distance += kLeftOut * 2 * parent.facts.radius;
  parent.facts.deviation = depth_in_hull(parent.hull.view(), mesh, parent.triangles);
  parent.facts.resolution = 1 / std::sqrt(parent.facts.area);
  return parent;
}

Box box_around(const std::vector<Vec3>& points) {
  Box box{points[0], points[0]};
  for (const Vec3& p : points) box.add(p);
  return box;
}

/// Pairs of pieces that share an edge of the mesh.
PiecePairs neighbours_of(const TriangleMesh& mesh, const std::vector<uint32_t>& piece_of) {
  PiecePairs pairs;
  for (const auto& [left, right] : mesh.edge_faces) {
    if (right == kNoFace || piece_of[left] == piece_of[right]) continue;
    pairs.push_back(std::minmax(piece_of[left], piece_of[right]));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

PieceTreeData build_piece_tree(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return {};
  const Vec3 side = mesh.upper - mesh.lower;
  const double tolerance = 2 * kPieceTolerance * std::max({side.x, side.y, side.z});
  SurfacePieces pieces = decompose_surface(mesh);
  std::vector<BuiltPiece> built;
  for (const auto& triangles : pieces.triangles) {
    built.push_back(make_leaf(mesh, triangles, tolerance));
  }
  std::vector<uint32_t> alive(built.size());
  std::iota(alive.begin(), alive.end(), 0);
  std::vector<uint32_t> level_pieces{static_cast<uint32_t>(alive.size())};
  std::vector<uint32_t> piece_of = pieces.piece_of;  // of each triangle: place in `alive`
  while (alive.size() > 1) {
    std::vector<Box> boxes;
    for (const uint32_t i : alive) boxes.push_back(box_around(built[i].hull.vertices));
    const auto groups = group_pieces(boxes, neighbours_of(mesh, piece_of), (alive.size() + 1) / 2);
    std::vector<uint32_t> next;
    for (const std::vector<uint32_t>& group : groups) {
      uint32_t node = alive[group[0]];
      if (group.size() > 1) {
        std::vector<uint32_t> children;
        for (const uint32_t member : group) children.push_back(alive[member]);
        built.push_back(make_parent(mesh, built, std::move(children), tolerance));
        node = static_cast<uint32_t>(built.size()) - 1;
        built[node].facts.level = static_cast<uint32_t>(level_pieces.size());
      }
      for (const uint32_t t : built[node].triangles) {
        piece_of[t] = static_cast<uint32_t>(next.size());
      }
      next.push_back(node);
    }
    alive = std::move(next);
    level_pieces.push_back(static_cast<uint32_t>(alive.size()));
  }
  return pack_pieces(built, alive[0], mesh.triangles.size(), std::move(level_pieces));
}

}  // namespace haptic
