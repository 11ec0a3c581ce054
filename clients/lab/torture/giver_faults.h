// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "clients/lab/torture/fault_kinds.h"
#include "clients/lab/torture/faulty/fault_order.h"

/// Faults of a client that gives. What it moves is out of the hand's reach, so no force may change;
/// sim, contact and servo must live, and an honest client beside it must not notice. What it moves
/// itself must fade within the documented time, where its frames are refused or do not come.
namespace haptic {

/// Expected end of the object of a client: it must fade, or it may.
enum class GivenFade { kFades, kMayFade };

/// Starts a client, lets `fault` happen to it, and kills it.
Inflicted harm_giver(Torturer& torturer, GivenFade fade,
                     const std::function<void(SessionProcess& giver)>& fault);

template <int kSignal>
Inflicted fell_giver(Torturer& torturer) {
  return harm_giver(torturer, GivenFade::kFades,
                    [](SessionProcess& giver) { giver.send(kSignal); });
}

/// It lies until it is killed.
Inflicted mislead_giver(Torturer& torturer, GiverFault fault, GivenFade fade);
template <GiverFault kFault, GivenFade kFade = GivenFade::kFades>
Inflicted mislead_giver(Torturer& torturer) {
  return mislead_giver(torturer, kFault, kFade);
}

/// The client that moves the block which the hand presses: its force fades and comes back with it.
Inflicted fell_holder(Torturer& torturer);
Inflicted spoil_holder(Torturer& torturer);
Inflicted stop_holder(Torturer& torturer);
Inflicted mislead_holder(Torturer& torturer, GiverFault fault);
template <GiverFault kFault>
Inflicted mislead_holder(Torturer& torturer) {
  return mislead_holder(torturer, kFault);
}

}  // namespace haptic
