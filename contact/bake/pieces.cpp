// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/pieces.h"

#include <string_view>

#include "contact/bake/cache.h"
#include "contact/bake/convex/piece_tree.h"
#include "contact/bake/grid.h"
#include "contact/shape/baked/pieces.h"

namespace haptic {
namespace {

// incremented with every change of how pieces are made: older caches are not read
constexpr std::string_view kPieceVersion = "pieces 2";

}  // namespace

BakedPieces bake_pieces(const BakedShape& shape, const BakeProgress& progress) {
  const TriangleMesh& mesh = shape.shape.mesh;
  const uint64_t key = mesh_key(mesh, kPieceVersion);
  BakedPieces pieces;
  CacheUse use = use_cached(
      key,
      [&](const MappedFile& file) {
        pieces.tree = view_pieces(file.bytes, key, run_on_two_threads);
        pieces.storage = file.storage;
      },
      [&] {
        const auto tell = [&](double share) {
          if (progress) progress("convex pieces", share);
        };
        return write_pieces(build_piece_tree(mesh, tell).view(), key);
      });
  pieces.from_cache = use.from_cache;
  pieces.time = use.make_time;
  pieces.lines = std::move(use.lines);
  return pieces;
}

}  // namespace haptic
