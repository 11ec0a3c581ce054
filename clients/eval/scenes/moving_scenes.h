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

/// A tool among objects that move, with a way that is known to be free and a hand that goes
/// somewhere else. A closed form says on which side of each object the way is.
struct MovingScene {
  std::string kind;
  uint64_t seed = 0;
  std::vector<MeshShape> objects;
  std::vector<ObjectConfig> moves;  // where they begin, and how they move
  MeshShape tool, thick_tool;       // convex; the other is larger by the clearance everywhere
  std::shared_ptr<const void> storage;
  double clearance = 0;                       // [m]
  double seconds = 1;                         // of the session
  std::function<Pose(double)> way_W, hand_W;  // at a time [s]
  /// Whether the tool, at X_WT and free of the objects, is on that side of all of them.
  std::function<bool(const Pose& X_WT, std::span<const Pose> X_WO)> is_on_side;
};

/// Where the objects are at a time [s].
std::vector<Pose> object_poses(const MovingScene& scene, double t);

/// Whether the way is free with its clearance: at so many times the thick tool meets nothing
/// (CGAL's exact predicates) and is on the side, and from one to the next no point of tool and
/// objects comes nearer than the clearance makes up for.
bool has_free_way(const MovingScene& scene);

/// One of five kinds by the seed, drawn until it has a free way: jaws that close on a tilted tool,
/// a pusher that presses it to a wall, a slot that carries it away, a paddle that turns in a drum,
/// and a bore with a piston that moves sideways. Plates may be bumpy, tools are boxes and prisms,
/// the whole lies askew in W. Hands rest, shake, turn, or go through an object.
MovingScene make_moving_scene(uint64_t seed);

}  // namespace haptic
