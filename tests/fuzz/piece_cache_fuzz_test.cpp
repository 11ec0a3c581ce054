// SPDX-License-Identifier: GPL-3.0-or-later
// Arbitrary cache files of convex pieces, even with a correct checksum: each is refused, or every
// query on its content stays within the arrays and ends.
#include <catch2/catch.hpp>

#include "contact/bake/convex/piece_tree.h"
#include "contact/query/convex/piece_front.h"
#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/baked/pieces.h"
#include "tests/fuzz/cache_damage.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {
namespace {

using namespace cache_damage;

constexpr unsigned kSeconds = kSlowdown > 1 ? 20 : 2;  // CPU time limit of an input [s]
constexpr size_t kPieceArrays = 7;

/// Of a body with a concave edge: two pieces and their hull.
Bytes piece_block() {
  const MeshShapeData shape = build_shape(make_l_shape(1, 0.5));
  return write_pieces(build_piece_tree(shape.mesh.view()).view(), kKey);
}

void ask(const PieceTree& tree, Random& random) {
  static const MeshShapeData other = build_shape(make_icosphere(0.3, 1));
  static const PieceTreeData ball = build_piece_tree(other.mesh.view());
  constexpr uint32_t kNodes = 64;
  PieceFront front(tree, ball.view(), kNodes), reversed(ball.view(), tree, kNodes);
  RefineOptions options;
  options.tolerance = 0.1;
  options.budget = kNodes;
  for (int i = 0; i < 4; ++i) {
    Pose X;
    X.p = point_near(random);
    options.threshold = i % 2 == 0 ? 0 : 1e-3;
    front.update(X, options);
    reversed.update(X, options);
  }
}

bool are_pieces_taken(const Bytes& bytes, Random& random) {
  try {
    ask(view_pieces(bytes, kKey), random);
    return true;
  } catch (const BakedFileError&) {
    return false;
  }
}

}  // namespace

TEST_CASE("fuzz: cache of convex pieces with numbers changed is refused, or its queries end") {
  const Bytes good = piece_block();
  FuzzMeter meter("fuzz: cache of pieces, right checksum", 5, kSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    return are_pieces_taken(damaged_inside(good, BakedKind::kPieces, kPieceArrays, random), random);
  });
  if (!meter.is_whole()) return;
  CHECK(meter.accepted() > 0);
  CHECK(meter.refused() > 0);
}

TEST_CASE("fuzz: cache file of convex pieces that is not what was written is refused") {
  const Bytes good = piece_block();
  FuzzMeter meter("fuzz: cache file of pieces damaged", 6, kSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    return are_pieces_taken(damaged_outside(good, random), random);
  });
  CHECK(meter.accepted() == 0);
}

}  // namespace haptic::test
