// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/query/triangle/distance_batch.h"
#include "proto/math/pose.h"

namespace haptic {

/// Whether the processor has AVX-512, and the build has no memory sanitizer.
bool can_measure_by_eight();

/// Measures a batch; returns a bit for each pair that needs the exact test. Without AVX-512: all
/// bits.
uint64_t measure_by_eight(const Pose& X_AB, DistanceBatch& batch);

}  // namespace haptic
