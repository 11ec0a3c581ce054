// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace haptic {

/// Solver of the proxy for 6-DoF renderers that may interpenetrate.
enum class SoftSolver : uint32_t {
  kDirect = 0,           // no proxy: the hand feels the contacts at its own pose
  kPenaltyDynamics = 1,  // a rigid body between coupling and contacts
  kQuasiStatic = 2       // a massless body, always in equilibrium
};

/// Solver of the contacts of constrained6.
enum class RigidSolver : uint32_t {
  kCoulomb = 0,  // with friction
  kLcp = 1       // pivoting, without friction (Baraff 1994)
};

/// Integrator of a proxy with mass.
enum class Integrator : uint32_t {
  kExplicit = 0,      // Euler: positions by the old velocity; grows by √(1 + ω²h²) per step
  kSemiImplicit = 1,  // velocity first, positions by the new one; stable for ωh < 2
  kImplicit = 2       // linearised backward Euler; never grows
};

}  // namespace haptic
