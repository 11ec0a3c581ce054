// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/math/assert.h"
#include "proto/wire/proxy_solver.h"

namespace haptic {

/// What contact finds the contacts by (contact/detect), what it keeps for it being one type.
enum class Detector : uint32_t { kPointProxy, kNearestSurface, kSoftBody, kRigidTool };

/// What the servo finds this tick's proxy by (servo/solve).
enum class Solver : uint32_t {
  kPointProxy,
  kVirtualProxy,
  kDirect,
  kSoftProxy,
  kGodObject6,
  kConstrained6
};

/// A renderer: a detector of contact and a solver of the servo. Its number is its place in the
/// table.
enum class Renderer : uint32_t {
  kGodObject3 = 0,
  kPenalty3 = 1,
  kVirtualProxy3 = 2,
  kDirect6 = 3,
  kVoxel = 4,
  kGodObject6 = 5,
  kConstrained6 = 6,
};

struct RendererRow {
  std::string_view name;  // in a config
  Renderer id;
  Detector detector;
  Solver solver;
  bool has_tool = false;  // moves a tool with six degrees of freedom instead of a point
  bool has_maps = false;  // asks voxels and fields of the objects
  std::optional<SoftSolver> soft = {};  // of a soft proxy, where the session names none
};

/// All renderers: whatever knows them reads this (config, control, contact, servo, the lab).
inline constexpr std::array<RendererRow, 7> kRenderers{{
    {"god-object3", Renderer::kGodObject3, Detector::kPointProxy, Solver::kPointProxy},
    {"penalty3", Renderer::kPenalty3, Detector::kNearestSurface, Solver::kDirect},
    {"virtual-proxy3", Renderer::kVirtualProxy3, Detector::kPointProxy, Solver::kVirtualProxy},
    {"direct6", Renderer::kDirect6, Detector::kSoftBody, Solver::kSoftProxy, true, false,
     SoftSolver::kDirect},
    {"voxel", Renderer::kVoxel, Detector::kSoftBody, Solver::kSoftProxy, true, true,
     SoftSolver::kQuasiStatic},
    {"god-object6", Renderer::kGodObject6, Detector::kRigidTool, Solver::kGodObject6, true},
    {"constrained6", Renderer::kConstrained6, Detector::kRigidTool, Solver::kConstrained6, true},
}};

constexpr const RendererRow& row_of(Renderer renderer) {
  HAPTIC_ASSERT(static_cast<size_t>(renderer) < kRenderers.size());
  return kRenderers[static_cast<size_t>(renderer)];
}

static_assert([] {
  for (size_t i = 0; i < kRenderers.size(); ++i) {
    if (static_cast<size_t>(kRenderers[i].id) != i) return false;
  }
  return true;
}());

/// Whether a number on the wire names a renderer.
constexpr bool is_renderer(uint32_t number) {
  return number < kRenderers.size();
}

/// Whether its tool has six degrees of freedom and never enters an object.
constexpr bool is_rigid(Renderer renderer) {
  return row_of(renderer).detector == Detector::kRigidTool;
}

/// Whether it moves a 6-DoF tool instead of a point.
constexpr bool is_of_body(Renderer renderer) {
  return row_of(renderer).has_tool;
}

}  // namespace haptic
