// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/obb_tree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstddef>
#include <limits>

namespace haptic {
namespace {

constexpr size_t kLeafTriangles = 4;  // 2 needs 1.8 times the memory, 8 is no faster
// from here on halves only: 2³² triangles need 32 more levels
constexpr int kHalvingDepth = kMaxTreeDepth - 32;
constexpr double kBoxPad = 1e-14;  // of the largest coordinate: ~45 roundings of a projection

/// A triangle by value: the build sorts these, so that each level reads memory in order.
struct Item {
  Vec3 p[3];
  uint32_t index;
  Vec3 centroid() const { return (p[0] + p[1] + p[2]) / 3.0; }
};

/// Area-weighted mean and covariance of the points of the triangles (Gottschalk 1996):
/// C = Σ Aᵢ/12 (9 m mᵀ + p pᵀ + q qᵀ + r rᵀ) / ΣAᵢ − µ µᵀ, about the first corner: no cancellation.
struct Moments {
  Vec3 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Moments area_moments(std::span<const Item> items) {
  const Vec3 origin = items[0].p[0];
  double total = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Vec3 first;
  const auto add = [&](const Vec3& v, double weight) {
    xx += weight * v.x * v.x, xy += weight * v.x * v.y, xz += weight * v.x * v.z;
    yy += weight * v.y * v.y, yz += weight * v.y * v.z, zz += weight * v.z * v.z;
  };
  // zero-area triangles must still count: a soup may consist of nothing else
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

/// Tight box along the principal axes, longest spread first.
Obb fit_box(std::span<const Item> items, const Moments& moments, double pad) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments.covariance);
  const Eigen::Vector3d x = solver.eigenvectors().col(2), y = solver.eigenvectors().col(1);
  Obb box;
  box.R_BO.row[0] = normalized(Vec3{x[0], x[1], x[2]});
  box.R_BO.row[2] = normalized(cross(box.R_BO.row[0], Vec3{y[0], y[1], y[2]}));
  box.R_BO.row[1] = cross(box.R_BO.row[2], box.R_BO.row[0]);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
  for (const Item& item : items) {
    for (const Vec3& corner : item.p) {
      const Vec3 q = box.R_BO * (corner - moments.mean);
      lower = {std::min(lower.x, q.x), std::min(lower.y, q.y), std::min(lower.z, q.z)};
      upper = {std::max(upper.x, q.x), std::max(upper.y, q.y), std::max(upper.z, q.z)};
    }
  }
  box.centre_O = moments.mean + transpose(box.R_BO) * (0.5 * (lower + upper));
  box.half = 0.5 * (upper - lower) + Vec3{pad, pad, pad};
  return box;
}

/// Longest axis of the box, in O.
Vec3 longest_axis(const Obb& box) {
  const Vec3& h = box.half;
  return box.R_BO.row[h.x >= h.y && h.x >= h.z ? 0 : h.y >= h.z ? 1 : 2];
}

/// Partitions the items along the axis at the mean; returns the size of the first part, in
/// [1, n − 1]. Halves by rank where the mean does not separate.
size_t split(std::span<Item> items, const Vec3& axis, const Vec3& mean, bool halve) {
  const double cut = dot(axis, mean);
  const auto place = [&](const Item& item) { return dot(axis, item.centroid()); };
  if (!halve) {
    const auto middle = std::partition(items.begin(), items.end(),
                                       [&](const Item& item) { return place(item) < cut; });
    const auto n = static_cast<size_t>(middle - items.begin());
    if (n > 0 && n < items.size()) return n;
  }
  const size_t n = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<ptrdiff_t>(n), items.end(),
                   [&](const Item& a, const Item& b) { return place(a) < place(b); });
  return n;
}

/// Fills node `index` and everything below it; `offset` is where the items lie in the order.
void build_node(ObbTreeData& tree, std::span<Item> items, size_t index, size_t offset, int depth,
                double pad) {
  const Moments moments = area_moments(items);
  ObbNode node{fit_box(items, moments, pad), static_cast<uint32_t>(offset),
               static_cast<uint32_t>(items.size())};
  if (items.size() <= kLeafTriangles) {
    tree.nodes[index] = node;
    return;
  }
  const size_t n = split(items, longest_axis(node.box), moments.mean, depth >= kHalvingDepth);
  node.first = static_cast<uint32_t>(tree.nodes.size());
  node.count = 0;
  tree.nodes[index] = node;
  tree.nodes.resize(tree.nodes.size() + 2);
  build_node(tree, items.first(n), node.first, offset, depth + 1, pad);
  build_node(tree, items.subspan(n), node.first + 1, offset + n, depth + 1, pad);
}

}  // namespace

ObbTreeData build_obb_tree(const TriangleMesh& mesh) {
  ObbTreeData tree;
  if (mesh.triangles.empty()) return tree;
  std::vector<Item> items(mesh.triangles.size());
  for (uint32_t i = 0; i < items.size(); ++i) {
    const Triangle& tri = mesh.triangles[i];
    items[i] = {{mesh.vertices[tri[0]], mesh.vertices[tri[1]], mesh.vertices[tri[2]]}, i};
  }
  const Vec3 reach = component_max(mesh.upper, -mesh.lower);
  const double pad = kBoxPad * std::max({std::fabs(reach.x), std::fabs(reach.y), std::fabs(reach.z),
                                         norm(mesh.upper - mesh.lower)});
  tree.nodes.reserve(items.size());
  tree.nodes.resize(1);
  build_node(tree, items, 0, 0, 0, pad);
  tree.order.resize(items.size());
  std::transform(items.begin(), items.end(), tree.order.begin(),
                 [](const Item& item) { return item.index; });
  return tree;
}

}  // namespace haptic
