// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/voxel_scan.h"

#include <algorithm>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "contact/query/volume/scalar_scan.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

#if defined(__x86_64__)
/// For each set of eight lanes, their indices in order, one byte each.
constexpr std::array<uint64_t, 256> kLanesOf = [] {
  std::array<uint64_t, 256> table{};
  for (size_t set = 0; set < table.size(); ++set) {
    uint64_t place = 0;
    for (uint64_t lane = 0; lane < 8; ++lane) {
      if ((set >> lane & 1) != 0) table[set] |= lane << 8 * place++;
    }
  }
  return table;
}();

/// A block of points between address computation and look-up.
struct Block {
  static constexpr uint32_t kPoints = 64;
  alignas(32) std::array<uint32_t, kPoints> place;  // of the brick in the index
  alignas(32) std::array<uint32_t, kPoints> word;   // index of the word in the brick, then the word
  alignas(32) std::array<uint32_t, kPoints> shift;  // of the voxel in the word; 32: outside
};

/// Eight points at a time for the arithmetic; the loads are scalar: they keep more misses in flight
/// than gathers, and are not affected by the microcode mitigations of gathers.
class LaneScan {
 public:
  [[gnu::target("avx2"), gnu::always_inline]] LaneScan(const Voxmap& map, const Pointshell& shell,
                                                       const ShellInVoxels& at)
      : map_(map),
        shell_(shell),
        // x and y of a brick are multiplied as 16-bit numbers: 4096 voxels per side fit
        row_(_mm256_set1_epi32(map.bricks[0] << 16 | 1)),
        layer_(_mm256_set1_epi32(map.bricks[0] * map.bricks[1])) {
    const Limits limits = limits_of(map.bricks, kBrickSide);
    for (size_t k = 0; k < 9; ++k) rotation_[k] = _mm256_set1_ps(at.rotation[k]);
    for (size_t k = 0; k < 3; ++k) {
      translation_[k] = _mm256_set1_ps(at.translation[k]);
      limits_[k] = _mm256_set1_ps(limits[k]);
    }
  }

  /// Runs as long as there is room for a block. Sets `i` to the next point.
  [[gnu::target("avx2,popcnt"), gnu::always_inline]] size_t run(uint32_t& i, uint32_t end,
                                                                std::span<VoxelHit> hits,
                                                                size_t n) const {
    Block block;
    while (i + 8 <= end && n + Block::kPoints <= hits.size()) {
      const uint32_t count = std::min(Block::kPoints, (end - i) & ~7u);
      for (uint32_t j = 0; j < count; j += 8) locate(i + j, j, block);
      load(count, block);
      for (uint32_t j = 0; j < count; j += 8) n = take(i + j, j, block, hits, n);
      i += count;
    }
    return n;
  }

