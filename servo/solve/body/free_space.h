// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "servo/solve/body/rigid_body.h"

namespace haptic {

/// The poses of a tool at this tick that nothing pushes, as a contact set proves: those to which no
/// point of the tool, at X_WG when the set was asked for, has moved further against an object than
/// that object's clearance. Between two poses a point moves no further than the tool's centre does,
/// plus the angle times the tool's radius. Poses are those of the centre of mass, C.
class FreeSpace {
 public:
  /// X_WO: of the objects at this tick. The set must outlive it.
  FreeSpace(const ContactSet& set, const RigidBody& tool,
            const std::array<Pose, kMaxObjects>& X_WO);

  /// How far every point may still move from there, against any object [m]; not above 0: the pose
  /// is not known to be free.
  double left_at(const Pose& X_WC) const;

  /// The free pose nearest to one that is not, on the way there from X_WG; empty where none is
  /// known, or `otherwise` is nearer.
  std::optional<Pose> nearest_to(const Pose& X_WC, const Pose& otherwise) const;

 private:
  const ContactSet& set_;
  const std::array<Pose, kMaxObjects>& X_WO_;
  Pose X_WGC_;     // the centre at X_WG
  double radius_;  // of the tool [m]
};

}  // namespace haptic
