// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/soup/report.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Called with what is being baked and its progress, from 0 to 1.
using BakeProgress = std::function<void(std::string_view what, double share)>;

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
/// baked before (key: content, unit, size, options, version). A generated mesh of a few thousand
/// triangles or less is made anew. Throws MeshError.
BakedShape bake_object(const ShapeConfig& object, uint64_t memory_limit,
                       const BakeProgress& progress = {});

/// Bakes the bytes of a mesh file, whose name is object.mesh. Nothing is cached.
BakedShape bake_contents(std::string_view bytes, const ShapeConfig& object, uint64_t memory_limit);

/// Bakes a mesh in memory (generators, tests). Nothing is cached.
BakedShape bake_soup(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                     const ShapeConfig& object);

/// Cache folder: $HAPTICD_CACHE, else $XDG_CACHE_HOME/hapticd, else ~/.cache/hapticd; without a
/// home directory /var/cache/hapticd (root) or /tmp/hapticd-cache-<uid>.
std::string cache_folder();

}  // namespace haptic
