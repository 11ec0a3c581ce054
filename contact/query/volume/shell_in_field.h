// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "contact/query/volume/shell_coherence.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"

namespace haptic {

/// A point of the shell that is inside the object, or near it.
struct ShellTouch {
  uint32_t point = 0;
  uint32_t count = 1;   // points that it stands for
  double distance = 0;  // to the object, signed [m]
};

/// Room for a node that could not be left out of this search.
struct ShellVisit {
  uint32_t node = 0;
  double distance = 0;  // of its point; infinite where that was not looked up [m]
};

struct ShellQuery {
  double reach = 0;              // points nearer than this are reported; at most the band [m]
  uint32_t budget = 0xffffffff;  // of points that may be looked up, the root's always
  // points nearer than this one by one, of the others of a patch the nearest for all below it [m]
  double touch = std::numeric_limits<double>::infinity();
};

struct ShellAnswer {
  size_t n = 0;             // touches found
  uint32_t tested = 0;      // points looked up in the field
  size_t level = 0;         // the finest one completed
  bool is_complete = true;  // false: out of budget (coarser points stand for the rest) or of room,
                            // or the pose is not finite
};

/// The points of a shell nearer to the object than `reach`, level by level from the root: a node
/// whose point is further away than its ball reaches is left out with all that is below (Barbič &
/// James 2008). What a field of cells h says at two points s apart differs by no more than √3 s (no
/// partial derivative of the interpolation exceeds that of a distance) nor than s + √3 h: the
/// smaller holds, so points that are free stay out however narrow the gap. A patch is a node two
/// levels above the points. Out of budget the search ends with the finest level that is complete,
/// and each of its points stands for all below it. With coherence the answer is the same to the
/// bit, unless the budget ends it. `visited` is scratch for one more node than the shell has.
/// Points are those of the shell in float, moved in double.
ShellAnswer find_touches(const DistanceField& field, const Pointshell& shell, const Pose& X_OT,
                         const ShellQuery& query, ShellCoherence* coherence,
                         std::span<ShellVisit> visited, std::span<ShellTouch> touches);

}  // namespace haptic
