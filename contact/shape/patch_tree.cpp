// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/patch_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace haptic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
constexpr double kPad = 1e-14;       // of the largest coordinate: ~45 roundings of a closest point
constexpr double kThinnest = 1e-9;   // of the largest coordinate: below, a normal is noise
constexpr double kConeSlack = 5e-3;  // widens cones against rounding of directions [rad]
constexpr double kAxisLength = 1 - 1e-6;  // stays at most 1 when rounded to float
constexpr size_t kExactTriangles = 64;    // larger patches are bounded through their children

float round_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -kFloatInfinity) : f;
}

float round_up(double x) {
  return -round_down(-x);
}

/// Directions within an angle of an axis; cos ≤ 0 stands for all directions.
struct Cone {
  Vec3 axis;
  double cos = -1;
};

/// cos of the angle at `axis` that holds a cone: the sum of two angles below 90°.
double cos_holding(const Vec3& axis, const Cone& cone) {
  const double cos = std::min(dot(axis, cone.axis), 1.0);
  if (!(cos > 0) || !(cone.cos > 0)) return -1;
  const double sines = std::sqrt((1 - cos * cos) * std::max(1 - cone.cos * cone.cos, 0.0));
  return cos * cone.cos - sines;
}

/// cos of an angle widened by the slack.
double cos_widened(double cos) {
  if (!(cos > 0)) return -1;
  return cos * std::cos(kConeSlack) -
         std::sqrt(std::max(1 - cos * cos, 0.0)) * std::sin(kConeSlack);
}

/// Too thin for its normal to mean anything.
bool is_sliver(const std::array<Vec3, 3>& p, double thinnest) {
  const double longest = std::max({norm(p[1] - p[0]), norm(p[2] - p[1]), norm(p[0] - p[2])});
  return !(norm(cross(p[1] - p[0], p[2] - p[0])) > thinnest * longest);
}

/// What bounds a patch, before it is rounded.
struct Patch {
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
  double low = kInfinity, high = -kInfinity;
  Cone cone;
  Vec3 normal_sum;
};

class Builder {
 public:
  explicit Builder(const TriangleMesh& mesh) : mesh_(mesh), cones_(mesh.vertices.size()) {
    const Vec3 reach = component_max(mesh.upper, -mesh.lower);
    const double largest = std::max({std::fabs(reach.x), std::fabs(reach.y), std::fabs(reach.z),
                                     norm(mesh.upper - mesh.lower)});
    pad_ = kPad * largest;
    build_cones(kThinnest * largest);
  }

