// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/generated.h"

#include "contact/shape/mesh/ball_joint.h"
#include "contact/shape/mesh/dimpled_ball.h"
#include "contact/shape/mesh/frame_parts.h"
#include "contact/shape/mesh/machine_parts.h"
#include "contact/shape/mesh/molars.h"

namespace haptic {

#define PRIMITIVE(name, read, generate) GenerateMesh generate;
#include "proto/config/primitives.def"

namespace {

PartGrid grid_of(const PartConfig& part) {
  return {part.around, part.along};
}

PegAndHole fit_of(const PartConfig& part) {
  return {part.diameter, part.length, part.clearance, part.block};
}

BoltAndNut thread_of(const PartConfig& part) {
  return {part.diameter, part.pitch, part.depth,    part.length,
          part.height,   part.width, part.clearance};
}

Molars molars_of(const PartConfig& part) {
  return {part.width, part.clearance, part.around};
}

BallJoint joint_of(const PartConfig& part) {
  return {part.diameter, part.stem,  part.length, part.clearance,
          part.cover,    part.width, part.height, part.around};
}

FrameParts frame_of(const PartConfig& part) {
  FrameParts parts;
  parts.length = part.length;
  parts.width = part.width;
  parts.diameter = part.diameter;
  parts.around = part.around;
  return parts;
}

}  // namespace

Soup generate_box(const ShapeConfig& shape) {
  return make_box(shape.extent);
}

Soup generate_sphere(const ShapeConfig& shape) {
  return make_icosphere(0.5 * shape.size, shape.subdivisions);
}

Soup generate_peg(const ShapeConfig& shape) {
  return make_peg(fit_of(shape.part), grid_of(shape.part));
}

Soup generate_hole(const ShapeConfig& shape) {
  return make_hole(fit_of(shape.part), grid_of(shape.part));
}

Soup generate_gear(const ShapeConfig& shape) {
  const PartConfig& p = shape.part;
  return make_gear({p.teeth, p.module, p.width, p.bore, p.backlash}, grid_of(p));
}

Soup generate_bolt(const ShapeConfig& shape) {
  return make_bolt(thread_of(shape.part), grid_of(shape.part));
}

Soup generate_nut(const ShapeConfig& shape) {
  return make_nut(thread_of(shape.part), grid_of(shape.part));
}

Soup generate_lower_molar(const ShapeConfig& shape) {
  return make_lower_molar(molars_of(shape.part));
}

Soup generate_upper_molar(const ShapeConfig& shape) {
  return make_upper_molar(molars_of(shape.part));
}

Soup generate_joint_ball(const ShapeConfig& shape) {
  return make_joint_ball(joint_of(shape.part));
}

Soup generate_joint_socket(const ShapeConfig& shape) {
  return make_joint_socket(joint_of(shape.part));
}

Soup generate_dimpled_ball(const ShapeConfig& shape) {
  const PartConfig& p = shape.part;
  return make_dimpled_ball({p.diameter, p.depth, p.along});
}

Soup generate_frame_rail(const ShapeConfig& shape) {
  FrameParts parts = frame_of(shape.part);
  parts.height = shape.part.height;
  parts.clearance = shape.part.clearance;
  return make_frame_rail(parts);
}

Soup generate_pin_rest(const ShapeConfig& shape) {
  FrameParts parts = frame_of(shape.part);
  parts.post = shape.part.height;
  return make_pin_rest(parts);
}

Soup generate_window(const ShapeConfig& shape) {
  return make_window(shape.extent, shape.part.width, shape.part.height);
}

Soup generate_mesh(std::string_view wanted, const ShapeConfig& shape) {
#define PRIMITIVE(name, read, generate) \
  if (wanted == name) return generate(shape);
#include "proto/config/primitives.def"
  return {};
}

std::string generated_names() {
  std::string names;
#define PRIMITIVE(name, read, generate) names += names.empty() ? name : ", " name;
#include "proto/config/primitives.def"
  return names;
}

}  // namespace haptic
