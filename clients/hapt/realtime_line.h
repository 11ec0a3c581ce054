// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/ipc/segment.h"

namespace haptic {

/// One line for people on which real-time rights this servo has, which it lacks, and why. Null: no
/// servo was seen.
std::string realtime_line(const SegmentHeader* servo);

}  // namespace haptic
