// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "contact/shape/mesh_shape.h"

namespace haptic {

/// Bytes that are not a baked shape of this version, or not the one asked for, or damaged.
struct BakedFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a baked file holds; views into its bytes.
struct BakedContent {
  MeshShape shape;
  std::span<const Vec3> eye_vertices;
  std::span<const Vec3> eye_normals;
  std::span<const Triangle> eye_triangles;
  std::span<const char> notes;  // text of whoever baked it
};

/// Bumped with every change of the layout or of what baking does: old caches are not read.
inline constexpr uint32_t kBakeVersion = 3;

/// 64-bit hash (XXH3) for content keys and checksums: finds accidents, not forgers.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// One block: header (magic, version, sizes, key, checksums) and the arrays as they lie
/// in memory, 64-byte aligned. Native byte order: a cache, not an exchange format.
std::vector<std::byte> write_baked(const BakedContent& content, uint64_t key);

/// Views a block in place; nothing is parsed or copied. Checks magic, version, key, size, checksum,
/// offsets, that every index is in range, that the trees are trees of at most kMaxTreeDepth and
/// kMaxPatchDepth and that every search in the grid ends: a query on what passed cannot leave the
/// arrays. `bytes` must be 8-byte aligned. Throws BakedFileError.
BakedContent view_baked(std::span<const std::byte> bytes, uint64_t key,
                        const RunBoth& run_both = run_in_turn);

}  // namespace haptic
