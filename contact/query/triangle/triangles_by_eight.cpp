// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/triangles_by_eight.h"

#include "contact/query/simd/lanes8.h"

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// for the whole file: g++ 12 splits vectors of eight when it inlines them into a function with
// another target
#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq")
#include "contact/query/triangle/triangle_lanes.h"

namespace haptic {

using Double8 [[gnu::vector_size(64)]] = double;

bool can_measure_by_eight() {
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
         __builtin_cpu_supports("avx512dq") != 0;
}

uint64_t measure_by_eight(const Pose& X_AB, DistanceBatch& batch) {
  return triangle_lanes::measure_lanes<Double8>(X_AB, batch);
}

}  // namespace haptic
#pragma GCC pop_options
#else
namespace haptic {

bool can_measure_by_eight() {
  return false;
}

uint64_t measure_by_eight(const Pose&, DistanceBatch&) {
  return ~uint64_t{0};
}

}  // namespace haptic
#endif
