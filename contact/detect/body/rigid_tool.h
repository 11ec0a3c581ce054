// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/detect/body/god_object6.h"
#include "proto/config/config.h"

namespace haptic {

/// What the renderers god-object6 and constrained6 need of a session; constant after start.
struct RigidToolModel {
  std::span<const MeshShape> objects;
  MeshShape tool;
  ToolBody body{};
  GodObject6Options options;
  std::array<double, kMaxObjects> crease_cosine{};  // smoother edges are shaded; 1: none
  bool has_friction = false;                        // of any object
};

GodObject6Options god_object_options(const SessionConfig& config, const ToolBody& body);

/// Leads the verified pose of a rigid tool after each ServoFrame and reports its contacts.
///
/// The god-object is led to the hand; where friction may hold it, and always with constrained
/// dynamics, to where the servo has its proxy: then contact sweeps from the last verified pose and
/// the servo projects back. Nothing is felt while the force is closed: the tool is placed where the
/// hand is, if it is free there. What begins inside is placed at the nearest free pose that is
/// found, and the set says so.
///
/// Where objects have gone on and no free way has led the tool after them, the set has the objects
/// where it is free of them. After 20 such steps nothing is felt, and that is said, until a way is
/// found, on the side of each object where the tool was last; or, half a second later, until the
/// hand is where the tool is free, and it begins there without a force.
class RigidTool {
 public:
  explicit RigidTool(const RigidToolModel& model);

  /// Fills in the pose, its contacts and flags; `reach` is how far ahead is looked [m].
  void answer(const RigidToolModel& model, const ServoFrame& servo, std::span<const Pose> X_WO,
              double reach, ContactSet& set);

  /// The pose is another renderer's: it is placed anew.
  void lose() { god_object_.lose(); }

 private:
  void place(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void wait(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void report(const RigidToolModel& model, const ServoFrame& servo, ContactSet& set);

  GodObject6 god_object_;
  int n_lost_ = 0;  // steps on end
};

}  // namespace haptic
