// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/facets.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kMostBins = 128;  // along the longest axis

}  // namespace

FacetBins::FacetBins(const TriangleMesh& mesh) : mesh_(mesh) {
  const Vec3 size = mesh.upper - mesh.lower;
  bin_ = std::max({size.x, size.y, size.z, 1e-9}) / kMostBins;
  for (int axis = 0; axis < 3; ++axis) {
    bins_[static_cast<size_t>(axis)] = static_cast<size_t>(size[axis] / bin_) + 1;
  }
  facets_.reserve(mesh.triangles.size());
  first_in_bin_.assign(bins_[0] * bins_[1] * bins_[2] + 1, 0);
  std::vector<size_t> bin_of;
  for (const auto& [a, b, c] : mesh.triangles) {
    Facet facet{widened<long double>(mesh.vertices[a]),
                widened<long double>(mesh.vertices[b]),
                widened<long double>(mesh.vertices[c]),
                {},
                {},
                0};
    facet.normal = normalized(cross(facet.b - facet.a, facet.c - facet.a));
    facet.middle_O = rounded((1.0L / 3) * (facet.a + facet.b + facet.c));
    for (const uint32_t v : {a, b, c}) {
      facet.reach = std::max(facet.reach, norm(mesh.vertices[v] - facet.middle_O));
    }
    reach_ = std::max(reach_, facet.reach);
    const Vec3& m = facet.middle_O;
    bin_of.push_back((bin_along(2, m.z) * bins_[1] + bin_along(1, m.y)) * bins_[0] +
                     bin_along(0, m.x));
    ++first_in_bin_[bin_of.back() + 1];
    facets_.push_back(facet);
  }
  // counting sort
  for (size_t i = 1; i < first_in_bin_.size(); ++i) first_in_bin_[i] += first_in_bin_[i - 1];
  order_.resize(facets_.size());
  std::vector<uint32_t> next = first_in_bin_;
  for (uint32_t t = 0; t < facets_.size(); ++t) order_[next[bin_of[t]]++] = t;
}

size_t FacetBins::bin_along(int axis, double coordinate) const {
  const double last = static_cast<double>(bins_[static_cast<size_t>(axis)] - 1);
  return static_cast<size_t>(std::clamp((coordinate - mesh_.lower[axis]) / bin_, 0.0, last));
}

std::vector<uint32_t> FacetBins::within(const Vec3& centre_O, double radius) const {
  std::vector<uint32_t> near;
  const double far = radius + reach_;
  const auto low = [&](int axis) { return bin_along(axis, centre_O[axis] - far); };
  const auto high = [&](int axis) { return bin_along(axis, centre_O[axis] + far); };
  for (size_t z = low(2); z <= high(2); ++z) {
    for (size_t y = low(1); y <= high(1); ++y) {
      const size_t row = (z * bins_[1] + y) * bins_[0];
      const uint32_t begin = first_in_bin_[row + low(0)], end = first_in_bin_[row + high(0) + 1];
      for (uint32_t i = begin; i < end; ++i) {
        const Facet& facet = facets_[order_[i]];
        if (norm(facet.middle_O - centre_O) <= radius + facet.reach) near.push_back(order_[i]);
      }
    }
  }
  return near;
}

}  // namespace haptic
