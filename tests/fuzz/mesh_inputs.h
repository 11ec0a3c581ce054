// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <random>
#include <string>

#include "contact/bake/soup/read.h"

namespace haptic::test {

/// The bytes of a mesh file, and a name with the suffix of its format.
struct MeshInput {
  std::string name;
  std::string bytes;
};

/// One to three polygons of 3 to 8 random corners: non-planar, crossing, degenerate, of any size.
MeshInput random_polygons(std::mt19937_64& random);

/// A closed prism whose corners are displaced by nothing, by a rounding error or by much, so that
/// its polygons are non-planar or crossing but connected.
MeshInput moved_prism(std::mt19937_64& random);

/// Triangles between few points: folded, pinched, doubled.
MeshInput random_triangles(std::mt19937_64& random);

/// A valid file of any format with a few bytes, words or fragments changed.
MeshInput damaged_file(std::mt19937_64& random);

}  // namespace haptic::test
