// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/obb_tree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kFullLeaves = 64;  // sets up to this size are split such that leaves are full
// deeper nodes are split at the median: 2³² triangles need at most 32 more levels
constexpr int kHalvingDepth = kMaxTreeDepth - 32;
constexpr uint32_t kIndexMask = (1u << 28) - 1;
constexpr int kBranchingDepth = 4;          // 16 pieces of work
constexpr size_t kBranchingSize = 1 << 12;  // triangles; below, a thread does not pay off
constexpr double kBoxPad = 1e-14;  // of the largest coordinate: about 45 roundings of a projection

/// A triangle by value: the build sorts these, so each level reads memory sequentially.
struct Item {
  Corners p;
  uint32_t index;
  Vec3 centroid() const { return (p[0] + p[1] + p[2]) / 3.0; }
};

/// Area-weighted mean and covariance of the triangles' surface (Gottschalk, Lin, Manocha 1996), C =
/// Σ Aᵢ/12 (9 m mᵀ + p pᵀ + q qᵀ + r rᵀ) / ΣAᵢ − µ µᵀ, relative to the first corner to avoid
/// cancellation.
struct Moments {
  Vec3 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Moments area_moments(std::span<const Item> items) {
  HAPTIC_ASSERT(!items.empty());
  const Vec3 origin = items[0].p[0];
  double total = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Vec3 first;
  const auto add = [&](const Vec3& v, double weight) {
    xx += weight * v.x * v.x, xy += weight * v.x * v.y, xz += weight * v.x * v.z;
    yy += weight * v.y * v.y, yz += weight * v.y * v.z, zz += weight * v.z * v.z;
  };
  // without any area all triangles count equally
  for (const bool use_area : {true, false}) {
    for (const Item& item : items) {
      const Vec3 p = item.p[0] - origin, q = item.p[1] - origin, r = item.p[2] - origin;
      const Vec3 m = (p + q + r) / 3.0;
      const double area = use_area ? norm(cross(q - p, r - p)) : 1;
      total += area;
      first += area * m;
      add(m, area * 9 / 12);
      for (const Vec3& corner : {p, q, r}) add(corner, area / 12);
    }
    if (total > 0) break;
  }
  Moments moments;
  const Vec3 mean = first / total;
  Eigen::Matrix3d& c = moments.covariance;
  c << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  const Eigen::Vector3d mu(mean.x, mean.y, mean.z);
  c = c / total - mu * mu.transpose();
  moments.mean = origin + mean;
  return moments;
}

/// A box while it is fitted, in double; R_BO is already rounded to float.
struct FittedBox {
  Mat3 R_BO;
  Vec3 half;
  CompactObb compact;
};

float rounded_up(double value) {
  const auto near = static_cast<float>(value);
  return static_cast<double>(near) < value
             ? std::nextafter(near, std::numeric_limits<float>::infinity())
             : near;
}

Mat3 to_axes(const Eigen::Matrix3d& eigenvectors) {
  const Eigen::Vector3d x = eigenvectors.col(2), y = eigenvectors.col(1);
  Mat3 R;
  R.row[0] = normalized(Vec3{x[0], x[1], x[2]});
  R.row[2] = normalized(cross(R.row[0], Vec3{y[0], y[1], y[2]}));
  R.row[1] = cross(R.row[2], R.row[0]);
  return R;
}

/// Principal axes, the largest variance first.
Mat3 principal_axes(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Mat3 R = to_axes(solver.eigenvectors());
  // the closed form fails for equal or vanishing variances; the iterative solver does not
  if (std::fabs(norm(R.row[0]) + norm(R.row[1]) + norm(R.row[2]) - 3) < 1e-9) return R;
  return to_axes(solver.compute(covariance).eigenvectors());
}

/// Tight box along the principal axes, for axes and centre as rounded to float.
FittedBox fit_box(std::span<const Item> items, const Moments& moments, double pad) {
  FittedBox box;
  const Mat3 R = principal_axes(moments.covariance);
  for (int j = 0; j < 3; ++j) {
    const std::array<float, 3> column = to_floats(R.column(j));
    std::copy(column.begin(), column.end(), box.compact.columns_BO.begin() + 3 * j);
  }
  // read back: extents are measured along the rounded axes
  box.R_BO = box.compact.unpacked().R_BO;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
  for (const Item& item : items) {
    for (const Vec3& corner : item.p) {
      const Vec3 q = box.R_BO * (corner - moments.mean);
      lower = {std::min(lower.x, q.x), std::min(lower.y, q.y), std::min(lower.z, q.z)};
      upper = {std::max(upper.x, q.x), std::max(upper.y, q.y), std::max(upper.z, q.z)};
    }
  }
  box.compact.centre_O = to_floats(moments.mean + transpose(box.R_BO) * (0.5 * (lower + upper)));
  const Vec3 centre = box.compact.unpacked().centre_O, c = box.R_BO * (centre - moments.mean);
  box.half = component_max(upper - c, c - lower) + Vec3{pad, pad, pad};
  box.compact.half = {rounded_up(box.half.x), rounded_up(box.half.y), rounded_up(box.half.z)};
  const auto& half = box.compact.half;
  if (!std::isfinite(half[0] + half[1] + half[2]) || !is_finite(centre)) {
    box.compact = {};
    box.compact.half.fill(std::numeric_limits<float>::infinity());
  }
  return box;
}

/// Partitions the items along the axis at the mean; returns the size of the first part, in [1, n −
/// 1]. Splits at the median if the mean does not separate; small sets are split such that leaves
/// are full.
size_t split(std::span<Item> items, const Vec3& axis, const Vec3& mean, bool halve) {
  HAPTIC_ASSERT(items.size() > kLeafTriangles);
  const double cut = dot(axis, mean);
  const auto place = [&](const Item& item) { return dot(axis, item.centroid()); };
  size_t n = 0;
  if (!halve) {
    const auto middle = std::partition(items.begin(), items.end(),
                                       [&](const Item& item) { return place(item) < cut; });
    n = static_cast<size_t>(middle - items.begin());
    if (n > 0 && n < items.size() && items.size() > kFullLeaves) return n;
  }
  if (n == 0 || n == items.size()) n = items.size() / 2;
  n = (n + kLeafTriangles / 2) / kLeafTriangles * kLeafTriangles;
  const size_t most = (items.size() - 1) / kLeafTriangles * kLeafTriangles;
  n = std::clamp(n, kLeafTriangles, most);
  std::nth_element(items.begin(), items.begin() + static_cast<ptrdiff_t>(n), items.end(),
                   [&](const Item& a, const Item& b) { return place(a) < place(b); });
  return n;
}

ObbNode make_node(const FittedBox& box, size_t first, size_t count) {
  HAPTIC_ASSERT(count <= kLeafTriangles && first <= kIndexMask);
  ObbNode node{box.compact, 0, 0};
  node.first = static_cast<uint32_t>(first) & kIndexMask;
  node.count = static_cast<uint32_t>(count) & 15;
  return node;
}

/// Box and split of a set of triangles.
struct Split {
  FittedBox box;
  size_t n_first = 0;  // 0: a leaf
};

Split split_items(std::span<Item> items, int depth, double pad) {
  HAPTIC_ASSERT(depth <= kMaxTreeDepth);
  const Moments moments = area_moments(items);
  Split result{fit_box(items, moments, pad), 0};
  if (items.size() <= kLeafTriangles) return result;
  result.n_first = split(items, result.box.R_BO.row[longest_axis(result.box.half)], moments.mean,
                         depth >= kHalvingDepth);
  return result;
}

/// Fills node `index` and its subtree; `offset` is the position of the items in the order.
void build_node(std::vector<ObbNode>& nodes, std::span<Item> items, size_t index, size_t offset,
                int depth, double pad) {
  const Split parts = split_items(items, depth, pad);
  const size_t n = parts.n_first, first = nodes.size();
  if (n == 0) {
    nodes[index] = make_node(parts.box, offset, items.size());
    return;
  }
  nodes[index] = make_node(parts.box, first, 0);
  nodes.resize(first + 2);
  build_node(nodes, items.first(n), first, offset, depth + 1, pad);
  build_node(nodes, items.subspan(n), first + 1, offset + n, depth + 1, pad);
}

/// Appends the nodes of a subtree below its root, with child indices shifted.
void append_below_root(std::vector<ObbNode>& nodes, std::span<const ObbNode> subtree, size_t root) {
  const size_t shift = nodes.size() - 1;
  const auto moved = [&](ObbNode node) {
    if (node.count == 0) node.first = static_cast<uint32_t>(node.first + shift) & kIndexMask;
    return node;
  };
  nodes[root] = moved(subtree[0]);
  std::transform(subtree.begin() + 1, subtree.end(), std::back_inserter(nodes), moved);
}

/// Builds a subtree with its own indices, root first; the upper levels branch into parallel work.
std::vector<ObbNode> build_branching(std::span<Item> items, size_t offset, int depth, double pad,
                                     const RunBoth& run_both) {
  std::vector<ObbNode> nodes(1);
  if (depth == kBranchingDepth || items.size() < kBranchingSize) {
    build_node(nodes, items, 0, offset, depth, pad);
    return nodes;
  }
  const Split parts = split_items(items, depth, pad);
  const size_t n = parts.n_first;
  std::vector<ObbNode> low, high;
  run_both([&] { low = build_branching(items.first(n), offset, depth + 1, pad, run_both); },
           [&] { high = build_branching(items.subspan(n), offset + n, depth + 1, pad, run_both); });
  nodes.reserve(1 + low.size() + high.size());
  nodes[0] = make_node(parts.box, 1, 0);
  nodes.resize(3);
  append_below_root(nodes, low, 1);
  append_below_root(nodes, high, 2);
  return nodes;
}

}  // namespace

Obb CompactObb::unpacked() const {
  const std::array<float, 9>& c = columns_BO;
  return {{{{c[0], c[3], c[6]}, {c[1], c[4], c[7]}, {c[2], c[5], c[8]}}},
          {centre_O[0], centre_O[1], centre_O[2]},
          {half[0], half[1], half[2]}};
}

ObbTreeData build_obb_tree(const TriangleMesh& mesh, const RunBoth& run_both) {
  ObbTreeData tree;
  if (mesh.triangles.empty()) return tree;
  if (mesh.triangles.size() > kMaxTreeTriangles) {
    throw std::length_error("more triangles than a tree can count");
  }
  std::vector<Item> items(mesh.triangles.size());
  for (uint32_t i = 0; i < items.size(); ++i) {
    items[i] = {corners_of(mesh, i), i};
  }
  const double pad = kBoxPad * std::max(largest_coordinate(mesh), norm(mesh.upper - mesh.lower));
  tree.nodes = build_branching(items, 0, 0, pad, run_both);
  tree.order.resize(items.size());
  std::transform(items.begin(), items.end(), tree.order.begin(),
                 [](const Item& item) { return item.index; });
  return tree;
}

}  // namespace haptic
