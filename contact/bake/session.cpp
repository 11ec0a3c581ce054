// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/session.h"

#include "proto/config/renderer_needs.h"

namespace haptic {
namespace {

BakedShape bake_told(const ShapeConfig& shape, uint64_t memory_limit, const BakeTold& told) {
  told.begin(mesh_name(shape));
  BakedShape baked = bake_object(shape, memory_limit, told.progress);
  for (const std::string& line : baked.report.lines) told.finding(line);
  return baked;
}

using BakeVolume = BakedVolume (&)(const BakedShape&, const VoxelConfig&, const BakeProgress&);

BakedVolume bake_told(BakeVolume bake, const BakedShape& shape, const VoxelConfig& options,
                      const BakeTold& told) {
  told.begin("the voxels of " + shape.report.file);
  BakedVolume volume = bake(shape, options, told.progress);
  for (const std::string& line : volume.lines) told.finding(line);
  return volume;
}

BakedPieces bake_told(const BakedShape& shape, const BakeTold& told) {
  told.begin("the convex pieces of " + shape.report.file);
  BakedPieces pieces = bake_pieces(shape, told.progress);
  for (const std::string& line : pieces.lines) told.finding(line);
  return pieces;
}

}  // namespace

ContactShapes BakedSession::shapes() const {
  ContactShapes shapes;
  for (const BakedShape& object : objects) shapes.objects.push_back(object.shape);
  if (tool) shapes.bodies.tool = tool->shape;
  for (const BakedVolume& volume : volumes) {
    shapes.bodies.volumes.push_back({volume.content.map, volume.content.field});
  }
  if (shell) shapes.bodies.shell = shell->content.shell;
  for (const BakedPieces& object : pieces) shapes.bodies.pieces.push_back(object.tree);
  if (tool_pieces) shapes.bodies.tool_pieces = tool_pieces->tree;
  for (const BakedPieces& object : collision_pieces) shapes.collision_pieces.push_back(object.tree);
  return shapes;
}

std::vector<BakedPieces> bake_collision_pieces(const SessionConfig& config,
                                               std::span<const BakedShape> objects,
                                               const BakeTold& told) {
  std::vector<BakedPieces> pieces(objects.size());
  for (size_t i = 0; i < objects.size(); ++i) {
    if (collides_as_pieces(config.objects[i])) pieces[i] = bake_told(objects[i], told);
  }
  return pieces;
}

BakedSession bake_session(const SessionConfig& config, const BakeTold& told) {
  BakedSession session;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    session.objects.push_back(bake_told(config.objects[i], config.mesh_memory_limit, told));
  }
  session.collision_pieces = bake_collision_pieces(config, session.objects, told);
  if (!has_mesh(config.tool)) return session;
  session.tool = bake_told(config.tool, config.mesh_memory_limit, told);
  if (has_pieces(config)) {
    for (const BakedShape& object : session.objects) {
      session.pieces.push_back(bake_told(object, told));
    }
    session.tool_pieces = bake_told(*session.tool, told);
  }
  if (!has_maps(config)) return session;
  for (const BakedShape& object : session.objects) {
    session.volumes.push_back(bake_told(bake_obstacle, object, config.voxel, told));
  }
  session.shell = bake_told(bake_tool, *session.tool, config.voxel, told);
  return session;
}

}  // namespace haptic
