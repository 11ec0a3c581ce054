// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/triangle/triangle_distance.h"

namespace haptic {

/// Whether the processor has AVX-512, and this build does not watch memory.
bool can_measure_by_eight();

/// All of a batch but for what only the exact test can tell (measure): a bit for each of those.
/// Where it cannot, all of them.
uint64_t measure_by_eight(const Pose& X_AB, DistanceBatch& batch);

}  // namespace haptic
