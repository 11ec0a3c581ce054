// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pthread.h>

namespace haptic {

/// Gives the calling thread the real-time scheduling of another one, one priority above: an answer
/// of a device that is late is worth more than a tick that has nothing to say. Does nothing if the
/// other has none, or the right is missing, which the servo has reported by then.
void follow_scheduling_of(pthread_t other);

}  // namespace haptic
