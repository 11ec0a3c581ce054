// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/lod_pairs.h"

#include <cmath>
#include <numbers>

#include "clients/lab/bench/workloads/workload.h"
#include "contact/shape/mesh/ball_joint.h"
#include "contact/shape/mesh/machine_parts.h"
#include "contact/shape/mesh/molars.h"

namespace haptic {
namespace {

constexpr double kPress = 0.1e-3;  // of the surfaces into each other, at most [m]

/// From half of the depth to all of it [m].
double press_at(double t) {
  return kPress * (0.75 + swing(0.25, 2.1, t));
}

LodPair with(const std::string& name, std::string_view object, std::string_view tool,
             double voxel) {
  LodPair pair;
  pair.name = name;
  SessionConfig& config = pair.config;
  config.n_objects = 1;
  assign(config.objects[0].mesh, object);
  assign(config.tool.mesh, tool);
  config.tool.mass = 0.1;
  config.voxel.size = config.voxel.point_spacing = voxel;
  // the gaps are narrower than a layer
  config.voxel.offset_layers = 0;
  config.voxel.band = default_band(config.voxel);
  config.voxel.is_wanted = config.pieces.is_wanted = 1;
  return pair;
}

LodPair bolt_in_nut() {
  LodPair pair = with("bolt in nut", "primitive:nut", "primitive:bolt", 0.2e-3);
  const BoltAndNut screw;
  for (PartConfig* part : {&pair.config.objects[0].part, &pair.config.tool.part}) {
    part->diameter = screw.diameter;
    part->pitch = screw.pitch;
    part->depth = screw.depth;
    part->length = screw.bolt_length;
    part->height = screw.bolt_length * 100 / 140;
    part->width = screw.nut_width;
    part->clearance = screw.clearance;
    part->around = 96;
  }
  pair.config.tool.part.along = 140;
  pair.config.objects[0].part.along = 100;
  pair.path = [screw](double t) -> Pose {
    const double turn = swing(0.05, 0.5, t), aside = screw.clearance + press_at(t);
    return {{aside * std::sin(4 * t), aside * std::cos(4 * t),
             screw.pitch * turn / (2 * std::numbers::pi)},
            from_rotation_vector({0, 0, turn})};
  };
  return pair;
}

LodPair molars() {
  LodPair pair = with("teeth", "primitive:lower-molar", "primitive:upper-molar", 0.1e-3);
  const Molars teeth;
  for (PartConfig* part : {&pair.config.objects[0].part, &pair.config.tool.part}) {
    part->width = teeth.width;
    part->clearance = teeth.clearance;
    part->around = teeth.around;
  }
  pair.path = [teeth](double t) -> Pose {
    return {{swing(0.05e-3, 1.3, t), swing(0.05e-3, 0.9, t), -teeth.clearance - press_at(t)},
            from_rotation_vector({swing(2e-3, 0.7, t), 0, swing(5e-3, 1.1, t)})};
  };
  return pair;
}

LodPair ball_joint() {
  LodPair pair = with("ball joint", "primitive:joint-socket", "primitive:joint-ball", 0.3e-3);
  const BallJoint joint;
  for (PartConfig* part : {&pair.config.objects[0].part, &pair.config.tool.part}) {
    part->diameter = joint.diameter;
    part->stem = joint.stem;
    part->length = joint.length;
    part->clearance = joint.clearance;
    part->cover = joint.cover;
    part->width = joint.width;
    part->height = joint.height;
    part->around = joint.around;
  }
  pair.path = [joint](double t) -> Pose {
    const double tilt = swing(0.2, 0.8, t);
    return {{0, 0, -joint.clearance - press_at(t)},
            from_rotation_vector({tilt, swing(0.2, 0.5, t), t})};
  };
  return pair;
}

}  // namespace

LodPair make_lod_pair(const std::string& name) {
  if (name == "bolt") return bolt_in_nut();
  return name == "teeth" ? molars() : ball_joint();
}

}  // namespace haptic
