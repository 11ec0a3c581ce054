// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/lab/stability/probe.h"

namespace haptic {

/// The oscillation of a handle in a wall after a small knock.
struct Ringing {
  double rest = 0;   // how deep the press would be at rest, in the coupling [m or rad]
  double early = 0;  // peak to peak between 1 and 2 s after the knock [m or rad]
  double late = 0;   // peak to peak in the last second
  double step = 0;   // of the encoder; 0: none
};

/// Seconds from the knock to the end; the last of them is judged.
inline constexpr double kRinging = 5;

/// Presses the handle on the block with kPress and knocks it, such that it swings by a fifth of
/// its depth, and by five steps of the encoder at least, for friction holds a smaller swing at any
/// stiffness; in lockstep through the servo's own step. A handle that turns rests flat, and the
/// knock turns it by a fifth of what tips the cube over.
Ringing ring(const ProbeScene& scene, const ProbeSetting& setting);

/// True if the oscillation dies out. It is sustained where it has, in the last second,
///  - more than half of the amplitude at which contact is lost, or
///  - more than three steps of the encoder or a tenth of the press (without an encoder: a
///  thousandth
///    of the press), peak to peak, and is not smaller than before. With an encoder it must be so by
///    a tenth, for a limit cycle is never steady to the last bit.
bool dies_out(const Ringing& ringing);

/// A limit found by bisection.
struct LargestStiffness {
  double stiffness = 0;        // [N/m or N·m/rad]; 0: none is stable
  bool is_at_the_end = false;  // even the stiffest that is tried is stable
};

/// The largest stiffness whose oscillation dies out, within half a percent; `setting.stiffness` is
/// not used. It doubles from a fifth of gil_limit() until it rings, then bisects: where the stable
/// stiffnesses have gaps, it is below the first.
LargestStiffness largest_stiffness(const ProbeScene& scene, ProbeSetting setting);

/// (b + B)/(T/2 + t_d), for small b T/m and B T/m; hand and device together (Gil et al. 2009).
double gil_limit(const ProbeSetting& setting);

/// min(2b/T, 2c/Δ) with the device's own damping and friction: what is rendered without damping and
/// without delay is then passive (Abbott & Okamura 2005). 2b/T without an encoder.
double abbott_okamura_limit(const ProbeSetting& setting);

}  // namespace haptic
