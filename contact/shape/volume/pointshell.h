// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

inline constexpr double kMostCubes = 1 << 20;  // with a point each, along a side of a tool

/// A run of neighbouring points with a ball around it. Its own point is one of the run; a node's
/// point is that of one of its children, so the points of a level are among those of the next.
struct ShellNode {
  uint32_t first = 0, count = 0;             // of the points below
  uint32_t first_child = 0, n_children = 0;  // nodes of the next level; none on the finest
  uint32_t point = 0;
  float radius = 0;  // around that point, over all points below, rounded up [m]
};

/// Points on the surface of a tool with normals that point inwards (McNeely, Puterbaugh, Troy
/// 1999), in Morton order, so that neighbours in space are neighbours in memory; in levels of
/// resolution, each twice as fine as the one before (Barbič & James 2008). In T. A view.
struct Pointshell {
  double spacing = 0;                 // between points of the finest level, about [m]
  double radius = 0;                  // of the ball around the origin of T that holds all [m]
  std::span<const float> x, y, z;     // [m]
  std::span<const float> nx, ny, nz;  // unit
  std::span<const ShellNode> nodes;   // level by level, the root first
  std::span<const uint32_t> levels;   // first node of each level, and their number at the end
};

struct PointshellData {
  double spacing = 0, radius = 0;
  std::vector<float> x, y, z, nx, ny, nz;
  std::vector<ShellNode> nodes;
  std::vector<uint32_t> levels;

  Pointshell view() const { return {spacing, radius, x, y, z, nx, ny, nz, nodes, levels}; }
};

/// Bakes the shell; start-up only. One point for each cube of edge `spacing` that the surface
/// passes, the nearest to its middle of samples a third of the spacing apart, with the normal of
/// its face turned inwards. Empty where the mesh is, or where a side has kMostCubes.
PointshellData build_pointshell(const TriangleMesh& mesh, double spacing);

}  // namespace haptic
