// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/math/units.h"

namespace haptic {

/// amplitude·sin(2π·frequency·t)
inline double swing(double amplitude, double frequency, double t) {
  return amplitude * std::sin(2 * kPi * frequency * t);
}

/// The direction in which a path finds the surface: from all around towards the origin, or down.
enum class SurfaceKind { kSphere, kHeightField };

/// A mesh of the benchmarks [m]. Its coordinates are exact floats, so that peers in single
/// precision see the same geometry.
struct WorkloadMesh {
  std::string name;
  SurfaceKind kind = SurfaceKind::kSphere;
  Soup soup;
};

/// Icosphere of 20 F² triangles, radius 50 mm + 4 mm of value noise in five octaves.
WorkloadMesh make_bump_sphere(uint32_t frequency);

/// Height field of 2 n² triangles over 100 mm × 100 mm, 6 mm of value noise in eight octaves.
WorkloadMesh make_nano_surface(uint32_t n);

/// A scan, as make_scanned makes it. Throws MeshError.
WorkloadMesh read_scanned(const std::string& name, const std::string& file);

/// Any mesh, centred and scaled to 100 mm; paths run around it.
WorkloadMesh make_scanned(const std::string& name, Soup soup);

/// Motion of a probe within one tick: from its old place, just outside, to the hand.
struct WorkloadSegment {
  Vec3 from_O, to_O;
};

/// Workload W1: a base point slides over the surface by 0.05 to 2 mm per tick at 1 kHz; each
/// segment starts 0.02 mm outside the previous base point and ends up to 1.2 mm on either side of
/// the current one. About half of them hit. Lengths 0.05 to 2.5 mm; ends are exact floats.
std::vector<WorkloadSegment> dragged_segments(const MeshShape& shape, SurfaceKind kind, size_t n);

/// Workload W2: points along the same path within 1 mm on either side of the surface.
std::vector<Vec3> dragged_points(const MeshShape& shape, SurfaceKind kind, size_t n);

/// Workload W2, far: random points up to 20 mm outside.
std::vector<Vec3> far_points(const MeshShape& shape, SurfaceKind kind, size_t n);

}  // namespace haptic
