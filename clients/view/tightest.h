// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/math/pose.h"

namespace haptic {

/// The place of a recording at which the tool came nearest to an object, as `hapt clearance --json`
/// has measured it; drawn by the page.
struct TightestPlace {
  uint32_t object = 0;
  std::string name;     // of the object
  uint64_t tick = 0;    // of the recording
  double t = 0;         // since its first frame [s]
  double distance = 0;  // [m]; 0: they meet
  Vec3 tool_point_W, object_point_W;
  Pose X_WT;
};

/// The tightest place in the text that `hapt clearance --json` prints. `file` is named in messages.
/// Throws InputError.
TightestPlace parse_tightest(std::string_view text, const std::string& file);

/// Reads such a file. Throws InputError.
TightestPlace read_tightest(const std::string& path);

/// "The tool is nearest to 'opening' at 3.41 s: 1.23 mm".
std::string words_of(const TightestPlace& place);

}  // namespace haptic
