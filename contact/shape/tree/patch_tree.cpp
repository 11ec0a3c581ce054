// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/patch_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
constexpr double kPad = 1e-14;  // of the largest coordinate: about 45 roundings of a closest point
constexpr double kThinnest = 1e-9;        // of the largest coordinate: below, a normal is noise
constexpr double kConeSlack = 5e-3;       // [rad]; widens cones against rounding of directions
constexpr double kAxisLength = 1 - 1e-6;  // so that it is at most 1 after rounding to float
constexpr double kThinnestInFloat = 0.1;  // least height of a triangle per longest side
constexpr size_t kExactTriangles = 64;    // larger patches are bounded by merging their children

float round_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -kFloatInfinity) : f;
}

float round_up(double x) {
  return -round_down(-x);
}

/// Directions within an angle of an axis; cos ≤ 0: all directions.
struct Cone {
  Vec3 axis;
  double cos = -1;
};

/// cos of the angle about `axis` that contains a cone: the sum of two angles below 90°.
double cos_holding(const Vec3& axis, const Cone& cone) {
  const double cos = std::min(dot(axis, cone.axis), 1.0);
  if (!(cos > 0) || !(cone.cos > 0)) return -1;
  const double sines = std::sqrt((1 - cos * cos) * std::max(1 - cone.cos * cone.cos, 0.0));
  return cos * cone.cos - sines;
}

/// cos of an angle widened by kConeSlack.
double cos_widened(double cos) {
  if (!(cos > 0)) return -1;
  return cos * std::cos(kConeSlack) -
         std::sqrt(std::max(1 - cos * cos, 0.0)) * std::sin(kConeSlack);
}

double longest_side(const Corners& p) {
  return std::max({norm(p[1] - p[0]), norm(p[2] - p[1]), norm(p[0] - p[2])});
}

/// Whether the smallest height of a triangle is at most `thinnest`: its normal is unreliable.
bool is_thin(const Corners& p, double thinnest) {
  return !(norm(cross(p[1] - p[0], p[2] - p[0])) > thinnest * longest_side(p));
}

/// Bounds of a patch, before rounding.
struct Patch {
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
  double low = kInfinity, high = -kInfinity;
  Cone cone;
  Vec3 normal_sum;
};

class Builder {
 public:
  explicit Builder(const TriangleMesh& mesh) : mesh_(mesh), cones_(mesh.vertices.size()) {
    const double largest = std::max(largest_coordinate(mesh), norm(mesh.upper - mesh.lower));
    pad_ = kPad * largest;
    build_cones(kThinnest * largest);
  }

  PatchTreeData build() {
    const size_t n = mesh_.triangles.size();
    if (n == 0) return {};
    items_.resize(n);
    for (uint32_t i = 0; i < n; ++i) {
      const auto [a, b, c] = corners_of(mesh_, i);
      items_[i] = {to_floats(a + b + c), i};
    }
    tree_.nodes.reserve(n / 40 + 1);
    tree_.leaves.reserve(n / 6 + 1);
    build_node(0, n);
    return std::move(tree_);
  }

 private:
  struct Item {
    std::array<float, 3> centre;  // three times the centroid
    uint32_t triangle;
  };

  /// Per vertex, the cone of the normals around it; all directions on a border.
  void build_cones(double thinnest) {
    for (size_t v = 0; v < cones_.size(); ++v) cones_[v] = {mesh_.vertex_normals[v], 1};
    for (uint32_t f = 0; f < mesh_.triangles.size(); ++f) {
      const Triangle& tri = mesh_.triangles[f];
      const bool sliver = is_thin(corners_of(mesh_, f), thinnest);
      for (size_t i = 0; i < 3; ++i) {
        Cone& cone = cones_[tri[i]];
        cone.cos = sliver ? -1 : std::min(cone.cos, dot(cone.axis, mesh_.face_normals[f]));
        if (mesh_.edge_faces[mesh_.triangle_edges[f][i]][1] != kNoFace) continue;
        cone.cos = cones_[tri[(i + 1) % 3]].cos = -1;
      }
    }
  }

  /// Partitions the items along their longest axis: the n lowest come first.
  void cut(size_t begin, size_t end, size_t n) {
    HAPTIC_ASSERT(n < end - begin);
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
  }

  /// Partitions the items into n_parts of nearly equal size; `ends` receives their ends.
  void cut_into(size_t begin, size_t end, size_t n_parts, size_t* ends) {
    if (n_parts == 1) {
      *ends = end;
      return;
    }
    const size_t n_left = (n_parts + 1) / 2;
    const size_t middle = begin + (end - begin) * n_left / n_parts;
    cut(begin, end, middle - begin);
    cut_into(begin, middle, n_left, ends);
    cut_into(middle, end, n_parts - n_left, ends + n_left);
  }

