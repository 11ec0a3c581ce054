// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "proto/math/pose.h"

namespace haptic {

/// Distance between the surfaces of a body and an object by CGAL's AABB tree, sharing no code with
/// the contact detectors.
class FreeOracle {
 public:
  /// A tool without triangles is a point at its origin.
  FreeOracle(const Soup& object, const Soup& tool);
  ~FreeOracle();
  FreeOracle(FreeOracle&&) noexcept;

  /// A lower bound of the distance with the tool at X_OT, at most a tenth below it; `enough` if it
  /// is at least that, 0 if it is below `least` [m]. For a body inside the other it is the distance
  /// of the surfaces.
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
  /// Pose of the tool, lower limit of interest and smallest distance so far.
  struct Search {
    const Pose& X_OT;
    double least, nearest;
  };
  void search(const Patch& patch_T, Search& search) const;

  std::unique_ptr<Object> object_;
  std::vector<Patch> patches_;  // triangles of the tool
  Vec3 centre_T_;
  double radius_ = 0;
};

}  // namespace haptic
