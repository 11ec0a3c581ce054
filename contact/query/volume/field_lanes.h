// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "contact/shape/volume/distance_field.h"
#include "proto/math/pose.h"

namespace haptic {

/// Points of a tool that are looked up together.
struct FieldBatch {
  static constexpr size_t kRoom = 64;
  size_t n = 0;
  std::array<float, kRoom> x{}, y{}, z{};  // in T [m]
  std::array<double, kRoom> distance{};    // what was found [m]
  uint64_t near = 0;                       // bit i: point i is within the band

  FieldDistance found(size_t i) const { return {distance[i], (near >> i & 1) != 0}; }
};

/// Samples the field at each point of the batch, moved in double; bit-identical to sample_distance.
/// Four points at a time with AVX2.
void look_up(const DistanceField& field, const Pose& X_OT, FieldBatch& batch);
/// look_up() without vector instructions.
void look_up_one_by_one(const DistanceField& field, const Pose& X_OT, FieldBatch& batch);

}  // namespace haptic
