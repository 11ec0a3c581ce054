// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/math/vec3.h"
#include "proto/os/message.h"

namespace haptic {

/// One sample of a scanned surface: where the probe was and what it felt.
struct TrajSample {
  double t = 0;  // [s]
  Vec3 p_O;      // [m]
  Vec3 force_O;  // on the probe, from the surface outwards [N]
};

/// What is wrong with a .traj file: "file:line: what; how to mend".
struct TrajError : MessageError {
  using MessageError::MessageError;
};

/// Reads a trajectory as text: a sample a line, numbers apart by blanks, tabs or commas, empty
/// lines and what follows # ignored. Seven numbers are t x y z fx fy fz; six are x y z fx fy fz at
/// 1 kHz. SI units; time must grow. The form of the files that Ruffaldi et al. 2006 published is
/// not known to us: convert them to this one. Throws TrajError.
std::vector<TrajSample> parse_traj(std::string_view text, const std::string& origin);

/// The same from a file. Throws TrajError.
std::vector<TrajSample> read_traj(const std::string& path);

/// The same text, seven numbers with all their digits.
std::string write_traj(const std::vector<TrajSample>& samples);

/// One sample a millisecond over the whole recording, linear in between (forces and positions).
std::vector<TrajSample> at_one_kilohertz(const std::vector<TrajSample>& samples);

}  // namespace haptic
