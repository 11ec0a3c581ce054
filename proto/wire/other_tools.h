// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/wire/hands.h"
#include "proto/wire/per_object.h"
#include "proto/wire/scene_pose.h"
#include "proto/wire/wire.h"

/// The tools of other hands as objects of a hand's scene.
namespace haptic {

inline constexpr Vec3 kNowhere{0, 0, 1e3};  // where nothing touches them [m]

using ToolStiffnesses = UpTo<double, kMostHands>;  // [N/m]

inline SceneObject tool_at(const Vec3& p_W) {
  SceneObject tool{};
  tool.X_WO.p = p_W;
  tool.extrapolation_ns = kExtrapolationNs;
  tool.response = kNoResponse;
  return tool;
}

/// The tool of a hand, where that hand is.
inline SceneObject tool_of(const ServoFrame& frame) {
  SceneObject tool = tool_at(frame.X_WT.p);
  tool.X_WO.q = frame.X_WT.q;
  tool.V_WO = frame.V_WT;
  tool.t_ns = frame.t_ns;
  return tool;
}

/// Stiffness with which a tool holds against a push at t_ns; 0: its hand feels nothing, or its
/// servo has said nothing for 100 ms [N/m].
inline double stiffness_of_tool(const ServoFrame* frame, int64_t t_ns) {
  constexpr uint32_t kGivesWay = kServoClosed | kServoClutched | kServoStopped;
  const bool holds = frame != nullptr && (frame->flags & kGivesWay) == 0 &&
                     t_ns - frame->t_ns <= kMostExtrapolationNs;
  return holds ? frame->translational_stiffness : 0;
}

/// Brings a scene to where another hand has it: its pushes, and, where tools are objects, its tool
/// behind them. `frame` is the newest of that hand; null: it has said nothing yet.
inline void see_other_hand(SceneFrame& seen, uint32_t hand, const ServoFrame* frame,
                           bool has_tools) {
  if (frame != nullptr) add_pushes_of_other(seen, push_of(*frame, hand));
  // a ring may hold anything
  if (!has_tools || seen.objects.full()) return;
  seen.objects.push_back(frame != nullptr ? tool_of(*frame) : tool_at(kNowhere));
}

}  // namespace haptic
