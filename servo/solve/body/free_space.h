// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "servo/solve/coupled_body.h"

namespace haptic {

/// The poses of a tool at this tick that a contact set proves to be free: those for which no point
/// of the tool has moved farther relative to an object, since X_WG, than that object's clearance,
/// and which keep off the planes of clients, of which no clearance knows. Between two poses a point
/// moves no farther than the centre plus angle times radius of the tool. Poses are of the centre of
/// mass, C.
class FreeSpace {
 public:
  /// Set and scene must outlive this.
  FreeSpace(const ContactSet& set, const ToolBody& tool, const TickScene& scene);

  /// Distance every point may still move from X_WC without touching any object [m]; ≤ 0: the pose
  /// is not known to be free.
  double left_at(const Pose& X_WC) const;

  /// The last pose known to be free on the straight motion from X_WG to X_WC; empty if none is
  /// known or `otherwise` is nearer to X_WC.
  std::optional<Pose> nearest_to(const Pose& X_WC, const Pose& otherwise) const;

 private:
  double left_to_planes(const Pose& X_WC) const;

  const ContactSet& set_;
  const TickScene& scene_;
  const ToolBody& tool_;
  Pose X_WGC_;  // of the centre, at X_WG
};

}  // namespace haptic
