// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "contact/step.h"
#include "proto/config/config.h"

namespace haptic {

/// Objects and a tool that comes to them from above, along −z.
struct FreeScene {
  std::string name;
  SessionConfig config;  // objects and their motions, voxels, springs
  std::vector<Soup> objects;
  Soup tool;
  ContactShapes shapes;                 // of both
  std::shared_ptr<const void> storage;  // of the shapes
  Vec3 over;                            // above where the tool lands [m]
};

/// A peg above the block with its hole, half a millimetre wider all round; it lands on the rim.
FreeScene peg_over_hole();
/// Two balls with bumps that the seed draws, voxels of 1 mm, surfaces two layers in front.
FreeScene bumpy_balls(uint64_t seed);
/// A box over a plate that goes up and down and a ball that goes to and fro beside it.
FreeScene box_over_moving_plate();

/// Where an object is at a time [s], by the formula of its motion.
Pose scripted_pose(const ObjectConfig& object, double t);

/// A hand that follows a formula: the pose of the tool at time t [s].
struct FreeHand {
  std::string name;
  std::function<Pose(double)> path;
};

/// Hands of many kinds: sweeps of 2 m/s and turns of 10 rad/s half a metre away, shaken at both
/// speeds, reaches of 2 m/s, slaps of 1.5 m/s that end a millimetre deep, strokes close by, tremor
/// and creep. `touch` is the place at which the tool touches from above.
std::vector<FreeHand> free_hands(const Vec3& touch, uint64_t seed);

}  // namespace haptic
