// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/lod_pairs.h"

#include <cmath>
#include <numbers>

#include "clients/lab/bench/workloads/workload.h"

namespace haptic {
namespace {

constexpr double kPress = 0.1e-3;  // of the surfaces into each other, at most [m]

/// From half of the depth to all of it [m].
double press_at(double t) {
  return kPress * (0.75 + swing(0.25, 2.1, t));
}

LodPair with(const std::string& name, const Primitive& object, const Primitive& tool,
             double voxel) {
  LodPair pair;
  pair.name = name;
  SessionConfig& config = pair.config;
  config.n_objects = 1;
  config.objects[0].primitive = object;
  config.tool.primitive = tool;
  config.tool.mass = 0.1;
  config.voxel = tight_voxels(voxel, voxel);
  config.voxel.is_wanted = config.pieces.is_wanted = 1;
  return pair;
}

LodPair bolt_in_nut() {
  primitive::Bolt bolt;
  bolt.grid.along = 140;
  primitive::Nut nut;
  nut.height = bolt.length * 100 / 140;
  nut.grid.along = 100;
  LodPair pair = with("bolt in nut", nut, bolt, 0.2e-3);
  pair.path = [nut](double t) -> Pose {
    const double turn = swing(0.05, 0.5, t), aside = nut.clearance + press_at(t);
    return {{aside * std::sin(4 * t), aside * std::cos(4 * t),
             nut.pitch * turn / (2 * std::numbers::pi)},
            from_rotation_vector({0, 0, turn})};
  };
  return pair;
}

LodPair molars() {
  const primitive::UpperMolar upper;
  LodPair pair = with("teeth", primitive::LowerMolar{}, upper, 0.1e-3);
  pair.path = [upper](double t) -> Pose {
    return {{swing(0.05e-3, 1.3, t), swing(0.05e-3, 0.9, t), -upper.clearance - press_at(t)},
            from_rotation_vector({swing(2e-3, 0.7, t), 0, swing(5e-3, 1.1, t)})};
  };
  return pair;
}

LodPair ball_joint() {
  const primitive::JointSocket socket;
  LodPair pair = with("ball joint", socket, primitive::JointBall{}, 0.3e-3);
  pair.path = [socket](double t) -> Pose {
    const double tilt = swing(0.2, 0.8, t);
    return {{0, 0, -socket.clearance - press_at(t)},
            from_rotation_vector({tilt, swing(0.2, 0.5, t), t})};
  };
  return pair;
}

}  // namespace

VoxelConfig tight_voxels(double size, double spacing) {
  VoxelConfig voxel{.size = size, .point_spacing = spacing, .offset_layers = 0};
  voxel.band = default_band(voxel);
  return voxel;
}

LodPair make_lod_pair(const std::string& name) {
  if (name == "bolt") return bolt_in_nut();
  return name == "teeth" ? molars() : ball_joint();
}

}  // namespace haptic
