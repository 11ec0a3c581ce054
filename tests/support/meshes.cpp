// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/meshes.h"

#include <fstream>

namespace haptic::test {

Soup load_off(const std::string& name, double size) {
  const auto path = find_mesh(name);
  Soup soup;
  if (!path) return soup;
  std::ifstream in(*path);
  std::string magic;
  size_t n_vertices = 0, n_triangles = 0, ignored = 0;
  in >> magic >> n_vertices >> n_triangles >> ignored;
  soup.vertices.resize(n_vertices);
  soup.triangles.resize(n_triangles);
  for (Vec3& v : soup.vertices) in >> v.x >> v.y >> v.z;
  for (Triangle& t : soup.triangles) in >> ignored >> t[0] >> t[1] >> t[2];
  Vec3 lower = soup.vertices.at(0), upper = lower;
  for (const Vec3& v : soup.vertices) {
    lower = component_min(lower, v);
    upper = component_max(upper, v);
  }
  const Vec3 side = upper - lower;
  const double scale = size / std::max({side.x, side.y, side.z});
  for (Vec3& v : soup.vertices) v = scale * (v - 0.5 * (lower + upper));
  return soup;
}

Soup make_rough_sheet(uint64_t seed, uint32_t n, double slope) {
  Random random(seed);
  Soup soup = make_grid(0.05, n);
  for (Vec3& v : soup.vertices) v.z = slope * 0.05 / n * random.uniform(-1, 1);
  return soup;
}

Soup make_degenerate_soup(uint64_t seed, size_t n) {
  Random random(seed);
  Soup soup;
  for (size_t i = 0; i < n; ++i) {
    const Vec3 at = random.in_box({-1, -1, -1}, {1, 1, 1});
    Vec3 p[3] = {at, at + 0.2 * random.direction(), at + 0.2 * random.direction()};
    if (i % 5 == 1) p[2] = p[1];
    if (i % 5 == 2) p[2] = p[0] + random.uniform(-1, 2) * (p[1] - p[0]);
    if (i % 5 == 3) p[1] = p[2] = p[0];
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), p, p + 3);
    soup.triangles.push_back({first, first + 1, first + 2});
    if (i % 7 == 0) soup.triangles.push_back(soup.triangles.back());
  }
  return soup;
}

}  // namespace haptic::test
