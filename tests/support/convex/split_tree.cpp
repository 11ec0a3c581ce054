// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/convex/split_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "contact/bake/convex/hull_of_points.h"

namespace haptic::test {
namespace {

class Splitter {
 public:
  Splitter(const Soup& soup, size_t most_in_leaf) : soup_(soup), most_in_leaf_(most_in_leaf) {}

  SplitTree split() {
    std::vector<uint32_t> all(soup_.triangles.size());
    std::iota(all.begin(), all.end(), 0);
    tree_.leaf_of.resize(all.size());
    tree_.pieces.push_back({});
    std::vector<Job> jobs{{0, kNoPiece, all}};
    // breadth first: children after their parents, and beside each other
    for (size_t i = 0; i < jobs.size(); ++i) {
      const Job job = jobs[i];
      make(job);
      if (job.triangles.size() <= most_in_leaf_) continue;
      tree_.pieces[job.piece].first_child = static_cast<uint32_t>(tree_.pieces.size());
      tree_.pieces[job.piece].n_children = 2;
      for (auto& half : halves(job.triangles)) {
        jobs.push_back({static_cast<uint32_t>(tree_.pieces.size()), job.piece, half});
        tree_.pieces.push_back({});
      }
    }
    set_levels();
    return std::move(tree_);
  }

 private:
  struct Job {
    uint32_t piece, parent;
    std::vector<uint32_t> triangles;
  };

  Vec3 corner(uint32_t triangle, size_t k) const {
    return soup_.vertices[soup_.triangles[triangle][k]];
  }
  Vec3 normal(uint32_t t) const {
    return cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
  }

  std::vector<std::vector<uint32_t>> halves(std::vector<uint32_t> triangles) const {
    Vec3 lower{1e9, 1e9, 1e9}, upper = -lower;
    const auto centre = [&](uint32_t t) {
      return (1.0 / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2));
    };
    for (const uint32_t t : triangles) {
      lower = component_min(lower, centre(t)), upper = component_max(upper, centre(t));
    }
    const Vec3 size = upper - lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    std::sort(triangles.begin(), triangles.end(), [&](uint32_t a, uint32_t b) {
      return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
    });
    const auto middle = triangles.begin() + static_cast<ptrdiff_t>(triangles.size() / 2);
    return {{triangles.begin(), middle}, {middle, triangles.end()}};
  }

  void make(const Job& job) {
    std::vector<Vec3> points;
    for (const uint32_t t : job.triangles) {
      for (size_t k = 0; k < 3; ++k) points.push_back(corner(t, k));
    }
    HullData hull = hull_of_points(points).hull;
    Piece& piece = tree_.pieces[job.piece];
    piece.parent = job.parent;
    piece.first_vertex = static_cast<uint32_t>(tree_.vertices.size());
    piece.first_edge = static_cast<uint32_t>(tree_.edges.size());
    piece.first_face = static_cast<uint32_t>(tree_.faces.size());
    piece.n_vertices = static_cast<uint32_t>(hull.vertices.size());
    piece.n_edges = static_cast<uint32_t>(hull.edges.size());
    piece.n_faces = static_cast<uint32_t>(hull.faces.size());
    for (HullFace& face : hull.faces) mark(job.triangles, face);
    Vec3 sum;
    for (const Vec3& v : hull.vertices) sum += v;
    piece.centre = sum / static_cast<double>(hull.vertices.size());
    for (const Vec3& v : hull.vertices)
      piece.radius = std::max(piece.radius, norm(v - piece.centre));
    double longest = 0;
    for (const uint32_t t : job.triangles) {
      piece.area += 0.5 * norm(normal(t));
      tree_.leaf_of[t] = job.piece;
    }
    for (const HullEdge& edge : hull.edges) {
      longest = std::max(
          longest, norm(hull.vertices[hull.edges[edge.twin].from] - hull.vertices[edge.from]));
    }
    piece.resolution = 1 / longest;
    for (const Vec3& p : points) {
      double below = std::numeric_limits<double>::infinity();
      for (const HullFace& face : hull.faces) {
        below = std::min(below, face.offset - dot(face.normal, p));
      }
      piece.deviation = piece.overhang = std::max(piece.deviation, below);
    }
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(tree_.vertices, hull.vertices);
    append(tree_.edges, hull.edges);
    append(tree_.faces, hull.faces);
    append(tree_.edge_from, hull.edge_from);
  }

  /// A face is real if a triangle lies in it, and faces its way.
  void mark(const std::vector<uint32_t>& triangles, HullFace& face) const {
    constexpr double kFlat = 1e-9;  // [m]
    face.is_virtual = 1;
    face.triangle = kNoTriangle;
    for (const uint32_t t : triangles) {
      bool lies_in = dot(normal(t), face.normal) > 0;
      for (size_t k = 0; k < 3; ++k) {
        lies_in &= std::fabs(dot(face.normal, corner(t, k)) - face.offset) < kFlat;
      }
      if (!lies_in) continue;
      face.is_virtual = 0;
      face.triangle = std::min(face.triangle, t);
    }
  }

  /// The level of a node is its height above the leaves.
  void set_levels() {
    uint32_t most = 0;
    for (size_t i = tree_.pieces.size(); i-- > 0;) {
      const Piece& piece = tree_.pieces[i];
      most = std::max(most, piece.level);
      if (piece.parent == kNoPiece) continue;
      Piece& parent = tree_.pieces[piece.parent];
      parent.level = std::max(parent.level, piece.level + 1);
    }
    tree_.level_pieces.assign(most + 1, 0);
    for (const Piece& piece : tree_.pieces) ++tree_.level_pieces[piece.level];
  }

  const Soup& soup_;
  size_t most_in_leaf_;
  SplitTree tree_;
};

}  // namespace

SplitTree split_tree(const Soup& soup, size_t most_in_leaf) {
  return Splitter(soup, most_in_leaf).split();
}

}  // namespace haptic::test
