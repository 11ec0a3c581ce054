// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/baked/block.h"
#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/tree/obb_tree.h"

namespace haptic {

std::vector<std::byte> write_pieces(const PieceTree& tree, uint64_t key);

/// Views a block in place; nothing is parsed or copied. Checks that the pieces are a tree whose
/// children follow their parents, that each hull is a polyhedron with finite numbers, and that
/// every triangle has its leaf: queries on a checked file cannot leave the arrays. That hulls are
/// convex and bounds are true is not checked. `bytes` must be 8-byte aligned. Throws
/// BakedFileError.
PieceTree view_pieces(std::span<const std::byte> bytes, uint64_t key,
                      const RunBoth& run_both = run_in_turn);

}  // namespace haptic
