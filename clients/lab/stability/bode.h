// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "clients/lab/stability/probe.h"

namespace haptic {

/// Impedance of the wall at one frequency: force or torque that opposes the motion, over velocity.
struct BodePoint {
  double frequency;               // [Hz]
  std::complex<double> intended;  // b_c + k_c/(jω) [N·s/m or N·m·s/rad]
  std::complex<double> rendered;

  std::complex<double> ratio() const { return rendered / intended; }
};

struct Bode {
  std::vector<BodePoint> points;  // by frequency
  /// The force at even multiples of the lowest frequency, which the motion lacks, over the force at
  /// the frequencies of the motion; root mean squares. 0: the wall is linear.
  double distortion = 0;
};

/// Measures the impedance that the servo renders: the handle is led into the block and moved there
/// by a sum of sines, about half as far as to the surface, in lockstep through the servo's own
/// step; the wrench that the motors hold over each tick, as the continuous signal that it is, is
/// compared with the motion by their Fourier coefficients. The sines are odd multiples of a
/// thousandth of the servo's rate up to nine tenths of half of it, about evenly spaced in the
/// logarithm, with Schroeder's phases, which keep the sum from having peaks (Schroeder 1970).
/// Nothing moves by the force, so a coupling that no hand could hold is measured as well; hand and
/// device have no part in it except the encoder and the filter of the velocity. `periods` of a
/// thousand ticks are averaged.
Bode measure_bode(const ProbeScene& scene, const ProbeSetting& setting, int periods);

}  // namespace haptic
