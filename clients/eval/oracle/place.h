// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/eval/oracle/facets.h"

namespace haptic {

/// How far a proxy is where it may not be, by the nearest of all facets.
struct BehindSurface {
  double depth = 0;       // what it lacks to be its radius in front of the surface [m]
  bool is_known = false;  // false: no facet near enough to say, or a point beside a border
};

/// A sphere (radius 0: a point) against every facet within radius + max_distance; the side of the
/// surface by angle-weighted normals.
BehindSurface behind_surface(const FacetBins& facets, const Vec3& centre_O, double radius,
                             double max_distance);

/// How far a proxy at rest could still go towards the tool, to first order: the length of the
/// steepest way v that no facet forbids which the sphere or point touches (within 1e-9 m),
/// min |v − (tool − proxy)| s.t. n_i·v ≥ 0. Zero where tool − proxy lies in the cone of −n_i: the
/// KKT condition of a local minimum of |x − tool|. It knows nothing of the way that led there.
double free_descent(const FacetBins& facets, const Vec3& proxy_O, const Vec3& tool_O,
                    double radius);

}  // namespace haptic
