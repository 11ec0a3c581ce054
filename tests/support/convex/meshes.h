// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/mesh/primitives.h"

namespace haptic::test {

/// Prism of height `height` over an L of side `side`, whose arms are half as wide.
Soup make_l_shape(double side, double height);

/// An open flat L, facing +z.
Soup make_flat_l(double side);

/// Open sheet z = f(x, y) over [-half, half]², n × n quads, facing +z.
Soup make_height_sheet(double half, uint32_t n, const std::function<double(double, double)>& f);

/// Sphere with a dent at +z: within the angle `angle` [rad] the radius is less, by `depth` at most.
Soup make_dented_ball(double radius, uint32_t subdivisions, double angle, double depth);

/// Sphere whose radius varies by ±share, sin(k x) sin(k y) sin(k z) of the unit direction.
Soup make_bumpy_ball(double radius, uint32_t subdivisions, double share, double k);

/// Torus about the z axis: n × m quads.
Soup make_torus(double ring, double tube, uint32_t n, uint32_t m);

/// An open strip that is wound about the z axis, `turns` times from `radius` to twice that, facing
/// outwards: convex at each of its edges.
Soup make_spiral_strip(double radius, double width, double turns, uint32_t n);

/// An open dome and, in its hull but apart from it, the tip of a closed needle.
Soup make_cap_over_needle(double radius);

}  // namespace haptic::test
