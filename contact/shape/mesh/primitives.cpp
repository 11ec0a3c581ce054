// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/primitives.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// The twelve vertices, cyclic permutations of (0, ±1, ±φ), and the twenty faces.
Soup make_icosahedron() {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  return {{{-1, phi, 0},
           {1, phi, 0},
           {-1, -phi, 0},
           {1, -phi, 0},
           {0, -1, phi},
           {0, 1, phi},
           {0, -1, -phi},
           {0, 1, -phi},
           {phi, 0, -1},
           {phi, 0, 1},
           {-phi, 0, -1},
           {-phi, 0, 1}},
          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
}

/// Splits each triangle into four at the midpoints of its sides, projected onto the unit sphere.
Soup subdivide(const Soup& coarse) {
  Soup fine{coarse.vertices, {}};
  fine.triangles.reserve(4 * coarse.triangles.size());
  std::unordered_map<uint64_t, uint32_t> midpoints;
  const auto midpoint = [&](uint32_t a, uint32_t b) {
    const uint64_t key = uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [entry, is_new] =
        midpoints.try_emplace(key, static_cast<uint32_t>(fine.vertices.size()));
    if (is_new) fine.vertices.push_back(normalized(fine.vertices[a] + fine.vertices[b]));
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const uint32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    fine.triangles.insert(fine.triangles.end(),
                          {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

Soup make_one(std::monostate) {
  return {};
}
#define PRIMITIVE(Kind, name, make)            \
  Soup make_one(const primitive::Kind& kind) { \
    return make(kind);                         \
  }
#include "proto/config/primitives.def"

/// Vertices of a geodesic sphere, shared between the faces of the icosahedron; identified by the
/// corners they are interpolated from, with weights.
class GeodesicVertices {
 public:
  GeodesicVertices(uint32_t f, const Soup& icosahedron, Soup& soup)
      : f_(f), corners_(icosahedron.vertices), soup_(soup) {}

  uint32_t at(const Triangle& face, uint32_t i, uint32_t j) {
    using Part = std::array<uint32_t, 2>;  // corner, weight
    Key key{Part{face[0], f_ - i - j}, Part{face[1], i}, Part{face[2], j}};
    // corners with weight 0 do not count
    for (Part& part : key) part = part[1] == 0 ? Part{} : part;
    std::sort(key.begin(), key.end());
    const auto [known, fresh] =
        known_.try_emplace(key, static_cast<uint32_t>(soup_.vertices.size()));
    if (fresh) {
      Vec3 mixed;
      for (const auto& [corner, weight] : key) {
        mixed += static_cast<double>(weight) * corners_[corner];
      }
      soup_.vertices.push_back(normalized(mixed));
    }
    return known->second;
  }

 private:
  using Key = std::array<std::array<uint32_t, 2>, 3>;
  uint32_t f_;
  const std::vector<Vec3>& corners_;
  Soup& soup_;
  std::map<Key, uint32_t> known_;
};

}  // namespace

Soup make_mesh(const Primitive& primitive) {
  return std::visit([](const auto& kind) { return make_one(kind); }, primitive);
}

Soup make_box(const primitive::Box& box) {
  const Vec3& extent = box.extent;
  Soup soup;
  for (uint32_t i = 0; i < 8; ++i) {
    soup.vertices.push_back({(i & 1 ? 0.5 : -0.5) * extent.x, (i & 2 ? 0.5 : -0.5) * extent.y,
                             (i & 4 ? 0.5 : -0.5) * extent.z});
  }
  soup.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return soup;
}

Soup make_sphere(const primitive::Sphere& sphere) {
  return make_icosphere(0.5 * sphere.diameter, sphere.subdivisions);
}

Soup make_icosphere(double radius, uint32_t subdivisions) {
  HAPTIC_ASSERT(radius > 0);
  Soup soup = make_icosahedron();
  for (Vec3& v : soup.vertices) v = normalized(v);
  for (uint32_t i = 0; i < subdivisions; ++i) soup = subdivide(soup);
  for (Vec3& v : soup.vertices) v *= radius;
  return soup;
}

Soup make_geodesic(uint32_t f) {
  HAPTIC_ASSERT(f > 0);
  const Soup icosahedron = make_icosphere(1, 0);
  Soup soup;
  GeodesicVertices vertices(f, icosahedron, soup);
  for (const Triangle& face : icosahedron.triangles) {
    for (uint32_t i = 0; i < f; ++i) {
      for (uint32_t j = 0; i + j < f; ++j) {
        const uint32_t b = vertices.at(face, i + 1, j), c = vertices.at(face, i, j + 1);
        soup.triangles.push_back({vertices.at(face, i, j), b, c});
        if (i + j + 1 < f) soup.triangles.push_back({b, vertices.at(face, i + 1, j + 1), c});
      }
    }
  }
  return soup;
}

Soup make_grid(double half, uint32_t n) {
  HAPTIC_ASSERT(half > 0 && n > 0);
  Soup soup;
  for (uint32_t j = 0; j <= n; ++j) {
    for (uint32_t i = 0; i <= n; ++i) {
      soup.vertices.push_back({half * (2.0 * i / n - 1), half * (2.0 * j / n - 1), 0});
    }
  }
  for (uint32_t j = 0; j < n; ++j) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = c - 1;
      soup.triangles.insert(soup.triangles.end(), {{a, b, c}, {a, c, d}});
    }
  }
  return soup;
}

}  // namespace haptic
