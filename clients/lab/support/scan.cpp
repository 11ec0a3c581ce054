// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/scan.h"

#include "contact/query/proximity/triangle_pairs.h"
#include "proto/config/config.h"
#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic {

BakedShape bake_scan(const std::string& file, double size) {
  ObjectConfig object;
  assign(object.mesh, file);
  object.size = size;
  object.allow_open = 1;
  return bake_object(object, SessionConfig{}.mesh_memory_limit);
}

std::string meshes_folder() {
  const std::string own = environment("HAPTICD_MESHES");
  return own.empty() ? (source_tree() / "build" / "meshes").string() : own;
}

double lowest_free(const MeshShape& object, const MeshShape& tool, double low, double high) {
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const bool meets = triangle_pairs(object, tool, {{0, middle, 0}, {}}, {}) > 0;
    (meets ? low : high) = middle;
  }
  return high;
}

}  // namespace haptic
