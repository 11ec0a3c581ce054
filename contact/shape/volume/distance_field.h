// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "contact/shape/mesh/arrays.h"
#include "contact/shape/tree/obb_tree.h"

namespace haptic {

inline constexpr int kFieldSide = 8;                // cells along an edge of a brick
inline constexpr int kFieldNodes = kFieldSide + 1;  // with the border shared with the next brick

/// The nodes of 8 × 8 × 8 cells, x fastest, in units of band/kFieldUnits; padded at the end, so
/// that pairs along x can be loaded as one word.
struct FieldBrick {
  std::array<int16_t, kFieldNodes * kFieldNodes * kFieldNodes + 7> nodes{};
};

inline constexpr double kFieldUnits = 32767;  // per band
inline constexpr uint32_t kNoFieldBrick = ~0u;

/// Signed distance to a closed mesh, negative inside, in O: trilinear interpolation near the
/// surface, a bound elsewhere (Barbič & James 2008, in sparse bricks).
template <template <class> class Array>
struct DistanceFieldOf {
  Vec3 lower_O;     // node (0, 0, 0)
  double cell = 0;  // [m]
  double band = 0;  // stored distances are clamped to ± this [m]
  std::array<int32_t, 3> bricks{};
  Array<uint32_t> index;  // brick of each place, x fastest; kNoFieldBrick: far
  Array<float> middle;    // distance at the middle of each place [m]
  Array<FieldBrick> data;

  DistanceFieldOf<ArrayView> view() const {
    return {lower_O, cell, band, bricks, index, middle, data};
  }
  size_t bytes() const {
    return index.size() * sizeof(uint32_t) + middle.size() * sizeof(float) +
           data.size() * sizeof(FieldBrick);
  }
};
using DistanceField = DistanceFieldOf<ArrayView>;
using DistanceFieldData = DistanceFieldOf<ArrayData>;

/// The field at a point.
struct FieldSample {
  double distance = 0;  // [m]
  Vec3 gradient_O;      // of the trilinear interpolation; zero if far
  bool is_near = false;  // false: `distance` is a bound of the right sign, |φ| ≥ |distance| ≥ band
};

/// A sample without its gradient.
struct FieldDistance {
  double distance = 0;  // [m]
  bool is_near = false;
};

/// Trilinear, continuous within the band: neighbouring bricks share the nodes on their border.
/// Outside the field the bound is the distance to its border plus the band, or more.
FieldSample sample_field(const DistanceField& field, const Vec3& p_O);
/// The distance of sample_field, bit-identical.
FieldDistance sample_distance(const DistanceField& field, const Vec3& p_O);

struct DistanceFieldOptions {
  double cell = 1e-3;    // [m]
  double band = 4e-3;    // [m]; bricks nearer to the surface than this are stored
  double margin = 4e-3;  // around the mesh, at least the band [m]
};

/// Exact signed distance from a point to the mesh [m].
using SignedDistance = std::function<double(const Vec3& p_O)>;

/// Bakes the field of a closed mesh with these bounds; at start-up only. `progress` is called with
/// the share done, from 0 to 1. `distance` is called from two threads if run_both uses them.
DistanceFieldData build_distance_field(const Vec3& lower_O, const Vec3& upper_O,
                                       const SignedDistance& distance,
                                       const DistanceFieldOptions& options,
                                       const RunBoth& run_both = {},
                                       const std::function<void(double)>& progress = {});

}  // namespace haptic
