// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/woodenhaptics/woodenhaptics.h"
#include "tests/support/emulated_arm.h"

namespace haptic::test {

using EmulatedWoodenHaptics = EmulatedArm<WoodenHaptics>;

}  // namespace haptic::test
