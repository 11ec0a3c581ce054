// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/voxel_scan.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace haptic {
namespace {

struct Scan {
  const Voxmap& map;
  const Pointshell& shell;
  const ShellInVoxels& at;
  std::span<VoxelHit> hits;

  /// One coordinate, in the order of operations of the lanes.
  float coordinate(size_t row, uint32_t i) const {
    const float* r = &at.rotation[3 * row];
    return (r[0] * shell.x[i] + r[1] * shell.y[i]) + (r[2] * shell.z[i] + at.translation[row]);
  }

  size_t one_by_one(uint32_t first, uint32_t end, size_t n) const {
    for (uint32_t i = first; i < end; ++i) {
      VoxelIndex voxel{};
      bool inside = true;
      for (size_t k = 0; k < 3; ++k) {
        const float q = coordinate(k, i);
        inside &= q >= 0 && q < static_cast<float>(map.bricks[k] * kBrickSide);
        if (inside) voxel[k] = static_cast<int32_t>(q);
      }
      const Voxel found = inside ? map.at(voxel) : Voxel::kFree;
      if (found == Voxel::kFree || n == hits.size()) continue;
      hits[n++] = {i << 2 | static_cast<uint32_t>(found)};
    }
    return n;
  }

#if defined(__x86_64__)
  [[gnu::target("avx2")]] __m256 lanes_of(size_t row, uint32_t i) const {
    const auto times = [&](size_t k, const float* values) __attribute__((target("avx2"))) {
      return _mm256_mul_ps(_mm256_set1_ps(at.rotation[3 * row + k]), _mm256_loadu_ps(values + i));
    };
    return _mm256_add_ps(
        _mm256_add_ps(times(0, shell.x.data()), times(1, shell.y.data())),
        _mm256_add_ps(times(2, shell.z.data()), _mm256_set1_ps(at.translation[row])));
  }

  [[gnu::target("avx2")]] size_t by_lanes(uint32_t first, uint32_t end, size_t n) const {
    const __m256 zero = _mm256_setzero_ps();
    __m256 limit[3];
    for (size_t k = 0; k < 3; ++k) {
      limit[k] = _mm256_set1_ps(static_cast<float>(map.bricks[k] * kBrickSide));
    }
    const __m256i row_of_bricks = _mm256_set1_epi32(map.bricks[0]);
    const __m256i rows_of_bricks = _mm256_set1_epi32(map.bricks[1]);
    const int* const index = reinterpret_cast<const int*>(map.index.data());
    const int* const words = reinterpret_cast<const int*>(map.data.data());
    uint32_t i = first;
    for (; i + 8 <= end && n + 8 <= hits.size(); i += 8) {
      __m256 inside = _mm256_cmp_ps(zero, zero, _CMP_EQ_OQ);
      __m256i voxel[3];
      for (size_t k = 0; k < 3; ++k) {
        const __m256 q = lanes_of(k, i);
        inside = _mm256_and_ps(inside, _mm256_cmp_ps(q, zero, _CMP_GE_OQ));
        inside = _mm256_and_ps(inside, _mm256_cmp_ps(q, limit[k], _CMP_LT_OQ));
        voxel[k] = _mm256_cvttps_epi32(q);
      }
      const __m256i mask = _mm256_castps_si256(inside);
      const auto brick = [&](size_t k) __attribute__((target("avx2"))) {
        return _mm256_srai_epi32(voxel[k], kBrickBits);
      };
      __m256i place = _mm256_add_epi32(_mm256_mullo_epi32(brick(2), rows_of_bricks), brick(1));
      place = _mm256_add_epi32(_mm256_mullo_epi32(place, row_of_bricks), brick(0));
      const __m256i none = _mm256_setzero_si256();
      const __m256i number = _mm256_mask_i32gather_epi32(none, index, place, mask, 4);
      const __m256i seven = _mm256_set1_epi32(kBrickSide - 1);
      const __m256i x = _mm256_and_si256(voxel[0], seven), y = _mm256_and_si256(voxel[1], seven),
                    z = _mm256_and_si256(voxel[2], seven);
      // 32 words a brick, four a layer, two rows of x in a word
      const __m256i word_at =
          _mm256_add_epi32(_mm256_slli_epi32(number, 5),
                           _mm256_add_epi32(_mm256_slli_epi32(z, 2), _mm256_srli_epi32(y, 1)));
      const __m256i word = _mm256_mask_i32gather_epi32(none, words, word_at, mask, 4);
      const __m256i odd = _mm256_and_si256(y, _mm256_set1_epi32(1));
      const __m256i shift =
          _mm256_slli_epi32(_mm256_add_epi32(_mm256_slli_epi32(odd, kBrickBits), x), 1);
      const __m256i found = _mm256_and_si256(_mm256_srlv_epi32(word, shift), _mm256_set1_epi32(3));
      const __m256i is_free = _mm256_cmpeq_epi32(found, none);
      auto taken = static_cast<unsigned>(~_mm256_movemask_ps(_mm256_castsi256_ps(is_free))) & 0xffu;
      if (taken == 0) continue;
      alignas(32) std::array<uint32_t, 8> kinds;
      _mm256_store_si256(reinterpret_cast<__m256i*>(kinds.data()), found);
      for (; taken != 0; taken &= taken - 1) {
        const auto lane = static_cast<uint32_t>(__builtin_ctz(taken));
        hits[n++] = {(i + lane) << 2 | kinds[lane]};
      }
    }
    return one_by_one(i, end, n);
  }
#endif
};

}  // namespace

ShellInVoxels shell_in_voxels(const Voxmap& map, const Pose& X_OT) {
  ShellInVoxels at;
  const Mat3 R = to_matrix(X_OT.q);
  const Vec3 t = map.voxels_per_metre * (X_OT.p - map.lower_O);
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      at.rotation[3 * i + j] =
          static_cast<float>(map.voxels_per_metre * R.row[i][static_cast<int>(j)]);
    }
    at.translation[i] = static_cast<float>(t[static_cast<int>(i)]);
  }
  return at;
}

ScanPath fastest_scan() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") ? ScanPath::kLanes : ScanPath::kScalar;
#else
  return ScanPath::kScalar;
#endif
}

size_t scan_voxels(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                   uint32_t first, uint32_t count, ScanPath path, std::span<VoxelHit> hits,
                   size_t n) {
  if (map.data.empty()) return n;
  const Scan scan{map, shell, at, hits};
#if defined(__x86_64__)
  if (path == ScanPath::kLanes) return scan.by_lanes(first, first + count, n);
#endif
  return scan.one_by_one(first, first + count, n);
}

}  // namespace haptic
