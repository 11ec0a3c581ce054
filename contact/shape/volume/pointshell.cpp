// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/pointshell.h"

#include <algorithm>
#include <cmath>

#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kSamplesAcross = 3;      // per cube
constexpr double kMostSamples = 1 << 12;  // along a side of one triangle
constexpr double kTie = 1e-6;             // [cubes²]; closer distances count as equal
constexpr double kRoundUp = 1 + 1e-6;     // covers the rounding of lengths to float

struct Sample {
  uint64_t code;      // Morton code of its cube
  double off_middle;  // squared distance from the middle of the cube, in units of kTie
  uint32_t triangle;
  Vec3 p;
};

/// Spreads the bits of v to every third bit.
uint64_t spread_bits(uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

Sample sample_at(const Vec3& p, uint32_t triangle, const Vec3& lower, double spacing) {
  const Vec3 q = (p - lower) / spacing;
  const Vec3 cube{std::floor(q.x), std::floor(q.y), std::floor(q.z)};
  const auto bits = [](double v) { return spread_bits(static_cast<uint64_t>(std::max(v, 0.0))); };
  const uint64_t code = bits(cube.x) | bits(cube.y) << 1 | bits(cube.z) << 2;
  // faces that share a corner or an edge tie there: rounding must not decide
  const double off_middle = norm_squared(q - cube - Vec3{0.5, 0.5, 0.5});
  return {code, std::round(off_middle / kTie), triangle, p};
}

/// Corner of the first cube. The cubes are centred on the middle of the mesh, so that symmetric
/// meshes get symmetric points, and are placed such that its outermost faces do not lie on their
/// borders.
Vec3 first_cube(const TriangleMesh& mesh, double spacing) {
  const auto along = [&](double lower, double upper) {
    const double half = 0.5 * (upper - lower) / spacing, part = half - std::floor(half);
    const bool middle_is_border = part > 0.25 && part < 0.75;
    const double cubes = middle_is_border ? std::ceil(half) : std::floor(half + 0.5) + 0.5;
    return 0.5 * (lower + upper) - spacing * cubes;
  };
  const Vec3 &a = mesh.lower, &b = mesh.upper;
  return {along(a.x, b.x), along(a.y, b.y), along(a.z, b.z)};
}

/// Samples on a grid over the triangle, including its corners and its centroid.
void sample_triangle(const TriangleMesh& mesh, uint32_t triangle, const Vec3& lower, double spacing,
                     std::vector<Sample>& out) {
  const auto [a, b, c] = corners_of(mesh, triangle);
  const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
  const int n = static_cast<int>(
      std::clamp(std::ceil(kSamplesAcross * longest / spacing), 1.0, kMostSamples));
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      out.push_back(sample_at(a + u * (b - a) + v * (c - a), triangle, lower, spacing));
    }
  }
  out.push_back(sample_at((a + b + c) / 3, triangle, lower, spacing));
}

/// One sample per cube, in Morton order.
std::vector<Sample> choose_samples(const TriangleMesh& mesh, double spacing) {
  std::vector<Sample> samples;
  const Vec3 lower = first_cube(mesh, spacing);
  const auto before = [](const Sample& a, const Sample& b) {
    if (a.code != b.code) return a.code < b.code;
    if (a.off_middle != b.off_middle) return a.off_middle < b.off_middle;
    return a.triangle < b.triangle;
  };
  const auto same_cube = [](const Sample& a, const Sample& b) { return a.code == b.code; };
  const auto thin_out = [&] {
    std::sort(samples.begin(), samples.end(), before);
    samples.erase(std::unique(samples.begin(), samples.end(), same_cube), samples.end());
  };
  size_t thinned = 1 << 20;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    // a triangle without area has no normal
    if (mesh.face_normals[t] == Vec3{}) continue;
    sample_triangle(mesh, t, lower, spacing, samples);
    if (samples.size() < 2 * thinned) continue;
    thin_out();
    thinned = std::max(samples.size(), thinned);
  }
  thin_out();
  return samples;
}

