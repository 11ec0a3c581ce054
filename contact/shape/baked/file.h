// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/baked/block.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// Contents of a baked file; views into its bytes. `eye_…`: the mesh for display.
struct BakedContent {
  MeshShape shape;
  std::span<const Vec3> eye_vertices;
  std::span<const Vec3> eye_normals;
  std::span<const Triangle> eye_triangles;
  std::span<const char> notes;  // text from baking
};

std::vector<std::byte> write_baked(const BakedContent& content, uint64_t key);

/// Views a block in place; nothing is parsed or copied. Checks magic, version, key, size, checksum,
/// offsets, that every index is in range, that the trees are trees of at most kMaxTreeDepth and
/// kMaxPatchDepth, and that every look-up in the grid ends: queries on a checked file cannot leave
/// the arrays. `bytes` must be 8-byte aligned. Throws BakedFileError.
BakedContent view_baked(std::span<const std::byte> bytes, uint64_t key,
                        const RunBoth& run_both = run_in_turn);

}  // namespace haptic
