// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <utility>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// A mesh with each vertex put where `place` puts it.
Soup mapped(Soup soup, const auto& place) {
  for (Vec3& v : soup.vertices) v = place(v);
  return soup;
}

inline Soup lowered(Soup soup, double by) {
  return mapped(std::move(soup), [by](const Vec3& v) { return v - Vec3{0, 0, by}; });
}
inline Soup scaled(Soup soup, double by) {
  return mapped(std::move(soup), [by](const Vec3& v) { return by * v; });
}

/// A surface that closes upon itself both ways, as a torus: n × m points, two triangles a quad.
Soup make_closed_grid(uint32_t n, uint32_t m, const auto& point) {
  Soup soup;
  const auto at = [&](uint32_t i, uint32_t j) { return (i % n) * m + j % m; };
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < m; ++j) {
      soup.vertices.push_back(point(i, j));
      const uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      soup.triangles.insert(soup.triangles.end(), {{a, b, c}, {a, c, d}});
    }
  }
  return soup;
}

}  // namespace haptic
