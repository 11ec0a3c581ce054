// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <random>
#include <string>

#include "contact/bake/read.h"

namespace haptic::test {

/// The bytes of a mesh file under a name that tells its format.
struct MeshInput {
  std::string name;
  std::string bytes;
};

/// One to three polygons of 3 to 8 corners anywhere: bent, crossing, degenerate, of any size.
MeshInput random_polygons(std::mt19937_64& random);

/// A closed prism whose corners were moved, by nothing, by a rounding or by much, so that its
/// polygons are bent or crossing but hang together.
MeshInput moved_prism(std::mt19937_64& random);

/// Triangles between few points: folded, pinched, doubled.
MeshInput random_triangles(std::mt19937_64& random);

/// A right file of any format, in which a few bytes, words or pieces are not what they were.
MeshInput damaged_file(std::mt19937_64& random);

}  // namespace haptic::test
