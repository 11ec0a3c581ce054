// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/free_scenes.h"

#include <cmath>

#include "clients/lab/support/dice.h"
#include "clients/lab/support/scripted_hand.h"
#include "clients/lab/support/soups.h"
#include "contact/bake/convex/piece_tree.h"
#include "contact/bake/volume.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// Owns the data behind the views of a scene.
struct FreeStorage {
  std::vector<BakedShape> shapes;
  std::vector<BakedVolume> volumes;
  std::vector<PieceTreeData> pieces;
};

void bake_scene(FreeScene& scene) {
  const auto storage = std::make_shared<FreeStorage>();
  const VoxelConfig& voxel = scene.config.voxel;
  const auto pieces_of = [&](const BakedShape& shape) {
    storage->pieces.push_back(build_piece_tree(shape.shape.mesh));
    return storage->pieces.back().view();
  };
  const auto shape_of = [&](const Soup& soup) {
    ShapeConfig as_it_is;
    as_it_is.unit = 1;
    storage->shapes.push_back(bake_soup(soup.vertices, soup.triangles, as_it_is));
    return storage->shapes.back();
  };
  for (const Soup& object : scene.objects) {
    const BakedShape shape = shape_of(object);
    storage->volumes.push_back(bake_obstacle(shape, voxel));
    const VolumeContent& content = storage->volumes.back().content;
    scene.shapes.objects.push_back(shape.shape);
    scene.shapes.bodies.volumes.push_back({content.map, content.field});
    scene.shapes.bodies.pieces.push_back(pieces_of(shape));
  }
  const BakedShape tool = shape_of(scene.tool);
  storage->volumes.push_back(bake_tool(tool, voxel));
  scene.shapes.bodies.tool = tool.shape;
  scene.shapes.bodies.tool_pieces = pieces_of(tool);
  scene.shapes.bodies.shell = storage->volumes.back().content.shell;
  scene.storage = storage;
}

}  // namespace

SessionConfig JudgedRenderer::in(SessionConfig config) const {
  config.renderer = renderer;
  config.proxy.solver = solver;
  config.voxel.field = reads_field ? 1 : 0;
  return config;
}

FreeScene make_free_scene(const std::string& name, std::vector<Soup> objects, Soup tool,
                          const FreeVoxels& voxels, const Vec3& over) {
  FreeScene scene{name, plain_session(800), std::move(objects), std::move(tool), {}, {}, over};
  SessionConfig& config = scene.config;
  config.n_objects = static_cast<uint32_t>(scene.objects.size());
  config.coupling.rotational_stiffness = 2;
  config.coupling.max_force = 6;
  config.coupling.max_torque = 0.3;
  config.safety.velocity_limit = 100;
  config.voxel.size = config.voxel.point_spacing = voxels.size;
  config.voxel.offset_layers = voxels.layers;
  config.voxel.band = std::max(default_band(config.voxel), voxels.least_band);
  bake_scene(scene);
  return scene;
}

namespace {

Soup bumpy_ball(double radius, uint32_t subdivisions, Dice& dice) {
  const auto drawn = [&](double low, double high) {
    return Vec3{dice.uniform(low, high), dice.uniform(low, high), dice.uniform(low, high)};
  };
  const Vec3 rates = drawn(5, 10), phases = drawn(0, 2 * kPi);
  return mapped(make_icosphere(radius, subdivisions), [&](const Vec3& v) {
    const Vec3 u = (1 / radius) * v;
    const double bump = std::sin(rates.x * u.x + phases.x) * std::sin(rates.y * u.y + phases.y) *
                        std::sin(rates.z * u.z + phases.z);
    return (1 + 0.08 * bump) * v;
  });
}

}  // namespace

FreeScene peg_over_hole() {
  primitive::Hole hole;
  hole.clearance = 0.5 * kMm;
  hole.grid = {48, 4};
  primitive::Peg peg;
  peg.grid = {24, 2};
  return make_free_scene("peg over hole", {make_hole(hole)}, make_peg(peg), {0.5 * kMm},
                         kMm * Vec3{18, 0, 100});
}

FreeScene bumpy_balls(uint64_t seed) {
  Dice dice(seed);
  const Soup object = bumpy_ball(40 * kMm, 3, dice);
  return make_free_scene("bumpy balls", {object}, bumpy_ball(15 * kMm, 2, dice), {kMm, 2},
                         kMm * Vec3{3, -2, 100});
}

FreeScene box_over_moving_plate() {
  FreeScene scene = make_free_scene("box over moving plate",
                                    {make_box({0.1, 0.1, 0.03}), make_icosphere(20 * kMm, 2)},
                                    make_box({0.03, 0.02, 0.015}), {kMm}, {0, 0, 0.1});
  scene.config.objects[0].motion = {MotionKind::kOscillate, 0, {0, 0, 1}, 10 * kMm, 1.5};
  ObjectConfig& ball = scene.config.objects[1];
  ball.X_WO.p = {0, 0.12, 0.03};
  ball.motion = {MotionKind::kOscillate, 0, {1, 0, 0}, 30 * kMm, 1};
  return scene;
}

Pose scripted_pose(const ObjectConfig& object, double t) {
  const MotionConfig& motion = object.motion;
  if (motion.kind != MotionKind::kOscillate) return object.X_WO;
  const double way = motion.amplitude * std::sin(2 * kPi * motion.frequency * t);
  return {object.X_WO.p + way * rotate(object.X_WO.q, motion.axis_O), object.X_WO.q};
}

}  // namespace haptic
