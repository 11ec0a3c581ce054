// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/rigid_scenes.h"

#include <filesystem>
#include <utility>

#include "clients/lab/eval/scenes/scan_work.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"
#include "proto/os/environment.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

/// Height above the object from which the tool is free of it.
double lowest_free(const MeshShape& object, const MeshShape& tool) {
  double low = 0, high = object.mesh.upper.y - tool.mesh.lower.y;
  for (int i = 0; i < 24; ++i) {
    const double middle = 0.5 * (low + high);
    const bool meets = triangle_pairs(object, tool, {{0, middle, 0}, {}}, {}) > 0;
    (meets ? low : high) = middle;
  }
  return high;
}

}  // namespace

RigidScene rigid_scene(std::string name, Soup object, Soup tool) {
  using Both = std::pair<MeshShapeData, MeshShapeData>;
  const auto both =
      std::make_shared<const Both>(build_shape(std::move(object)), build_shape(std::move(tool)));
  RigidScene scene;
  scene.name = std::move(name);
  scene.object = both->first.view();
  scene.tool = both->second.view();
  scene.storage = both;
  return scene;
}

RigidScene box_on_plate() {
  Soup plate = make_box({0.2, 0.2, 0.02});
  for (Vec3& v : plate.vertices) v.z -= 0.01;
  RigidScene scene = rigid_scene("box on plate", plate, make_box({0.02, 0.02, 0.02}));
  scene.home.p.z = 11 * kMm;
  scene.shaking = {kMm * Vec3{20, 20, 4}, {0.2, 0.2, 0.4}, kMm * Vec3{0, 0, -2}};
  return scene;
}

RigidScene peg_in_hole(double clearance) {
  primitive::Hole hole;
  hole.clearance = clearance;
  RigidScene scene = rigid_scene("peg in hole", make_hole(hole), make_peg(hole));
  scene.shaking = {kMm * Vec3{4, 4, 15}, {0.2, 0.2, 0.4}, {}};
  return scene;
}

std::optional<RigidScene> bunny_on_bunny(const std::string& meshes) {
  const std::string file = meshes + "/bunny00.off";
  if (!std::filesystem::exists(file)) return std::nullopt;
  const auto bunny = std::make_shared<const BakedShape>(bake_scan(file, 0.1));
  RigidScene scene;
  scene.name = "bunny on bunny";
  scene.object = scene.tool = bunny->shape;
  scene.storage = bunny;
  scene.home.p.y = lowest_free(scene.object, scene.tool) + 0.1 * kMm;
  scene.shaking = {kMm * Vec3{20, 5, 20}, {0.3, 0.3, 0.3}, kMm * Vec3{0, -4, 0}};
  return scene;
}

std::string meshes_folder() {
  const std::string own = environment("HAPTICD_MESHES");
  return own.empty() ? (source_tree() / "build" / "meshes").string() : own;
}

}  // namespace haptic