 private:
  [[gnu::target("avx2"), gnu::always_inline]] static void store(std::array<uint32_t, 64>& to,
                                                                uint32_t j, __m256i lanes) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(&to[j]), lanes);
  }
  [[gnu::target("avx2"), gnu::always_inline]] static __m256i read(
      const std::array<uint32_t, 64>& from, uint32_t j) {
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(&from[j]));
  }

  [[gnu::target("avx2"), gnu::always_inline]] __m256 coordinates(size_t row, __m256 x, __m256 y,
                                                                 __m256 z) const {
    const __m256* r = &rotation_[3 * row];
    return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(r[0], x), _mm256_mul_ps(r[1], y)),
                         _mm256_add_ps(_mm256_mul_ps(r[2], z), translation_[row]));
  }

  /// Addresses of the points i … i + 7, stored from index j of the block on.
  [[gnu::target("avx2"), gnu::always_inline]] void locate(uint32_t i, uint32_t j,
                                                          Block& block) const {
    const __m256 x = _mm256_loadu_ps(&shell_.x[i]), y = _mm256_loadu_ps(&shell_.y[i]),
                 z = _mm256_loadu_ps(&shell_.z[i]);
    __m256 inside = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    __m256i voxel[3];
    for (size_t k = 0; k < 3; ++k) {
      const __m256 q = coordinates(k, x, y, z);
      inside = _mm256_and_ps(inside, _mm256_cmp_ps(q, _mm256_setzero_ps(), _CMP_GE_OQ));
      inside = _mm256_and_ps(inside, _mm256_cmp_ps(q, limits_[k], _CMP_LT_OQ));
      voxel[k] = _mm256_cvttps_epi32(q);
    }
    const __m256i mask = _mm256_castps_si256(inside);
    // points outside read the first brick, and are masked by their shift
    store(block.place, j, _mm256_and_si256(mask, place_of(voxel)));
    const __m256i seven = _mm256_set1_epi32(kBrickSide - 1);
    const __m256i in_x = _mm256_and_si256(voxel[0], seven),
                  in_y = _mm256_and_si256(voxel[1], seven),
                  in_z = _mm256_and_si256(voxel[2], seven);
    // four words per layer, two rows of x in a word
    store(block.word, j, _mm256_add_epi32(_mm256_slli_epi32(in_z, 2), _mm256_srli_epi32(in_y, 1)));
    const __m256i odd = _mm256_and_si256(in_y, _mm256_set1_epi32(1));
    const __m256i shift =
        _mm256_slli_epi32(_mm256_add_epi32(_mm256_slli_epi32(odd, kBrickBits), in_x), 1);
    store(block.shift, j, _mm256_or_si256(shift, _mm256_andnot_si256(mask, _mm256_set1_epi32(32))));
  }

  /// Index of the brick of each point.
  [[gnu::target("avx2"), gnu::always_inline]] __m256i place_of(const __m256i (&voxel)[3]) const {
    const __m256i x = _mm256_srai_epi32(voxel[0], kBrickBits),
                  y = _mm256_srai_epi32(voxel[1], kBrickBits),
                  z = _mm256_srai_epi32(voxel[2], kBrickBits);
    const __m256i in_layer = _mm256_madd_epi16(_mm256_or_si256(x, _mm256_slli_epi32(y, 16)), row_);
    return _mm256_add_epi32(_mm256_mullo_epi32(z, layer_), in_layer);
  }

  [[gnu::always_inline]] void load(uint32_t count, Block& block) const {
    const uint32_t* const index = map_.index.data();
    const VoxelBrick* const bricks = map_.data.data();
#pragma GCC unroll 8
    for (uint32_t j = 0; j < count; ++j) {
      block.word[j] = bricks[index[block.place[j]]].words[block.word[j]];
    }
  }

  /// Compacts the points of eight that are not free, without branches.
  [[gnu::target("avx2,popcnt"), gnu::always_inline]] size_t take(uint32_t i, uint32_t j,
                                                                 const Block& block,
                                                                 std::span<VoxelHit> hits,
                                                                 size_t n) const {
    // a shift by 32 leaves nothing
    const __m256i found = _mm256_and_si256(
        _mm256_srlv_epi32(read(block.word, j), read(block.shift, j)), _mm256_set1_epi32(3));
    const __m256i is_free = _mm256_cmpeq_epi32(found, _mm256_setzero_si256());
    const auto taken =
        static_cast<unsigned>(~_mm256_movemask_ps(_mm256_castsi256_ps(is_free))) & 0xffu;
    const __m256i point = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(i)),
                                           _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256i packed = _mm256_or_si256(_mm256_slli_epi32(point, 2), found);
    const __m256i order =
        _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<int64_t>(kLanesOf[taken])));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(hits.data() + n),
                        _mm256_permutevar8x32_epi32(packed, order));
    return n + static_cast<size_t>(__builtin_popcount(taken));
  }

  const Voxmap& map_;
  const Pointshell& shell_;
  __m256i row_, layer_;
  __m256 rotation_[9], translation_[3], limits_[3];
};
/// A function of its own, so that the constants stay in registers.
[[gnu::target("avx2,popcnt")]] size_t scan_lanes(const Voxmap& map, const Pointshell& shell,
                                                 const ShellInVoxels& at, uint32_t& i, uint32_t end,
                                                 std::span<VoxelHit> hits, size_t n) {
  return LaneScan(map, shell, at).run(i, end, hits, n);
}
#endif

}  // namespace

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
  HAPTIC_ASSERT(size_t{first} + count <= shell.x.size() && n <= hits.size());
  if (map.data.empty()) return n;
  uint32_t i = first;
#if defined(__x86_64__)
  if (path == ScanPath::kLanes) n = scan_lanes(map, shell, at, i, first + count, hits, n);
#endif
  // the rest
  return scan_one_by_one(map, limits_of(map.bricks, kBrickSide), shell, at, i, first + count, hits,
                         n);
}

}  // namespace haptic
