// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace haptic {

/// Who answers for the proxy of a renderer with six degrees of freedom that may interpenetrate.
enum class SoftSolver : uint32_t {
  kDirect = 0,           // there is none: the hand feels the contacts of where it is
  kPenaltyDynamics = 1,  // a rigid body between coupling and contacts
  kQuasiStatic = 2       // a massless one, always in equilibrium
};

/// How a proxy with mass is moved by the forces on it.
enum class Integrator : uint32_t {
  kExplicit = 0,      // Euler: positions by the old velocity. Grows by √(1 + ω²h²) a step.
  kSemiImplicit = 1,  // velocity first, positions by the new one; stable for ωh < 2
  kImplicit = 2       // linearised backward Euler; never grows
};

}  // namespace haptic
