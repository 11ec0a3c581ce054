// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/wire.h"
#include "servo/solve/carried_contacts.h"

/// The virtual coupling between the hand and its proxy, a point or a tool as a rigid body; and the
/// tick as a solver of a body is asked about it.
namespace haptic {

/// Force of the virtual coupling on the tool of a massless 3-DoF proxy, at the tool's origin, in W:
///   f = max(k_T |s| + share b_T (v_P − v_T)·ŝ, 0) ŝ,  s = x_P − x_T,  ŝ = s/|s|
/// The damper acts along the spring only: it brakes the stretching and never drags sideways. The
/// force never pushes the tool away from the proxy. Sources: Colgate, Stanley, Brown 1995; damping
/// as in Zilles & Salisbury 1995. The port is passive for device damping b > s·φ·k_T·dt/2 + s·φ·b_T
/// (Colgate & Schenkel 1997).
struct CouplingInput {
  Vec3 tool_W;
  Vec3 proxy_W;
  Vec3 tool_velocity_W;
  Vec3 proxy_velocity_W;
  double share = 1;  // of the damper, 0 to 1: it must fade along with the spring
};
Vec3 coupling_force(const Coupling& coupling, const CouplingInput& input);

/// Stands for a tool that contact has not described yet: a ball of 5 cm and 100 g.
inline constexpr ToolBody kUnknownTool{0.1, {1e-4, 1e-4, 1e-4}, {}, 0.05};

/// Pose and velocity of a tool as a rigid body. Frame C: origin at its centre of mass, axes
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
  explicit BodySolution(const BodyTick& tick) : proxy(tick.hand), push_W(tick.X_WO.size()) {}

  ToolMotion proxy;
  Wrench F_hand_W;           // felt by the hand, at the tool's origin
  int n_pushing = 0;         // contacts that push the proxy
  PerObject<Wrench> push_W;  // of each object on the proxy, at the tool's origin
  Vec3 held_back_W;          // offset of the tool's origin that friction holds
  bool finite = true;        // false: contacts not finite, nothing is rendered
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

/// The coupling with springs that a metric can be made of, for a tool of this radius [m].
Coupling with_least_springs(Coupling coupling, double radius);

/// diag(k_T, k_R), factored; none of them may be zero.
MotionMetric spring_metric(const Coupling& coupling);

/// Wrench of the coupling on the proxy about its centre of mass C, in W, with its Jacobians:
///   f = sat(k_T s) + b_T (v_T − v_P),  s = x_T − x_P between the two tool origins,
///   τ = sat(k_R θ) + b_R (ω_T − ω_P),  θ the rotation vector of R_T R_Pᵀ along the shorter arc,
/// f acting at the proxy's tool origin; sat bounds the length. Colgate, Stanley, Brown 1995;
/// McNeely, Puterbaugh, Troy 1999 (saturation).
BodyWrench coupling_wrench(const Coupling& coupling, const ToolBody& body, const ToolMotion& hand,
                           const BodyMotion& proxy);

/// As coupling_wrench, but the Jacobian by motion is symmetric and negative semidefinite, for
/// solvers that need a metric: derivatives of the lever arm and of the springs' directions by
/// rotation are left out.
BodyWrench symmetric_coupling_wrench(const Coupling& coupling, const ToolBody& body,
                                     const ToolMotion& hand, const BodyMotion& proxy);

/// Energy stored in the springs [J], the same as coupling_wrench gives.
double coupling_energy(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy);

/// Wrench the hand feels: −f and −τ, at the origin of the tool as the hand holds it. The springs' f
/// lies along the line between the two origins, so shifting it there adds no moment; the small
/// moment of the damper across that line is neglected. Exactly zero where both coincide and move as
/// one.
Wrench wrench_on_hand(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy);

}  // namespace haptic
