// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "contact/bake/pieces.h"
#include "contact/bake/volume.h"
#include "contact/shape/baked/contact_shapes.h"

namespace haptic {

/// All baked shapes of a session, and their storage.
struct BakedSession {
  std::vector<BakedShape> objects;  // in the order of the config
  std::optional<BakedShape> tool;
  std::vector<BakedVolume> volumes;  // map and field of each object
  std::optional<BakedVolume> shell;  // of the tool
  std::vector<BakedPieces> pieces;   // of each object
  std::optional<BakedPieces> tool_pieces;
  std::vector<BakedPieces> collision_pieces;  // of each object; empty where it needs none

  /// Views; valid while this lives.
  ContactShapes shapes() const;
};

/// Callbacks: before each mesh is read ("bunny00.off"), for the progress of slow baking, and for
/// each finding, in lines for people.
struct BakeTold {
  std::function<void(const std::string& mesh)> begin = [](const std::string&) {};
  BakeProgress progress = {};
  std::function<void(const std::string& line)> finding = [](const std::string&) {};
};

/// Bakes the meshes of a session, or maps them from the cache; with a tool, and for the renderer
/// voxel or if [contact.voxel] is given, the volumes too, and likewise the convex pieces
/// ([contact.pieces]). Throws MeshError.
BakedSession bake_session(const SessionConfig& config, const BakeTold& told = {});

/// The convex pieces of the objects that collide with others by them, in the order of the config.
std::vector<BakedPieces> bake_collision_pieces(const SessionConfig& config,
                                               std::span<const BakedShape> objects,
                                               const BakeTold& told = {});

/// Why the hand cannot touch the object: "the object 'part' lies 0.4 m beyond what the hand
/// reaches; how to mend". Empty if it may, and if the reach is not known (a recorded hand, a device
/// without a workspace). The reach is the ball of the intended strokes, or the workspace.
std::string out_of_reach(const SessionConfig& config, const BakedSession& baked, uint32_t object);
/// Whether there are objects, and all of them are out of reach.
bool nothing_in_reach(const SessionConfig& config, const BakedSession& baked);
/// A doubt about the size of a mesh [m], in words: "is 60 m long; was unit \"m\" meant as \"mm\"?".
/// Empty: nothing.
std::string size_doubt(const ShapeConfig& object, double size);
/// Objects out of reach and of doubtful size, one line each.
std::vector<std::string> scene_warnings(const SessionConfig& config, const BakedSession& baked);

}  // namespace haptic
