// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/wire.h"

namespace haptic {

/// Sends a device's zero force over its node, which may be a duplicate of one that a dead or
/// stopped process drives. True if the device's port took it. Takes at most kReleaseWaitMs; a full
/// queue is a failure, after which the next attempt or the firmware's own watchdog takes over.
///
/// On USB the interface is released first, which cancels every transfer in flight and waits for its
/// end, and claimed again; the duplicate holds the claim of the process that opened it, which would
/// otherwise keep everybody else out.
bool send_release(int node, const DeviceRelease& release) noexcept;

inline constexpr unsigned kReleaseWaitMs = 5;  // a packet takes 1 ms, and the next one is due then

}  // namespace haptic
