// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/field_lanes.h"

#include <algorithm>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "proto/math/assert.h"

namespace haptic {
namespace {

void look_up_one(const DistanceField& field, const Pose& X_OT, size_t i, FieldBatch& batch) {
  const Vec3 p_T{static_cast<double>(batch.x[i]), static_cast<double>(batch.y[i]),
                 static_cast<double>(batch.z[i])};
  const FieldDistance at = sample_distance(field, X_OT * p_T);
  batch.distance[i] = at.distance;
  batch.near |= uint64_t{at.is_near} << i;
}

#if defined(__x86_64__)
constexpr unsigned kAllFour = 0xf;

struct Lanes3 {
  __m256d x, y, z;
};

[[gnu::target("avx2"), gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

[[gnu::target("avx2"), gnu::always_inline]] inline Lanes3 everywhere(const Vec3& v) {
  return {_mm256_set1_pd(v.x), _mm256_set1_pd(v.y), _mm256_set1_pd(v.z)};
}

/// Cells of four points along one axis.
struct Along {
  __m256d share;   // place within the cell, in cells
  __m128i cell;    // from the lower border of the field
  __m256d inside;  // a mask
};

[[gnu::target("avx2"), gnu::always_inline]] inline Along along_axis(__m256d q, double last) {
  const __m256d zero = _mm256_setzero_pd();
  const __m256d inside = _mm256_and_pd(_mm256_cmp_pd(q, zero, _CMP_GE_OQ),
                                       _mm256_cmp_pd(q, _mm256_set1_pd(last), _CMP_LE_OQ));
  // points outside, and not-a-number, are clamped to the border: gathers stay within the field
  const __m256d kept = _mm256_min_pd(_mm256_max_pd(q, zero), _mm256_set1_pd(last - 1));
  const __m128i cell = _mm256_cvttpd_epi32(kept);
  return {q - _mm256_cvtepi32_pd(cell), cell, inside};
}

/// Interpolates along x at one corner of the cell; the two neighbours are adjacent. In units of the
/// band.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256d edge(const FieldBrick* bricks,
                                                                __m256i offset, int node,
                                                                __m256d x) {
  const auto* base = reinterpret_cast<const int*>(bricks->nodes.data() + node);
  const __m128i both = _mm256_i64gather_epi32(base, offset, 1);
  const __m128i low = _mm_srai_epi32(_mm_slli_epi32(both, 16), 16);
  const __m128i rise = _mm_sub_epi32(_mm_srai_epi32(both, 16), low);
  return _mm256_cvtepi32_pd(low) + x * _mm256_cvtepi32_pd(rise);
}

/// Samples points i to i + 3, as far as they exist.
[[gnu::target("avx2")]] void look_up_four(const DistanceField& field, const Pose& X_OT, size_t i,
                                          FieldBatch& batch) {
  const Lanes3 u = everywhere(X_OT.q.vector()), p = everywhere(X_OT.p);
  const Lanes3 a{_mm256_cvtps_pd(_mm_loadu_ps(&batch.x[i])),
                 _mm256_cvtps_pd(_mm_loadu_ps(&batch.y[i])),
                 _mm256_cvtps_pd(_mm_loadu_ps(&batch.z[i]))};
  // X_OT * p_T, in the same order of operations
  const __m256d two = _mm256_set1_pd(2), w = _mm256_set1_pd(X_OT.q.w);
  Lanes3 t = cross(u, a);
  t = {two * t.x, two * t.y, two * t.z};
  const Lanes3 c = cross(u, t);
  const __m256d per_metre = _mm256_set1_pd(1 / field.cell);
  const Lanes3 lower = everywhere(field.lower_O);
  const auto last = [&](size_t k) { return static_cast<double>(field.bricks[k] * kFieldSide); };
  const Along x = along_axis(per_metre * ((p.x + ((a.x + w * t.x) + c.x)) - lower.x), last(0));
  const Along y = along_axis(per_metre * ((p.y + ((a.y + w * t.y) + c.y)) - lower.y), last(1));
  const Along z = along_axis(per_metre * ((p.z + ((a.z + w * t.z) + c.z)) - lower.z), last(2));

  const auto place = [](__m128i cell) { return _mm_srli_epi32(cell, 3); };
  const auto within = [](__m128i cell) { return _mm_and_si128(cell, _mm_set1_epi32(7)); };
  static_assert(kFieldSide == 8);
  const __m128i row =
      _mm_add_epi32(_mm_mullo_epi32(place(z.cell), _mm_set1_epi32(field.bricks[1])), place(y.cell));
  const __m128i number =
      _mm_add_epi32(_mm_mullo_epi32(row, _mm_set1_epi32(field.bricks[0])), place(x.cell));
  const __m128i brick =
      _mm_i32gather_epi32(reinterpret_cast<const int*>(field.index.data()), number, 4);
  const __m128i far = _mm_cmpeq_epi32(brick, _mm_set1_epi32(-1));
  const int is_far = _mm_movemask_ps(_mm_castsi128_ps(far));
  const int is_inside =
      _mm256_movemask_pd(_mm256_and_pd(_mm256_and_pd(x.inside, y.inside), z.inside));
  const auto near = static_cast<unsigned>(is_inside & ~is_far);

  const __m128i node = _mm_add_epi32(
      _mm_add_epi32(_mm_mullo_epi32(within(z.cell), _mm_set1_epi32(kFieldNodes * kFieldNodes)),
                    _mm_mullo_epi32(within(y.cell), _mm_set1_epi32(kFieldNodes))),
      within(x.cell));
  const __m256i offset =
      _mm256_add_epi64(_mm256_mul_epu32(_mm256_cvtepu32_epi64(_mm_andnot_si128(far, brick)),
                                        _mm256_set1_epi64x(sizeof(FieldBrick))),
                       _mm256_cvtepu32_epi64(_mm_slli_epi32(node, 1)));
  constexpr int kY = kFieldNodes, kZ = kFieldNodes * kFieldNodes;
  const FieldBrick* data = field.data.data();
  const __m256d a00 = edge(data, offset, 0, x.share), a10 = edge(data, offset, kY, x.share);
  const __m256d a01 = edge(data, offset, kZ, x.share), a11 = edge(data, offset, kY + kZ, x.share);
  const __m256d b0 = a00 + y.share * (a10 - a00), b1 = a01 + y.share * (a11 - a01);
  _mm256_storeu_pd(&batch.distance[i],
                   _mm256_set1_pd(field.band / kFieldUnits) * (b0 + z.share * (b1 - b0)));
  batch.near |= uint64_t{near} << i;
  if (near == kAllFour) return;
  for (size_t k = i; k < std::min(i + 4, batch.n); ++k) {
    if ((near >> (k - i) & 1) == 0) look_up_one(field, X_OT, k, batch);
  }
}
#endif

}  // namespace

void look_up_one_by_one(const DistanceField& field, const Pose& X_OT, FieldBatch& batch) {
  batch.near = 0;
  for (size_t i = 0; i < batch.n; ++i) look_up_one(field, X_OT, i, batch);
}

void look_up(const DistanceField& field, const Pose& X_OT, FieldBatch& batch) {
  HAPTIC_ASSERT(batch.n <= FieldBatch::kRoom && field.cell > 0);
#if defined(__x86_64__)
  static const bool has_lanes = __builtin_cpu_supports("avx2") != 0;
  if (has_lanes && !field.data.empty()) {
    batch.near = 0;
    for (size_t i = 0; i < batch.n; i += 4) look_up_four(field, X_OT, i, batch);
    return;
  }
#endif
  look_up_one_by_one(field, X_OT, batch);
}

}  // namespace haptic
