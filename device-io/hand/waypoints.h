// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/hand/intended_motion.h"
#include "proto/config/device_config.h"

namespace haptic {

/// The intended motion along the waypoints t seconds after the start: it rests at each, goes on to
/// the next straight and by the shorter turn about one axis, with the minimum-jerk progress of
/// `time`, and stays at the last. C¹, a pure function of time, of exactly rounded operations only.
/// There must be a waypoint.
Intent along_waypoints(const IntentConfig& config, double t);

}  // namespace haptic
