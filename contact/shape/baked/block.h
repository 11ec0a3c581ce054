// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace haptic {

/// Bytes that are not what was asked for, of another version, or damaged.
struct BakedFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws BakedFileError where it does not hold.
inline void require_baked(bool holds, const char* what) {
  if (!holds) throw BakedFileError(what);
}

/// Bumped with every change of a layout or of what baking does: old caches are not read.
inline constexpr uint32_t kBakeVersion = 5;

/// What a block holds.
enum class BakedKind : uint32_t { kShape = 1, kVolume = 2 };

inline constexpr size_t kMostBakedArrays = 24;

/// Arrays in one block of bytes, as they lie in memory; views.
struct BakedBlock {
  std::span<const std::byte> bytes;
  std::array<std::span<const std::byte>, kMostBakedArrays> arrays;
};

/// 64-bit hash (XXH3) for content keys and checksums: finds accidents, not forgers.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// One block: header (magic, version, kind, key, checksums) and the arrays, 64-byte aligned, at
/// most kMostBakedArrays. Native byte order: a cache, not an exchange format.
std::vector<std::byte> write_block(BakedKind kind, uint64_t key,
                                   std::span<const std::span<const std::byte>> arrays);

/// Views a block in place: checks magic, version, kind, key, size, number and places of the
/// arrays, not the checksums. `bytes` must be 8-byte aligned. Throws BakedFileError.
BakedBlock view_block(std::span<const std::byte> bytes, BakedKind kind, uint64_t key,
                      size_t n_arrays);

/// Checks a checksum, that of the first half of the block (0) or the second (1), so that two
/// threads can share the work. Throws BakedFileError.
void check_half(const BakedBlock& block, size_t half);

/// An array of a block as what it is. Throws BakedFileError where it is no whole number of them.
template <class T>
std::span<const T> view_array(std::span<const std::byte> bytes) {
  require_baked(bytes.size() % sizeof(T) == 0, "an array of another type");
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

}  // namespace haptic
