// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "proto/config/config.h"

namespace haptic {

/// A tool among moving objects, with a path known to be free and a hand that goes elsewhere. A
/// closed form decides on which side of each object the free path runs.
struct MovingScene {
  std::string kind;
  uint64_t seed = 0;
  std::vector<MeshShape> objects;
  std::vector<ObjectConfig> moves;  // initial poses and motions
  MeshShape tool, thick_tool;       // convex; thick_tool is larger by the clearance everywhere
  std::shared_ptr<const void> storage;
  double clearance = 0;                       // [m]
  double seconds = 1;                         // duration
  std::function<Pose(double)> way_W, hand_W;  // pose at time t [s]
  /// True if a free tool at X_WT is on the same side of every object as the free path.
  std::function<bool(const Pose& X_WT, std::span<const Pose> X_WO)> is_on_side;
};

/// Poses of the objects at time t [s].
std::vector<Pose> object_poses(const MovingScene& scene, double t);

/// True if the path is free with its clearance: at each sample the thick tool intersects nothing
/// (CGAL's exact predicates) and is on the right side, and between samples no point of tool and
/// objects moves by more than the clearance allows.
bool has_free_way(const MovingScene& scene);

/// One of five kinds by the seed, redrawn until it has a free path: jaws that close on a tilted
/// tool, a pusher that presses it to a wall, a slot that carries it away, a paddle that turns in a
/// drum, and a bore with a piston that moves sideways. Plates may be bumpy, tools are boxes and
/// prisms, and the scene has a random pose in W. Hands rest, shake, turn, or go through an object.
MovingScene make_moving_scene(uint64_t seed);

}  // namespace haptic
