// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/math/vec3.h"
#include "proto/os/message.h"

namespace haptic {

/// One sample of a scanned surface: position of the probe and the force on it.
struct TrajSample {
  double t = 0;  // [s]
  Vec3 p_O;      // [m]
  Vec3 force_O;  // on the probe, from the surface outwards [N]
};

/// An error in a .traj file: "file:line: what; how to mend".
struct TrajError : InputError {
  using InputError::InputError;
};

/// Reads a trajectory as text: one sample per line, numbers separated by blanks, tabs or commas;
/// empty lines and text after # are ignored. Seven numbers are t x y z fx fy fz; six are
/// x y z fx fy fz at 1 kHz. SI units; time must increase. Ruffaldi et al. 2006 do not document the
/// form of their files: convert them to this one. Throws TrajError.
std::vector<TrajSample> parse_traj(std::string_view text, const std::string& origin);

/// Reads such a file. Throws TrajError.
std::vector<TrajSample> read_traj(const std::string& path);

/// Resampled to one sample per millisecond; forces and positions are interpolated linearly.
std::vector<TrajSample> at_one_kilohertz(const std::vector<TrajSample>& samples);

}  // namespace haptic
