// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "proto/math/pose.h"

namespace haptic {

/// How far a body's surface is from an object's, by CGAL's tree of triangles: nothing of it is
/// shared with what detects contacts.
class FreeOracle {
 public:
  /// A tool without triangles is the point at its origin.
  FreeOracle(const Soup& object, const Soup& tool);
  ~FreeOracle();
  FreeOracle(FreeOracle&&) noexcept;

  /// A lower bound of the distance with the tool at X_OT, no more than a tenth below it, or
  /// `enough` where it is at least that, or 0 where it is below `least` [m]. A body that holds the
  /// other is as far as their surfaces are.
  double at_least(const Pose& X_OT, double least, double enough) const;

 private:
  struct Object;
  /// A part of the tool's surface within a ball.
  struct Patch {
    std::array<Vec3, 3> corners;
    Vec3 centre;
    double radius = 0;
  };
  static Patch patch_of(const std::array<Vec3, 3>& corners);
  /// Where the tool is, what the distance is looked for between, and what has been found.
  struct Search {
    const Pose& X_OT;
    double least, nearest;
  };
  void search(const Patch& patch_T, Search& search) const;

  std::unique_ptr<Object> object_;
  std::vector<Patch> patches_;  // of the tool, the whole of it around the first
  Vec3 centre_T_;
  double radius_ = 0;
};

}  // namespace haptic
