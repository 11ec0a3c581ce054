// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/lab/eval/scenes/workload.h"
#include "clients/lab/support/scripted_hand.h"
#include "proto/math/units.h"

namespace haptic::test {

using haptic::flat_slide;
using haptic::plain_session;
using haptic::ScriptedHand;
using haptic::workload_depth;

}  // namespace haptic::test
