// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "proto/config/config.h"
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
  std::vector<std::string> grid;   // how the cell size of the grid was chosen
};

/// A shape ready for queries, kept alive by its storage (a mapped cache file or memory).
struct BakedShape {
  MeshShape shape;
  // for display: decimated, with smooth vertex normals
  std::span<const Vec3> eye_vertices;
  std::span<const Vec3> eye_normals;
  std::span<const Triangle> eye_triangles;
  BakeReport report;
  std::shared_ptr<const void> storage;
};

/// Reads, checks, repairs and bakes the object's mesh, or maps it from the cache folder if it was
/// baked before (key: content, unit, size, options, version). Throws MeshError.
BakedShape bake_object(const ShapeConfig& object, uint64_t memory_limit);

/// Bakes the bytes of a mesh file, whose name is object.mesh. Nothing is cached.
BakedShape bake_contents(std::string_view bytes, const ShapeConfig& object, uint64_t memory_limit);

/// Bakes a mesh in memory (generators, tests). Nothing is cached.
BakedShape bake_soup(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                     const ShapeConfig& object);

/// Cache folder: $HAPTICD_CACHE, else $XDG_CACHE_HOME/hapticd, else ~/.cache/hapticd; without a
/// home directory /var/cache/hapticd (root) or /tmp/hapticd-cache-<uid>.
std::string cache_folder();

}  // namespace haptic
