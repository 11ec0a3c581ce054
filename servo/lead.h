// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

#include "proto/wire/mapping.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The pose in B at which a person who leads the simulated hand wants its handle: that at which the
/// tool is as the ControlFrame says. None: nobody leads, the last command is more than kLeadNs away
/// from now_ns, or it is not finite. The servo decides by its own clock, so a page or a bridge that
/// has stopped cannot hold the hand.
std::optional<Pose> led_handle(const DeviceMap& map, const Clutch& clutch,
                               const ControlFrame* control, int64_t now_ns);

}  // namespace haptic
