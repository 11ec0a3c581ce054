// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contact/bake/bake.h"
#include "contact/shape/convex/piece_tree.h"

namespace haptic {

/// Convex pieces of a body and their levels of detail, kept alive by their storage (a mapped cache
/// file or memory).
struct BakedPieces {
  PieceTree tree;
  bool from_cache = false;
  double time = 0;                 // of baking in this run [s]
  std::vector<std::string> lines;  // about the cache, for people
  std::shared_ptr<const void> storage;
};

/// The pieces of an object or a tool; from the cache folder if they were baked before (key:
/// triangles, version).
BakedPieces bake_pieces(const BakedShape& shape, const BakeProgress& progress = {});

}  // namespace haptic
