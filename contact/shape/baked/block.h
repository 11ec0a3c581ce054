// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "proto/math/assert.h"

namespace haptic {

/// The bytes are of another kind or version, or damaged.
struct BakedFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws BakedFileError unless `holds`.
inline void require_baked(bool holds, const char* what) {
  if (!holds) throw BakedFileError(what);
}

/// Incremented with every change of a layout or of the baking: older caches are not read.
inline constexpr uint32_t kBakeVersion = 7;

enum class BakedKind : uint32_t { kShape = 1, kVolume = 2, kPieces = 3 };

inline constexpr size_t kMostBakedArrays = 24;  // bounds the header of a file

/// Arrays in one block of bytes, in their layout in memory; views.
struct BakedBlock {
  std::span<const std::byte> bytes;
  std::array<std::span<const std::byte>, kMostBakedArrays> arrays;
};

/// 64-bit hash (XXH3) for content keys and checksums: detects accidents, not forgery.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// One block: header (magic, version, kind, key, checksums) and the arrays, 64-byte aligned, at
/// most kMostBakedArrays. Native byte order: a cache, not an exchange format.
std::vector<std::byte> write_block(BakedKind kind, uint64_t key,
                                   std::span<const std::span<const std::byte>> arrays);

/// Views a block in place: checks magic, version, kind, key, size, number and positions of the
/// arrays, but not the checksums. `bytes` must be 8-byte aligned. Throws BakedFileError.
BakedBlock view_block(std::span<const std::byte> bytes, BakedKind kind, uint64_t key,
                      size_t n_arrays);

/// Verifies the checksum of the first half of the block (0) or the second (1), so that two threads
/// can share the work. Throws BakedFileError.
void check_half(const BakedBlock& block, size_t half);

/// An array of a block as a typed view. Throws BakedFileError if it is not a whole number of
/// elements.
template <class T>
std::span<const T> view_array(std::span<const std::byte> bytes) {
  HAPTIC_ASSERT(reinterpret_cast<uintptr_t>(bytes.data()) % alignof(T) == 0);
  require_baked(bytes.size() % sizeof(T) == 0, "an array of another type");
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

}  // namespace haptic
