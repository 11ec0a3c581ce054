// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "contact/query/volume/shell_coherence.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"

namespace haptic {

/// A point of the shell that is nearer to the object than `reach`.
struct ShellTouch {
  uint32_t point = 0;
  uint32_t count = 1;   // number of points that it represents
  double distance = 0;  // to the object, signed [m]
};

/// Scratch: a node that the search could not exclude.
struct ShellVisit {
  uint32_t node = 0;
  double distance = 0;  // of its point; infinite if not looked up [m]
};

struct ShellQuery {
  double reach = 0;  // points nearer than this are reported; at most the band of the field [m]
  uint32_t budget = 0xffffffff;  // largest number of points looked up; the root always is
  // points nearer than this are reported one by one; of the others of a patch, the nearest
  // represents all points of the patch [m]
  double touch = std::numeric_limits<double>::infinity();
};

struct ShellAnswer {
  size_t n = 0;             // touches found
  uint32_t tested = 0;      // points looked up in the field
  size_t level = 0;         // the finest level completed
  bool is_complete = true;  // false: the budget (then coarser points represent the rest) or the
                            // room ended the search, or the pose is not finite
};

/// The points of a shell nearer to the object than `reach`, level by level from the root: a node is
/// excluded with its subtree if its point is farther than reach plus the radius of its ball (Barbič
/// & James 2008). Values of a field with cell size h at points s apart differ by at most √3 s (no
/// partial derivative of the interpolation exceeds that of a distance) and by at most s + √3 h; the
/// smaller bound is used, so free points are excluded in gaps of any width. A patch is a node two
/// levels above the points. If the budget ends, the result is the finest complete level, each of
/// whose points represents its subtree. However much the coherence knows, the answer is
/// bit-identical unless the budget ends the search. `visited`: scratch, the number of nodes of the
/// shell + 1. Points are stored in float and moved in double.
ShellAnswer find_touches(const DistanceField& field, const Pointshell& shell, const Pose& X_OT,
                         const ShellQuery& query, ShellCoherence& coherence,
                         std::span<ShellVisit> visited, std::span<ShellTouch> touches);

}  // namespace haptic
