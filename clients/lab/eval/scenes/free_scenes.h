// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "contact/step.h"
#include "proto/config/config.h"

namespace haptic {

/// Objects and a tool that approaches them from above, along −z.
struct FreeScene {
  std::string name;
  SessionConfig config;  // objects and their motions, voxels, springs
  std::vector<Soup> objects;
  Soup tool;
  ContactShapes shapes;                 // of both
  std::shared_ptr<const void> storage;  // owns the shapes
  Vec3 over;                            // above the landing place [m]
};

/// A peg above the rim of a hole in a block; 0.5 mm of clearance all round.
FreeScene peg_over_hole();
/// Two balls with random bumps, voxels of 1 mm, surfaces offset by two layers.
FreeScene bumpy_balls(uint64_t seed);
/// A box over a plate that moves up and down, next to a ball that moves to and fro.
FreeScene box_over_moving_plate();

/// Voxels of a scene: their size, which is also that between points, the layers by which surfaces
/// are offset, and the least band of the field.
struct FreeVoxels {
  double size;  // [m]
  uint32_t layers = 0;
  double least_band = 0;  // [m]
};
/// A scene with all its shapes. Its springs are those of the configuration peg-in-hole; every other
/// source of force is off.
FreeScene make_free_scene(const std::string& name, std::vector<Soup> objects, Soup tool,
                          const FreeVoxels& voxels, const Vec3& over = {});

/// Pose of an object at time t [s], by the formula of its motion.
Pose scripted_pose(const ObjectConfig& object, double t);

/// A renderer under test; `solver` is set if it has several proxy solvers.
struct JudgedRenderer {
  std::string name;
  Renderer renderer{};
  std::optional<SoftSolver> solver = {};
  bool reads_field = true;  // voxel: distance field, else tangent planes
  bool is_smooth = false;   // held to the goal of its force above 50 Hz
  bool has_mass = false;    // felt without contacts, too

  /// A session of it.
  SessionConfig in(SessionConfig config) const;
};

/// A hand that follows a formula: pose of the tool at time t [s].
struct FreeHand {
  std::string name;
  std::function<Pose(double)> path;
};

/// Hands of many kinds: sweeps of 2 m/s and turns of 10 rad/s half a metre away, shaking at both
/// speeds, reaches of 2 m/s, slaps of 1.5 m/s that end 1 mm deep, strokes close by, the fastest of
/// 2 m/s and 10 rad/s, tremor and creep. `touch` is the position at which the tool touches from
/// above.
std::vector<FreeHand> free_hands(const Vec3& touch, uint64_t seed);

}  // namespace haptic
