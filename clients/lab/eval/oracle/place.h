// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/lab/eval/oracle/facets.h"

namespace haptic {

/// Depth of a proxy in the forbidden region, by the nearest of all facets.
struct BehindSurface {
  double depth = 0;       // by which it is closer to the surface than its radius, or behind it [m]
  bool is_known = false;  // false: no facet in range, or a point next to a border
};

/// Tests a sphere (radius 0: a point) against every facet within radius + max_distance; the side of
/// the surface comes from angle-weighted normals.
BehindSurface behind_surface(const FacetBins& facets, const Vec3& centre_O, double radius,
                             double max_distance);

/// The way that a proxy at rest could still move towards the tool, to first order: the length of
/// the feasible direction v that minimises |v − (tool − proxy)| s.t. n_i·v ≥ 0 for all facets that
/// the sphere or point touches (within 1e-9 m). Zero if tool − proxy lies in the cone of −n_i, the
/// KKT condition of a local minimum of |x − tool|. Independent of the path that led there.
double free_descent(const FacetBins& facets, const Vec3& proxy_O, const Vec3& tool_O,
                    double radius);

}  // namespace haptic
