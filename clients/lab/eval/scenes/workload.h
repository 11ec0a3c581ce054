// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "contact/shape/mesh/primitives.h"
#include "proto/math/units.h"

namespace haptic {

/// The benchmark set in metres and closed formulas: two families of rough meshes, and a tool
/// dragged over them, 1 mm ± 0.4 mm deep, for 20 s at 1 kHz.
inline constexpr int kEvalTicks = 20'000;  // 20 s at 1 kHz

/// Height of the field over [−0.1, 0.1]²: six sines, 3 mm … 0.15 mm [m].
double field_height(double x, double y);

/// Radius of the bumpy sphere in direction u: 0.1 m (1 + five sines, 4 % … 0.15 %) [m].
double bumpy_radius(const Vec3& u);

/// n × n quads of two triangles on the field, facing +z (n = 742: 1.1 million triangles).
Soup make_height_field(uint32_t n);

/// Geodesic sphere of 20 f² triangles with vertices at bumpy_radius, facing outwards (f = 235: 1.1
/// million triangles).
Soup make_bumpy_sphere(uint32_t f);

/// Depth of the tool below the surface at time t [s]: from 5 mm above within 0.5 s, then
/// 1 mm + 0.4 mm sin(2π 1.7 t) [m].
inline double workload_depth(double t) {
  const double depth = 1e-3 + 0.4e-3 * std::sin(2 * std::numbers::pi * 1.7 * t);
  if (t >= 0.5) return depth;
  double s = t < 0 ? 0 : t / 0.5;
  s = s * s * (3 - 2 * s);
  return -5e-3 * (1 - s) + depth * s;
}

/// The tool over the plane z = 0, at workload_depth below it; up to 0.13 m/s.
inline Vec3 flat_slide(double t) {
  return {0.075 * std::sin(2 * kPi * 0.23 * t), 0.075 * std::sin(2 * kPi * 0.17 * t + 0.9),
          -workload_depth(t)};
}

/// The tool over the height field, for a tool of that radius.
Vec3 field_slide(double t, double tool_radius);

/// The tool over the bumpy sphere, around its polar axis at 27° to 153° from it.
Vec3 sphere_slide(double t, double tool_radius);

/// Direction from the centre to the tool's position on the sphere.
Vec3 sphere_direction(double t);

/// Position of the tool at time t [s].
using ToolPath = std::function<Vec3(double)>;

/// A mesh known by name, with its path.
struct EvalWork {
  std::string name;  // "hf:742"
  Soup soup;
  ToolPath path;
};

/// "hf:n", "sphere:f" or "flat:n" (a plane of n × n quads). Throws std::runtime_error with one line
/// for any other name, and for n or f outside 1 to 1500.
EvalWork make_eval_work(const std::string& name, double tool_radius);

/// True if a name is one of make_eval_work(); otherwise it is a file.
bool is_eval_work(const std::string& name);
/// Their names, for a message: "hf:N, … with N from 1 to 1500".
std::string eval_work_names();

}  // namespace haptic
