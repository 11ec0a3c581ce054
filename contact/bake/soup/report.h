// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "proto/os/message.h"

namespace haptic {

/// A mesh that cannot be used: one line "file[:line]: what is wrong; how to fix it".
struct MeshError : InputError {
  using InputError::InputError;
};

/// Findings and repairs. Never silent: people read `lines`.
struct BakeReport {
  std::string file;
  size_t vertices = 0, triangles = 0;
  bool closed = false;
  size_t components = 0;
  size_t border_edges = 0;
  size_t degenerate_removed = 0;
  size_t duplicate_removed = 0;
  size_t non_manifold_split = 0;
  size_t self_intersections = 0;  // pairs of faces
  bool reoriented = false;
  double size = 0;  // longest side of the bounding box after scaling [m]
  bool from_cache = false;
  std::vector<std::string> lines;  // one finding each, for people
};

}  // namespace haptic
