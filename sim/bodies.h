// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <boost/container/static_vector.hpp>
#include <optional>
#include <span>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/convex/piece_tree.h"
#include "proto/config/config.h"
#include "sim/bullet/body_world.h"
#include "sim/pushes/hand_pushes.h"

namespace haptic {

/// The newest frame of each hand of the session; null: none yet.
using HandFrames = boost::container::static_vector<const ServoFrame*, kMostHands>;

/// Objects with mass and what they collide with. No object has mass: there is no world.
struct BodiesModel {
  WorldModel world;
  std::vector<uint32_t> with_mass;  // objects, ascending; by response
  double period = 0;                // of the frames [s]
  double reach = 0;  // [m] a body that is farther from its place at the start stays where it is
};

/// Shapes and convex pieces as contact has baked them, in the order of the config; they must
/// outlive the model. An object with mass for which there are no pieces is the hull of its mesh.
/// Throws std::invalid_argument with one line for people where a body cannot be made of its mesh.
BodiesModel build_bodies(const SessionConfig& config, std::span<const MeshShape> shapes,
                         std::span<const PieceTree> pieces);

/// What the bodies keep between steps.
struct BodiesState {
  std::optional<BodyWorld> world;
  std::array<SeenCounters, kMostHands> seen{};
  std::array<int64_t, kMaxBodies> touched_ns{};  // last push of each body; 0: never
  bool resumed = false;                          // `last` is that of a sim that was away
  uint64_t returned_seq = 0;                     // of its first frame since it was away
  int64_t returned_ns = 0;                       // of that frame
  SceneFrame last{};
};

/// Steps of equal length in dt [s] between two frames of a sim with that period [s], each of at
/// most 2.2 periods: behind one tick that was left out a single one. A sim rests two thirds of what
/// it was busy; cut at each period, steps of more than 0.3 of it would keep it late for ever.
int steps_between(double dt, double period);

/// Returns whether this can be a frame of the same session: as many objects, the same bodies, and
/// `n_given` objects of clients.
bool is_of(const BodiesModel& model, size_t n_objects, size_t n_given, const SceneFrame& frame);

/// Moves the bodies from state.last to the frame's instant and notes in `frame`, where scripted
/// objects are already, their poses, twists and responses. The world is made at the first call.
void step_bodies(const BodiesModel& model, BodiesState& state, const HandFrames& hands,
                 SceneFrame& frame);

}  // namespace haptic