  /// The smallest number of lanes for n triangles in subtrees of minimum height.
  static size_t count_parts(size_t n) {
    size_t capacity = kPatchLanes;
    while (capacity * kPatchLanes < n) capacity *= kPatchLanes;
    return (n + capacity - 1) / capacity;
  }

  uint32_t build_leaf(size_t begin, size_t end, const Patch& patch) {
    PatchLeaf leaf;
    double side = 0;
    for (int k = 0; k < 3; ++k) {
      leaf.origin[static_cast<size_t>(k)] = round_down(patch.lower[k]);
      const auto origin = static_cast<double>(leaf.origin[static_cast<size_t>(k)]);
      side = std::max(side, patch.upper[k] - origin);
    }
    // positive even if the leaf is a point
    leaf.step = round_up(std::max(side / kPatchSteps, 1e-30));
    leaf.triangle.fill(kNoFace);
    for (auto& corner : leaf.corners) corner.fill({});
    for (size_t i = begin; i < end; ++i) {
      store_triangle(leaf, i - begin, items_[i].triangle);
    }
    tree_.leaves.push_back(leaf);
    return kPatchLeaf | static_cast<uint32_t>(tree_.leaves.size() - 1);
  }

  void store_triangle(PatchLeaf& leaf, size_t lane, uint32_t triangle) const {
    HAPTIC_ASSERT(lane < kPatchLanes);
    leaf.triangle[lane] = triangle;
    const double per_step = 1 / static_cast<double>(leaf.step);
    std::array<std::array<uint32_t, 3>, 3> words;
    Corners steps;
    for (size_t c = 0; c < 3; ++c) {
      const Vec3& v = mesh_.vertices[mesh_.triangles[triangle][c]];
      for (int k = 0; k < 3; ++k) {
        const auto origin = static_cast<double>(leaf.origin[static_cast<size_t>(k)]);
        const double x = std::min((v[k] - origin) * per_step + 0.5, double{kPatchSteps});
        words[c][static_cast<size_t>(k)] = static_cast<uint32_t>(x);
        steps[c][k] = words[c][static_cast<size_t>(k)];
      }
    }
    if (is_thin(steps, kThinnestInFloat * longest_side(steps))) return;
    for (size_t c = 0; c < 3; ++c) {
      leaf.corners[c][lane] = words[c][0] | words[c][1] << 10 | words[c][2] << 20;
    }
  }

  /// Tight bounds, from the triangles.
  Patch measure(size_t begin, size_t end) const {
    Patch patch;
    for (size_t i = begin; i < end; ++i) {
      const auto [a, b, c] = corners_of(mesh_, items_[i].triangle);
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

  /// Bounds from those of the parts: looser, but without visiting every triangle.
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

  /// The axis as it will be stored: rounded to float.
  static void set_axis(Patch& patch) {
    const Vec3 n = kAxisLength * normalized(patch.normal_sum);
    // volatile, because g++ 12.2 -O2 omits the rounding when it vectorises the components
    const volatile float x = static_cast<float>(n.x), y = static_cast<float>(n.y),
                         z = static_cast<float>(n.z);
    patch.cone = {{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}, 1};
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
    constexpr float kNowhere = 1e18f;  // its square is still finite in float
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

  /// Appends the node of these items and its subtree.
  Patch build_node(size_t begin, size_t end) {
    const auto index = static_cast<uint32_t>(tree_.nodes.size());
    tree_.nodes.push_back(empty_node());
    const size_t parts = count_parts(end - begin);
    HAPTIC_ASSERT(begin < end && parts <= kPatchLanes);
    std::array<size_t, kPatchLanes> ends;
    cut_into(begin, end, parts, ends.data());
    std::array<Patch, kPatchLanes> patches;
    for (size_t lane = 0, from = begin; lane < parts; from = ends[lane++]) {
      const size_t to = ends[lane];
      uint32_t child = 0;
      if (to - from <= kPatchLanes) {
        patches[lane] = measure(from, to);
        child = build_leaf(from, to, patches[lane]);
      } else {
        child = static_cast<uint32_t>(tree_.nodes.size());
        patches[lane] = build_node(from, to);
      }
      tree_.nodes[index].child[lane] = child;
      store(tree_.nodes[index], lane, patches[lane]);
    }
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
