// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "proto/config/config_names.h"
#include "proto/config/primitive.h"
#include "proto/math/pose.h"

namespace haptic {

/// How an object moves: a row of the table.
enum class MotionKind : uint32_t {
#define MOTION(id, ...) id,
#include "proto/config/motions.def"
};

struct MotionKindRow {
  std::string_view name;
  MotionKind id;
  bool is_still = false;       // it has no keys
  bool has_amplitude = false;  // must be given one
};

/// All motions; sim reads the same lines (sim/scene.cpp).
inline constexpr std::array kMotions{
#define MOTION(id_, name_, motion, ...) \
  MotionKindRow{.name = name_, .id = MotionKind::id_ __VA_OPT__(, ) __VA_ARGS__},
#include "proto/config/motions.def"
};

constexpr const MotionKindRow& row_of(MotionKind kind) {
  return kMotions[static_cast<size_t>(kind)];
}

/// Scripted motion about the configured pose.
struct MotionConfig {
  MotionKind kind{};
  uint32_t reserved = 0;
  Vec3 axis_O{0, 0, 1};
  double amplitude = 0;  // [m]
  double frequency = 0;  // [Hz]; for spin, turns per second
};

enum class TextureKind : uint32_t { kNone = 0, kGrating = 1, kImage = 2 };

/// Heights of a texture as a grey image, by rows, 0 low to 255 high, repeated in both directions.
struct HeightImage {
  static constexpr uint32_t kMaxSide = 64;
  uint32_t width = 0, height = 0;
  std::array<uint8_t, kMaxSide * kMaxSide> grey{};
};
inline constexpr uint32_t kMaxImages = 4;  // limits the size of SessionConfig

/// Surface texture of an object, in the object's frame.
struct TextureConfig {
  TextureKind kind = TextureKind::kNone;
  uint32_t image = 0;         // index in SessionConfig::images
  double amplitude = 0;       // grating: of the sine; image: from black to white [m]
  double period = 0;          // grating: wavelength; image: width of one tile [m]
  Vec3 direction_O{1, 0, 0};  // grating: direction across its lines
};

/// Material of an object for the renderer virtual-proxy3.
struct MaterialConfig {
  double friction_static = 0;   // μ_s: sticks up to this ratio of tangential to normal force
  double friction_dynamic = 0;  // μ_d ≤ μ_s: that ratio while sliding
  double friction_viscous = 0;  // b: speed of sliding is limited by this damping [N·s/m]
  double stiffness_share = 1;   // s_s: share of the coupling's stiffness, 0 to 1
  double crease_angle = 0;      // edges with a smaller angle are shaded smooth; 0: no shading [rad]
  TextureConfig texture;
};

/// A body: a mesh file or a generated mesh.
struct ShapeConfig {
  Name name{};
  Primitive primitive;      // or
  Path mesh{};              // absolute
  double unit = 0;          // metres per file unit; 0: any, scaled to `size`
  double size = 0;          // longest side of the file's bounding box [m]; 0: not stated
  uint32_t allow_open = 0;  // 1: an open mesh is accepted as a one-sided surface
  uint32_t colour = 0;      // on a screen, 0xrrggbb
};

/// True if there is a body; a tool without one is a point.
inline bool has_mesh(const ShapeConfig& shape) {
  return shape.primitive.index() > 0 || shape.mesh[0] != 0;
}

/// The name of a mesh for people: the path of its file, or "primitive:box"; empty: there is none.
inline std::string mesh_name(const ShapeConfig& shape) {
  if (shape.primitive.index() == 0) return std::string(view(shape.mesh));
  return "primitive:" + std::string(kind_name(shape.primitive));
}

/// An object that is moved by pushes, gravity and other objects.
struct BodyConfig {
  double density = 0;  // gives mass and inertia of the closed mesh [kg/m³]; 0: use the two below
  double mass = 0;     // [kg]; 0 and no density: it stands still or follows its script
  Vec3 inertia;  // about the axes of O through the centre of mass [kg·m²]; 0: that of a solid mesh
                 // of this mass
  double restitution = 0;  // speed after an impact over the speed before, 0 to 1
};

constexpr bool has_mass(const BodyConfig& body) {
  return body.density > 0 || body.mass > 0;
}

struct ObjectConfig : ShapeConfig {
  Pose X_WO;
  MotionConfig motion;
  MaterialConfig material;
  BodyConfig body;
};

/// True if others push it by its convex pieces: it has mass, and is no box or ball.
inline bool collides_as_pieces(const ObjectConfig& object) {
  return has_mass(object.body) && !is_any_of<primitive::Box, primitive::Sphere>(object.primitive);
}

/// The tool of renderers with six degrees of freedom; no mesh: a point.
struct ToolConfig : ShapeConfig {
  double density = 0;  // gives mass and inertia of the closed mesh [kg/m³]; 0: use the two below
  double mass = 0.1;   // [kg]
  Vec3 inertia;  // about the axes of T through the centre of mass [kg·m²]; 0: that of a solid mesh
                 // of this mass
};

}  // namespace haptic
