// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace haptic {

/// Solver of the proxy for 6-DoF renderers that may interpenetrate.
enum class SoftSolver : uint32_t {
  kDirect = 0,           // no proxy: the hand feels the contacts at its own pose
  kPenaltyDynamics = 1,  // a rigid body between coupling and contacts
  kQuasiStatic = 2       // a massless body, always in equilibrium
};

/// Their names, in a config and on the control socket, by number.
inline constexpr std::array<std::string_view, 3> kSoftSolverNames{"direct", "penalty-dynamics",
                                                                  "quasi-static"};

/// On the wire 0 stands for what the session's file says.
constexpr uint32_t number_of(SoftSolver solver) {
  return 1 + static_cast<uint32_t>(solver);
}
/// None for 0, and for a number of no solver.
constexpr std::optional<SoftSolver> soft_solver_of(uint32_t number) {
  if (number == 0 || number > kSoftSolverNames.size()) return std::nullopt;
  return static_cast<SoftSolver>(number - 1);
}

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
