// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/wire/wire.h"

namespace haptic {

/// How far the counters of a hand have been used.
struct SeenCounters {
  int64_t t_ns = 0;                           // of the ServoFrame; 0: none yet
  int64_t since_ns = 0;                       // where its counters began
  std::array<SeenPush, kMaxBodies> pushes{};  // by response
};

/// What a hand has pushed an object with since then.
struct NewPush {
  Wrench impulse_W;  // ΔJ [N·s, N·m·s]
  // what an impulse that falls on the last scene's instant t₀ moves too far, as an integral:
  // S − S_seen − J_seen (t − t_seen) − ΔJ (t − t₀) [N·s², N·m·s²]
  Wrench late_W;
};
using NewPushes = std::array<NewPush, kMaxBodies>;  // by response

/// Every counter of the frame is finite.
bool has_finite_counters(const ServoFrame& frame);

/// Takes the counters of a frame over. `from_ns`: instant of the last scene. Counters of another
/// servo, or that are not finite, begin anew and push nothing.
NewPushes take_pushes(SeenCounters& seen, const ServoFrame& frame, int64_t from_ns);

/// Takes the counters over without a push: what they have grown by, where they go on from those of
/// `last`, is noted as forgotten.
void forget_pushes(SeenCounters& seen, const ServoFrame& frame, const SceneFrame& last,
                   uint32_t hand);

}  // namespace haptic
