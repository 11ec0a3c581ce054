// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/eval/scenes/workload.h"
#include "clients/lab/scripted_hand.h"

namespace haptic::test {

inline constexpr double kPi = std::numbers::pi;
using haptic::flat_slide;
using haptic::plain_session;
using haptic::ScriptedHand;
using haptic::workload_depth;

}  // namespace haptic::test
