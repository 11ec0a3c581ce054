// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/voxel_ceiling.h"

#include <array>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace haptic {
namespace {

uint32_t gather_from(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                     size_t first) {
  uint32_t sum = 0;
  const auto* words = reinterpret_cast<const uint32_t*>(map.data.data());
  for (size_t i = first; i < shell.x.size(); ++i) {
    std::array<int, 3> v;
    for (size_t k = 0; k < 3; ++k) {
      const float* r = &at.rotation[3 * k];
      v[k] = static_cast<int>(r[0] * shell.x[i] + r[1] * shell.y[i] + r[2] * shell.z[i] +
                              at.translation[k]);
    }
    const int place = ((v[2] >> 3) * map.bricks[1] + (v[1] >> 3)) * map.bricks[0] + (v[0] >> 3);
    const uint32_t brick = map.index[static_cast<size_t>(place)];
    sum += words[brick * 32 + static_cast<uint32_t>((v[2] & 7) << 2 | (v[1] & 7) >> 1)];
  }
  return sum;
}

#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] uint32_t gather_lanes(const Voxmap& map, const Pointshell& shell,
                                                  const ShellInVoxels& at) {
  __m256 r[9], t[3];
  for (size_t k = 0; k < 9; ++k) r[k] = _mm256_set1_ps(at.rotation[k]);
  for (size_t k = 0; k < 3; ++k) t[k] = _mm256_set1_ps(at.translation[k]);
  const __m256i row = _mm256_set1_epi32(map.bricks[0]),
                layer = _mm256_set1_epi32(map.bricks[0] * map.bricks[1]),
                seven = _mm256_set1_epi32(7);
  const int* const index = reinterpret_cast<const int*>(map.index.data());
  const int* const words = reinterpret_cast<const int*>(map.data.data());
  __m256i sum = _mm256_setzero_si256();
  size_t i = 0;
  for (; i + 8 <= shell.x.size(); i += 8) {
    const __m256 x = _mm256_loadu_ps(&shell.x[i]), y = _mm256_loadu_ps(&shell.y[i]),
                 z = _mm256_loadu_ps(&shell.z[i]);
    __m256i v[3], brick[3];
    for (size_t k = 0; k < 3; ++k) {
      v[k] = _mm256_cvttps_epi32(_mm256_fmadd_ps(
          r[3 * k], x, _mm256_fmadd_ps(r[3 * k + 1], y, _mm256_fmadd_ps(r[3 * k + 2], z, t[k]))));
      brick[k] = _mm256_srli_epi32(v[k], 3);
    }
    const __m256i place =
        _mm256_add_epi32(_mm256_mullo_epi32(brick[2], layer),
                         _mm256_add_epi32(_mm256_mullo_epi32(brick[1], row), brick[0]));
    const __m256i number = _mm256_i32gather_epi32(index, place, 4);
    const __m256i within = _mm256_add_epi32(_mm256_slli_epi32(_mm256_and_si256(v[2], seven), 2),
                                            _mm256_srli_epi32(_mm256_and_si256(v[1], seven), 1));
    const __m256i at_word = _mm256_add_epi32(_mm256_slli_epi32(number, 5), within);
    sum = _mm256_add_epi32(sum, _mm256_i32gather_epi32(words, at_word, 4));
  }
  alignas(32) std::array<uint32_t, 8> sums;
  _mm256_store_si256(reinterpret_cast<__m256i*>(sums.data()), sum);
  uint32_t total = gather_from(map, shell, at, i);
  for (const uint32_t s : sums) total += s;
  return total;
}
#endif

}  // namespace

uint32_t gather_bare(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                     ScanPath path) {
#if defined(__x86_64__)
  if (path == ScanPath::kLanes) return gather_lanes(map, shell, at);
#endif
  return gather_from(map, shell, at, 0);
}

}  // namespace haptic
