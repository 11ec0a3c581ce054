// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "contact/bake/convex/triangle_boxes.h"

namespace haptic {

/// Neighbouring pieces: pairs, each once.
using PiecePairs = std::vector<std::pair<uint32_t, uint32_t>>;

/// Merges pieces pairwise, those whose common box is smallest first, until at most `target` groups
/// remain. Neighbours merge; where there are none left, those near each other along a Morton curve.
/// The members of each group, lowest first; groups in the order of their lowest members.
std::vector<std::vector<uint32_t>> group_pieces(const std::vector<Box>& boxes,
                                                const PiecePairs& neighbours, size_t target);

}  // namespace haptic
