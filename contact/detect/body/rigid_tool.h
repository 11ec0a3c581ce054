// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/detect/body/god_object6.h"
#include "proto/config/config.h"

namespace haptic {

/// Constant data of the renderers god-object6 and constrained6.
struct RigidToolModel {
  std::span<const MeshShape> objects;
  MeshShape tool;
  ToolBody body{};
  GodObject6Options options;
  std::array<double, kMaxObjects> crease_cosine{};  // edges that turn by less are shaded; 1: none
  bool has_friction = false;                        // any object has friction
};

GodObject6Options god_object_options(const SessionConfig& config, const ToolBody& body);

/// Moves the verified pose of a rigid tool after each ServoFrame, and reports its contacts.
///
/// The target of the god-object is the hand; with friction, and always with constrained dynamics,
/// it is the servo's proxy: then contact sweeps from the last verified pose, and the servo projects
/// back. While the force is off the tool is placed at the hand if it is free there. A start inside
/// an object is moved to the nearest free pose found, which the set reports.
///
/// If the objects have moved on without a free path for the tool, the set shows the objects where
/// the tool is free of them. After 20 such steps the force is zero, and the set says so, until a
/// path is found, on the side of each object where the tool was last; or, half a second later,
/// until the tool is free at the hand, where it restarts without a force.
class RigidTool {
 public:
  explicit RigidTool(const RigidToolModel& model);

  /// Fills in the pose, its contacts and flags; `reach`: look-ahead [m].
  void answer(const RigidToolModel& model, const ServoFrame& servo, std::span<const Pose> X_WO,
              double reach, ContactSet& set);

  /// Another renderer has taken over: the next answer places the tool anew.
  void lose() { god_object_.lose(); }

 private:
  void place(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void wait(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void report(const RigidToolModel& model, const ServoFrame& servo, ContactSet& set);

  GodObject6 god_object_;
  int n_lost_ = 0;  // consecutive steps
};

}  // namespace haptic
