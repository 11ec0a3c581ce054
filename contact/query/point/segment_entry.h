// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace haptic {

/// The place where a segment enters a mesh.
struct SegmentHit {
  bool hit = false;
  double t = 1;  // fraction of the way from → to, in [0, 1]
  uint32_t triangle = 0;
};

}  // namespace haptic
