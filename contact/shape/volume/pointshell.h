// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/shape/mesh/arrays.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

inline constexpr double kMostCubes = 1 << 20;  // along a side of a tool, at most one point per cube

/// A range of neighbouring points, and a ball around them. Its own point is one of them and also
/// that of one of its children, so the points of a level are among those of the next.
struct ShellNode {
  uint32_t first = 0, count = 0;             // points of the subtree
  uint32_t first_child = 0, n_children = 0;  // nodes of the next level; none on the finest
  uint32_t point = 0;
  float radius = 0;  // of a ball around that point with the subtree's points, rounded up [m]
};

/// Points on the surface of a tool with inward normals (McNeely, Puterbaugh, Troy 1999), in Morton
/// order, so that neighbours in space are neighbours in memory; in levels of resolution, each twice
/// as fine as the one before (Barbič & James 2008). In T.
template <template <class> class Array>
struct PointshellOf {
  double spacing = 0;       // approximate, of the points of the finest level [m]
  double radius = 0;        // of the ball around the origin of T that contains all points [m]
  Array<float> x, y, z;     // [m]
  Array<float> nx, ny, nz;  // unit
  Array<ShellNode> nodes;   // level by level, the root first
  Array<uint32_t> levels;   // first node of each level, then the number of nodes

  PointshellOf<ArrayView> view() const {
    return {spacing, radius, x, y, z, nx, ny, nz, nodes, levels};
  }
};
using Pointshell = PointshellOf<ArrayView>;
using PointshellData = PointshellOf<ArrayData>;

/// Bakes the shell; at start-up only. One point for each cube of edge `spacing` that the surface
/// passes: the sample nearest to its middle, of samples a third of the spacing apart, with the
/// inward normal of its face. Empty if the mesh is, or if a side has kMostCubes.
PointshellData build_pointshell(const TriangleMesh& mesh, double spacing);

}  // namespace haptic
