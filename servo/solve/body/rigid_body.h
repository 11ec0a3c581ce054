// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/wire.h"
#include "servo/solve/carried_contacts.h"

namespace haptic {

/// Stands for a tool that contact has not described yet: a ball of 5 cm and 100 g.
inline constexpr ToolBody kUnknownTool{0.1, {1e-4, 1e-4, 1e-4}, {}, 0.05};

/// Where a tool is and how it moves, as a rigid body. Frame C: origin at its centre of mass, axes
/// of the tool frame T.
struct BodyMotion {
  Pose X_WC;
  Twist V_WC;  // of the centre of mass
};

/// Motion of the tool at the origin of T, as the hand holds it or of its proxy.
struct ToolMotion {
  Pose X_WT;
  Twist V_WT;
};

/// A wrench on the body about C, in W, and its derivatives. A small motion is a translation of C
/// and a rotation vector, both in W, applied from the left: R' = exp([δθ]×) R.
struct BodyWrench {
  Wrench F_W;
  Mat6 by_motion;     // ∂F/∂(x, θ)
  Mat6 by_twist;      // ∂F/∂(v, ω)
  double energy = 0;  // stored in springs [J]
};

inline BodyMotion motion_of_centre(const ToolBody& body, const ToolMotion& tool) {
  const Vec3 arm_W = rotate(tool.X_WT.q, body.centre_T);
  return {{tool.X_WT.p + arm_W, tool.X_WT.q}, {velocity_at(tool.V_WT, arm_W), tool.V_WT.w}};
}

inline Pose tool_of_centre(const ToolBody& body, const Pose& X_WC) {
  return {X_WC.p - rotate(X_WC.q, body.centre_T), X_WC.q};
}

inline ToolMotion motion_of_tool(const ToolBody& body, const BodyMotion& centre) {
  const Vec3 arm_W = -rotate(centre.X_WC.q, body.centre_T);  // from C to the origin of T
  return {{centre.X_WC.p + arm_W, centre.X_WC.q}, {velocity_at(centre.V_WC, arm_W), centre.V_WC.w}};
}

/// The inertia about the centre of mass, in W, of a tool with this orientation.
inline Mat3 inertia_of(const ToolBody& tool, const Quat& q_WC) {
  const Mat3 R = to_matrix(q_WC);
  const Vec3& i = tool.inertia_T;
  const Mat3 scaled = from_columns(i.x * R.column(0), i.y * R.column(1), i.z * R.column(2));
  return scaled * transpose(R);
}

/// One tick of a solver of a body: the objects, the hand, and what is in force between them.
struct BodyTick : TickScene {
  ToolMotion hand;
  const ContactSet* contacts = nullptr;  // not null when it is solved
  double dt = 1e-3;                      // [s]
  ToolBody tool = kUnknownTool;
  Coupling coupling;
};

/// Result of one tick of a 6-DoF solver.
struct BodySolution {
  ToolMotion proxy;
  Wrench F_hand_W;                           // felt by the hand, at the tool's origin
  int n_pushing = 0;                         // contacts that push the proxy
  std::array<Wrench, kMaxObjects> push_W{};  // of each object on the proxy, at the tool's origin
  Vec3 held_back_W;                          // offset of the tool's origin that friction holds
  bool finite = true;                        // false: contacts not finite, nothing is rendered
  bool converged = true;
};

/// The motion scaled so that no point of the body moves farther than `travel` [m].
struct LimitedMotion {
  Twist motion;
  bool was_cut = false;
};
inline LimitedMotion limit_travel(const Twist& motion, double radius, double travel) {
  HAPTIC_ASSERT(travel >= 0);
  const double most = largest_travel(motion, radius);
  if (!(most > travel)) return {motion, false};
  const double share = travel / most;
  return {{share * motion.v, share * motion.w}, true};
}

}  // namespace haptic
