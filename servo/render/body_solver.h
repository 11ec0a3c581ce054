// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "servo/render/render.h"
#include "servo/solve/body/god_object6.h"

/// The solvers of a tool with six degrees of freedom: the contacts at this tick, the proxy, the
/// coupling's wrench, and the step of it that the hand feels.
namespace haptic {

/// Largest rate at which the force changes apart from the hand's own motion [N/s]: half a newton a
/// tick at 1 kHz. At 4 N that is 12 % in one tick, twice the just noticeable difference of a force
/// at rest (Pang, Tan & Durlach 1991: 7 %), and a reversal of 4 N takes 16 ms, half a period of
/// 30 Hz, slower than what the skin is most sensitive to (250 Hz). A slower one would hold the
/// force of an edge that the hand has already left.
inline constexpr double kMostForceRate = 500;

/// The memory of limit_felt_step between ticks: the wrench that the hand felt and where it held the
/// tool, seen from the object that carried it.
struct FeltStep {
  bool started = false;
  uint32_t carrier = kNoBody;  // kNoBody: the world
  Pose X_CT;
  Wrench F_C;
};

struct WantedForce {
  Wrench F_W;                  // of the solver, at the tool's origin
  Pose X_WT;                   // of the tool in the hand
  uint32_t carrier = kNoBody;  // object that pushes the tool hardest
  double translational = 0;    // stiffness of the coupling [N/m]
  double rotational = 0;       // [N·m/rad]
  double dt = 1e-3;            // [s]
};

/// Limits the step of the force from the last tick to this one:
///   |F − F_last| ≤ k_T |Δhand| + kMostForceRate dt,
/// with the last wrench carried along with its object, Δhand the motion of the hand relative to
/// that object, and |F| = √(|f|² + |τ|² k_T/k_R), |Δ| = √(|v|² + |ω|² k_R/k_T) the lengths of the
/// coupling's metric. A longer step is shortened in its direction, so the result is a mean of two
/// forces: of two in one friction cone it lies in that cone. The spring of a coupling to a free
/// space at rest that is convex never reaches the limit, at any speed of the hand.
Wrench limit_felt_step(FeltStep& state, const WantedForce& step, std::span<const Pose> X_WO);

/// The tool that contact has baked, else the session's.
const ToolBody& tool_in_force(const ServoModel& model, const ContactSet& contacts);

/// The god-object of a tool that never enters an object.
struct GodObject6Solver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  GodObject6State state;
  FeltStep felt;
};

/// A body with mass that never enters an object.
struct Constrained6Solver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  Constrained6State state;
  FeltStep felt;
};

/// The proxy of a tool that may enter objects, by the session's solver.
struct SoftProxySolver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  SoftProxyState state;
  FeltStep felt;
};

}  // namespace haptic