  PatchTreeData build() {
    const size_t n = mesh_.triangles.size();
    if (n == 0) return {};
    items_.resize(n);
    for (uint32_t i = 0; i < n; ++i) {
      const auto& [a, b, c] = mesh_.triangles[i];
      const Vec3 sum = mesh_.vertices[a] + mesh_.vertices[b] + mesh_.vertices[c];
      items_[i] = {
          {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z)}, i};
    }
    tree_.nodes.reserve(n / 10 + 1);
    tree_.leaves.reserve(n / 3 + 1);
    build_node(0, n, 0);
    return std::move(tree_);
  }

 private:
  struct Item {
    std::array<float, 3> centre;  // three times the centroid
    uint32_t triangle;
  };

  /// Of each vertex, the cone of the faces around it; all directions on a border.
  void build_cones(double thinnest) {
    for (size_t v = 0; v < cones_.size(); ++v) cones_[v] = {mesh_.vertex_normals[v], 1};
    for (size_t f = 0; f < mesh_.triangles.size(); ++f) {
      const Triangle& tri = mesh_.triangles[f];
      const bool sliver = is_sliver(
          {mesh_.vertices[tri[0]], mesh_.vertices[tri[1]], mesh_.vertices[tri[2]]}, thinnest);
      for (size_t i = 0; i < 3; ++i) {
        Cone& cone = cones_[tri[i]];
        cone.cos = sliver ? -1 : std::min(cone.cos, dot(cone.axis, mesh_.face_normals[f]));
        if (mesh_.edge_faces[mesh_.triangle_edges[f][i]][1] != kNoFace) continue;
        cone.cos = cones_[tri[(i + 1) % 3]].cos = -1;
      }
    }
  }

  /// Halves the items at a multiple of a leaf; returns the size of the first half.
  size_t halve(size_t begin, size_t end) {
    const size_t n = (((end - begin) / 2 + kPatchLanes - 1) / kPatchLanes) * kPatchLanes;
    std::array<float, 3> lower = items_[begin].centre, upper = lower;
    for (size_t i = begin; i < end; ++i) {
      for (size_t k = 0; k < 3; ++k) {
        lower[k] = std::min(lower[k], items_[i].centre[k]);
        upper[k] = std::max(upper[k], items_[i].centre[k]);
      }
    }
    const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    const size_t axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    const auto at = [&](size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(begin + n), at(end), [axis](const Item& a, const Item& b) {
      return a.centre[axis] < b.centre[axis];
    });
    return n;
  }

  /// Cuts the items into at most four parts; returns where they begin and end.
  size_t quarter(size_t begin, size_t end, std::array<size_t, kPatchLanes + 1>& cuts) {
    size_t parts = 0;
    cuts[0] = begin;
    const auto add_half = [&](size_t from, size_t to) {
      if (to - from > kPatchLanes) cuts[++parts] = from + halve(from, to);
      cuts[++parts] = to;
    };
    if (end - begin <= kPatchLanes) {
      cuts[++parts] = end;
      return parts;
    }
    const size_t middle = begin + halve(begin, end);
    add_half(begin, middle);
    add_half(middle, end);
    return parts;
  }

  uint32_t build_leaf(size_t begin, size_t end) {
    PatchLeaf leaf;
    leaf.triangle.fill(kNoFace);
    leaf.corners.fill({});
    for (size_t i = begin; i < end; ++i) {
      leaf.triangle[i - begin] = items_[i].triangle;
      leaf.corners[i - begin] = mesh_.triangles[items_[i].triangle];
    }
    tree_.leaves.push_back(leaf);
    return kPatchLeaf | static_cast<uint32_t>(tree_.leaves.size() - 1);
  }

  /// Box and normals of the triangles themselves.
  Patch measure(size_t begin, size_t end) const {
    Patch patch;
    for (size_t i = begin; i < end; ++i) {
      const Triangle& tri = mesh_.triangles[items_[i].triangle];
      const Vec3 &a = mesh_.vertices[tri[0]], &b = mesh_.vertices[tri[1]],
                 &c = mesh_.vertices[tri[2]];
      patch.lower = component_min(patch.lower, component_min(a, component_min(b, c)));
      patch.upper = component_max(patch.upper, component_max(a, component_max(b, c)));
      patch.normal_sum += cross(b - a, c - a);
    }
    set_axis(patch);
    for (size_t i = begin; i < end; ++i) {
      for (const uint32_t v : mesh_.triangles[items_[i].triangle]) {
        const double height = dot(patch.cone.axis, mesh_.vertices[v]);
        patch.low = std::min(patch.low, height);
        patch.high = std::max(patch.high, height);
        patch.cone.cos = std::min(patch.cone.cos, cos_holding(patch.cone.axis, cones_[v]));
      }
    }
    return patch;
  }

  /// The same from the patches it is made of: looser, and no second look at every triangle.
  static Patch merge(std::span<const Patch> parts) {
    Patch patch;
    for (const Patch& part : parts) {
      patch.lower = component_min(patch.lower, part.lower);
      patch.upper = component_max(patch.upper, part.upper);
      patch.normal_sum += part.normal_sum;
    }
    set_axis(patch);
    const Vec3& axis = patch.cone.axis;
    const Vec3 size{std::fabs(axis.x), std::fabs(axis.y), std::fabs(axis.z)};
    for (const Patch& part : parts) {
      const double middle = dot(axis, 0.5 * (part.lower + part.upper));
      const double half = dot(size, 0.5 * (part.upper - part.lower));
      patch.low = std::min(patch.low, middle - half);
      patch.high = std::max(patch.high, middle + half);
      patch.cone.cos = std::min(patch.cone.cos, cos_holding(axis, part.cone));
    }
    return patch;
  }

  /// The axis as it will be stored: in float.
  static void set_axis(Patch& patch) {
    const Vec3 n = normalized(patch.normal_sum);
    patch.cone = {{static_cast<double>(static_cast<float>(kAxisLength * n.x)),
                   static_cast<double>(static_cast<float>(kAxisLength * n.y)),
                   static_cast<double>(static_cast<float>(kAxisLength * n.z))},
                  1};
  }

  void store(PatchNode& node, size_t lane, const Patch& patch) const {
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<size_t>(k);
      node.lower[row][lane] = round_down(patch.lower[k] - pad_);
      node.upper[row][lane] = round_up(patch.upper[k] + pad_);
      node.axis[row][lane] = static_cast<float>(patch.cone.axis[k]);
    }
    node.low[lane] = round_down(patch.low - pad_);
    node.high[lane] = round_up(patch.high + pad_);
    const double cos = cos_widened(patch.cone.cos);
    node.cos_squared[lane] = cos > 0 ? round_down(cos * cos) : 0;
  }

  static PatchNode empty_node() {
    PatchNode node;
    constexpr float kNowhere = 1e18f;  // its square is still a float
    for (size_t k = 0; k < 3; ++k) {
      node.lower[k].fill(kNowhere);
      node.upper[k].fill(kNowhere);
      node.axis[k].fill(0);
    }
    node.low.fill(0);
    node.high.fill(0);
    node.cos_squared.fill(0);
    node.child.fill(kNoPatch);
    return node;
  }

  /// Appends the node of these items and everything below it.
  Patch build_node(size_t begin, size_t end, uint32_t parent) {
    const auto index = static_cast<uint32_t>(tree_.nodes.size());
    tree_.nodes.push_back(empty_node());
    std::array<size_t, kPatchLanes + 1> cuts;
    const size_t parts = quarter(begin, end, cuts);
    std::array<Patch, kPatchLanes> patches;
    for (size_t lane = 0; lane < parts; ++lane) {
      const size_t from = cuts[lane], to = cuts[lane + 1];
      if (to - from <= kPatchLanes) {
        tree_.nodes[index].child[lane] = build_leaf(from, to);
        patches[lane] = measure(from, to);
      } else {
        tree_.nodes[index].child[lane] = static_cast<uint32_t>(tree_.nodes.size());
        patches[lane] = build_node(
            from, to, index * static_cast<uint32_t>(kPatchLanes) + static_cast<uint32_t>(lane));
      }
      store(tree_.nodes[index], lane, patches[lane]);
    }
    tree_.nodes[index].parent = parent;
    return end - begin <= kExactTriangles ? measure(begin, end) : merge({patches.data(), parts});
  }

  const TriangleMesh& mesh_;
  double pad_ = 0;
  std::vector<Cone> cones_;
  std::vector<Item> items_;
  PatchTreeData tree_;
};

}  // namespace

PatchTreeData build_patch_tree(const TriangleMesh& mesh) {
  return Builder(mesh).build();
}

}  // namespace haptic