float distance_between(const PointshellData& shell, uint32_t a, uint32_t b) {
  const auto square = [](float v) { return static_cast<double>(v) * static_cast<double>(v); };
  const double d2 = square(shell.x[a] - shell.x[b]) + square(shell.y[a] - shell.y[b]) +
                    square(shell.z[a] - shell.z[b]);
  return static_cast<float>(std::sqrt(d2) * kRoundUp);
}

float ball_around(const PointshellData& shell, uint32_t point, uint32_t first, uint32_t count) {
  float radius = 0;
  for (uint32_t i = first; i < first + count; ++i) {
    radius = std::max(radius, distance_between(shell, point, i));
  }
  return radius;
}

/// The parents of a level: nodes whose cubes lie in the same cube of twice the edge.
std::vector<ShellNode> shell_parents(const PointshellData& shell,
                                     const std::vector<Sample>& samples,
                                     const std::vector<ShellNode>& children, int level) {
  HAPTIC_ASSERT(!children.empty());
  std::vector<ShellNode> parents;
  const auto cube_of = [&](const ShellNode& node) { return samples[node.first].code >> 3 * level; };
  for (uint32_t begin = 0, end = 0; begin < children.size(); begin = end) {
    while (end < children.size() && cube_of(children[end]) == cube_of(children[begin])) ++end;
    ShellNode parent;
    parent.first = children[begin].first;
    parent.first_child = begin;
    parent.n_children = end - begin;
    HAPTIC_ASSERT(parent.n_children <= 8);
    parent.count = children[end - 1].first + children[end - 1].count - parent.first;
    // the child's point that has the smallest ball around all points
    for (uint32_t k = begin; k < end; ++k) {
      const float radius = ball_around(shell, children[k].point, parent.first, parent.count);
      if (k > begin && radius >= parent.radius) continue;
      parent.radius = radius;
      parent.point = children[k].point;
    }
    parents.push_back(parent);
  }
  return parents;
}

/// Builds the levels from the finest to the root; stored root first.
void build_levels(PointshellData& shell, const std::vector<Sample>& samples) {
  std::vector<std::vector<ShellNode>> levels(1);
  for (uint32_t i = 0; i < samples.size(); ++i) levels[0].push_back({i, 1, 0, 0, i, 0});
  while (levels.back().size() > 1) {
    levels.push_back(shell_parents(shell, samples, levels.back(), static_cast<int>(levels.size())));
  }
  std::reverse(levels.begin(), levels.end());
  for (const std::vector<ShellNode>& level : levels) {
    shell.levels.push_back(static_cast<uint32_t>(shell.nodes.size()));
    const auto next = static_cast<uint32_t>(shell.nodes.size() + level.size());
    for (ShellNode node : level) {
      if (node.n_children > 0) node.first_child += next;
      shell.nodes.push_back(node);
    }
  }
  shell.levels.push_back(static_cast<uint32_t>(shell.nodes.size()));
}

}  // namespace

PointshellData build_pointshell(const TriangleMesh& mesh, double spacing) {
  PointshellData shell;
  if (mesh.triangles.empty() || !(spacing > 0) ||
      !(longest_of(mesh.upper - mesh.lower) < kMostCubes * spacing)) {
    return shell;
  }
  shell.spacing = spacing;
  const std::vector<Sample> samples = choose_samples(mesh, spacing);
  for (const Sample& s : samples) {
    const Vec3 inwards = -mesh.face_normals[s.triangle];
    const auto add = [](std::vector<float>& to, double v) { to.push_back(static_cast<float>(v)); };
    add(shell.x, s.p.x), add(shell.y, s.p.y), add(shell.z, s.p.z);
    add(shell.nx, inwards.x), add(shell.ny, inwards.y), add(shell.nz, inwards.z);
    shell.radius = std::max(shell.radius, norm(s.p) * kRoundUp);
  }
  if (!samples.empty()) build_levels(shell, samples);
  return shell;
}

}  // namespace haptic
