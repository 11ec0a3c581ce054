// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/rigid_scenes.h"

#include <filesystem>
#include <utility>

#include "clients/lab/eval/scenes/scan_work.h"
#include "clients/lab/support/soups.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr PartGrid kGrid{96, 16};

}  // namespace

RigidScene rigid_scene(std::string name, Soup object, Soup tool) {
  using Both = std::pair<MeshShapeData, MeshShapeData>;
  const auto both =
      std::make_shared<const Both>(build_shape(std::move(object)), build_shape(std::move(tool)));
  return {std::move(name), both->first.view(), both->second.view(), both, {}, {}};
}

RigidScene box_on_plate() {
  RigidScene scene = rigid_scene("box on plate", lowered(make_box({0.2, 0.2, 0.02}), 0.01),
                                 make_box({0.02, 0.02, 0.02}));
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
  RigidScene scene{"bunny on bunny", bunny->shape, bunny->shape, bunny, {}, {}};
  const double high = scene.object.mesh.upper.y - scene.tool.mesh.lower.y;
  scene.home.p.y = lowest_free(scene.object, scene.tool, 0, high) + 0.1 * kMm;
  scene.shaking = {kMm * Vec3{20, 5, 20}, {0.3, 0.3, 0.3}, kMm * Vec3{0, -4, 0}};
  return scene;
}

}  // namespace haptic
