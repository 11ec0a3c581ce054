// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/parts/vessel.h"

#include <algorithm>
#include <numbers>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kSectors = 6;  // of the cap, each a grid of nearly equilateral triangles

/// Number of vertices of the rings before this one.
uint32_t first_of(uint32_t ring, const VesselGrid& grid) {
  if (ring == 0) return 0;
  const uint32_t on_cap = std::min(ring, grid.rings + 1);
  return 1 + kSectors * (on_cap * (on_cap - 1) / 2 + (ring - on_cap) * grid.rings);
}

/// The triangles between ring k - 1 and ring k of the cap.
void add_cap_ring(Soup& soup, uint32_t k, const VesselGrid& grid) {
  const uint32_t inner = first_of(k - 1, grid), outer = first_of(k, grid);
  const uint32_t n_inner = std::max(1u, kSectors * (k - 1)), n_outer = kSectors * k;
  for (uint32_t sector = 0; sector < kSectors; ++sector) {
    for (uint32_t j = 0; j < k; ++j) {
      const uint32_t a = outer + (sector * k + j) % n_outer;
      const uint32_t b = outer + (sector * k + j + 1) % n_outer;
      const uint32_t c = inner + (sector * (k - 1) + j) % n_inner;
      soup.triangles.push_back({c, a, b});
      if (j + 1 == k) continue;
      soup.triangles.push_back({c, b, inner + (sector * (k - 1) + j + 1) % n_inner});
    }
  }
}

}  // namespace

Soup make_vessel(const VesselAt& position, const Vec3& end, const VesselGrid& grid,
                 bool faces_down) {
  HAPTIC_ASSERT(grid.rings >= 1 && grid.rows >= 1);
  Soup soup;
  const uint32_t around = kSectors * grid.rings, last = grid.rings + grid.rows;
  for (uint32_t ring = 0; ring <= last; ++ring) {
    const uint32_t n = std::max(1u, kSectors * std::min(ring, grid.rings));
    for (uint32_t i = 0; i < n; ++i) {
      soup.vertices.push_back(position(ring, 2 * std::numbers::pi * i / n));
    }
  }
  for (uint32_t k = 1; k <= grid.rings; ++k) add_cap_ring(soup, k, grid);
  for (uint32_t row = grid.rings; row < last; ++row) {
    const uint32_t upper = first_of(row, grid), lower = upper + around;
    for (uint32_t i = 0; i < around; ++i) {
      const uint32_t j = (i + 1) % around;
      soup.triangles.push_back({upper + i, lower + i, lower + j});
      soup.triangles.push_back({upper + i, lower + j, upper + j});
    }
  }
  const uint32_t rim = first_of(last, grid), centre = static_cast<uint32_t>(soup.vertices.size());
  soup.vertices.push_back(end);
  for (uint32_t i = 0; i < around; ++i) {
    soup.triangles.push_back({rim + i, centre, rim + (i + 1) % around});
  }
  if (faces_down) {
    for (Triangle& t : soup.triangles) std::swap(t[1], t[2]);
  }
  return soup;
}

}  // namespace haptic
