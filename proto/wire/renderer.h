// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/math/assert.h"
#include "proto/wire/proxy_solver.h"

namespace haptic {

/// A renderer: a detector of contact and a solver of the servo. Its number is its place in the
/// table.
enum class Renderer : uint32_t {
#define RENDERER(id, ...) id,
#include "proto/wire/renderers.def"
};

/// The body that a renderer moves: a point, a sphere of the session's radius, or a tool with six
/// degrees of freedom that may enter objects (soft) or never does (rigid).
enum class Moves : uint32_t { kPoint, kSphere, kSoftBody, kRigidBody };

struct RendererRow {
  std::string_view name;
  Renderer id;
  Moves moves = Moves::kPoint;
  SoftSolver soft = SoftSolver::kQuasiStatic;  // of a soft body, where the session names none
  bool has_maps = false;                       // asks voxels and fields of the objects
  bool has_pieces = false;                     // asks convex pieces of objects and tool
  bool has_mass = false;  // the servo's proxy goes its own way, and contact's follows it
};

/// All renderers, for who lists them or asks what one needs (config, control, the lab). Contact and
/// the servo read the same lines (contact/detect/detectors.cpp, servo/touch.cpp).
inline constexpr std::array kRenderers{
#define RENDERER(id_, name_, detector, solver, ...) \
  RendererRow{.name = name_, .id = Renderer::id_ __VA_OPT__(, ) __VA_ARGS__},
#include "proto/wire/renderers.def"
};

constexpr const RendererRow& row_of(Renderer renderer) {
  HAPTIC_ASSERT(static_cast<size_t>(renderer) < kRenderers.size());
  return kRenderers[static_cast<size_t>(renderer)];
}

/// True if a number on the wire names a renderer.
constexpr bool is_renderer(uint32_t number) {
  return number < kRenderers.size();
}

/// True if its tool has six degrees of freedom and never enters an object.
constexpr bool is_rigid(Renderer renderer) {
  return row_of(renderer).moves == Moves::kRigidBody;
}

/// True if it moves a 6-DoF tool instead of a point.
constexpr bool is_of_body(Renderer renderer) {
  return row_of(renderer).moves >= Moves::kSoftBody;
}

}  // namespace haptic
