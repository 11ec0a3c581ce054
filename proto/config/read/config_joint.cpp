// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_joint.h"

#include <string>
#include <vector>

namespace haptic {

using enum Dimension;

namespace {

constexpr auto kKindWords = words_of(kJointKinds);
constexpr Range kNotPositive{-kNoStop, 0};

/// Dimensions of a joint's coordinate and of what acts on it.
struct JointDimensions {
  Dimension coordinate, load, stiffness, damping;
};

JointDimensions dimensions_of(const JointKindRow& row) {
  if (row.turns()) return {kAngle, kTorque, kRotationalStiffness, kRotationalDamping};
  return {kLength, kForce, kStiffness, kDamping};
}

/// Index of the object that `key` names.
uint32_t read_object_name(Section& section, std::string_view key, const SessionConfig& config) {
  std::string name;
  section.read_text(key, name);
  std::vector<std::string_view> known;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    if (view(config.objects[i].name) == name) return i;
    known.push_back(view(config.objects[i].name));
  }
  section.fail_at(key,
                  "is '" + shown(name) + "', which is no [[object]]; " + suggestion(name, known));
}

void read_ends(Section& section, const SessionConfig& config, JointConfig& joint) {
  section.require("object", "object = \"door\"");
  joint.object = read_object_name(section, "object", config);
  if (!has_mass(config.objects[joint.object].body)) {
    section.fail_at("object", "has no mass, so nothing moves it; add [object.body]");
  }
  if (section.has("to")) joint.to = read_object_name(section, "to", config);
  if (joint.to == joint.object) {
    section.fail_at("to", "is the object itself; name another one, or leave it out");
  }
}

void read_detents(Section& section, const JointDimensions& dimensions, JointConfig& joint) {
  const std::array columns{dimensions.coordinate, dimensions.load};
  std::vector<double> values;
  if (!section.read_rows("detents", columns, kMostDetents, values)) return;
  joint.n_detents = static_cast<uint32_t>(values.size() / 2);
  for (uint32_t i = 0; i < joint.n_detents; ++i) {
    joint.detents[i] = {values[2 * i], values[2 * i + 1]};
    if (i > 0 && !(joint.detents[i].position > joint.detents[i - 1].position)) {
      section.fail_at("detents", "do not ascend at row " + std::to_string(i + 1) +
                                     "; each position must be greater than the one before");
    }
  }
  if (joint.n_detents < 2) section.fail_at("detents", "is a single point; write two or more");
}

void read_points(Section& section, const Vec3& start_W, JointConfig& joint) {
  constexpr std::array kColumns{kLength, kLength, kLength};
  std::vector<double> values;
  section.require("points", "points = [[\"0 mm\", \"0 mm\", \"50 mm\"]]");
  section.read_rows("points", kColumns, kMostCurvePoints, values);
  joint.n_points = static_cast<uint32_t>(values.size() / 3);
  Vec3 before = start_W;
  for (uint32_t i = 0; i < joint.n_points; ++i) {
    joint.points_W[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    if (!(norm(joint.points_W[i] - before) > 0)) {
      section.fail_at("points", "has the same point twice at row " + std::to_string(i + 1) +
                                    "; the way begins where the object is");
    }
    before = joint.points_W[i];
  }
}

/// Reads the end stops, spring, damper, friction and detents that act along the coordinate.
void read_laws(Section& section, const JointDimensions& dimensions, JointConfig& joint) {
  section.read_all({{"lower", dimensions.coordinate, kNotPositive, joint.lower},
                    {"upper", dimensions.coordinate, kNotNegative, joint.upper},
                    {"stiffness", dimensions.stiffness, kNotNegative, joint.stiffness}});
  if (section.read_quantity("rest", dimensions.coordinate, kAny, joint.rest)) {
    section.require("stiffness", "stiffness, of the spring that 'rest' belongs to");
  }
  section.read_all({{"damping", dimensions.damping, kNotNegative, joint.damping},
                    {"friction", dimensions.load, kNotNegative, joint.friction}});
  read_detents(section, dimensions, joint);
}

void read_joint(Section& section, SessionConfig& config) {
  if (config.n_joints == kMaxJoints) {
    section.fail_at("kind", "is one [[joint]] too many; " + std::to_string(kMaxJoints) +
                                " is the most a session can hold, leave one out");
  }
  JointConfig& joint = config.joints[config.n_joints];
  assign(joint.name, "joint " + std::to_string(config.n_joints + 1));
  section.read_all({{"kind", kKindWords, joint.kind, "kind = \"hinge\""}, {"name", joint.name}});
  read_ends(section, config, joint);
  const JointKindRow& row = row_of(joint.kind);
  const Vec3& start_W = config.objects[joint.object].X_WO.p;
  joint.at_W = start_W;
  if (row.has_points) {
    read_points(section, start_W, joint);
  } else {
    section.read_lengths("at", kAny, joint.at_W);
  }
  if (row.has_axis()) {
    section.require("axis", "axis = [0, 1, 0]");
    section.read_direction("axis", joint.axis_W);
  }
  if (row.has_coordinate()) read_laws(section, dimensions_of(row), joint);
  section.finish();
  ++config.n_joints;
}

}  // namespace

void read_joints(Section& root, SessionConfig& config) {
  for (Section& section : root.sections("joint")) read_joint(section, config);
}

}  // namespace haptic
