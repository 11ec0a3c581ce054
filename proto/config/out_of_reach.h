// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/config/session_config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Bodies that have left the scene: sim holds them where [sim] reach ended.
struct OutOfReach {
  uint32_t bodies = 0;
  double reach = 0;  // from a body's place at the start [m]
};

/// Counts the objects with mass that a frame of sim has beyond reach (is_out_of_reach).
OutOfReach out_of_reach(const SessionConfig& config, const SceneFrame& scene);

/// "2 bodies out of reach (1 m)"; empty: none.
std::string out_of_reach_text(const OutOfReach& gone);

/// How to keep them in the scene.
inline constexpr const char* kMendOutOfReach = "raise reach in [sim], or put a floor below";

/// The text and how to mend it in one line: "2 bodies out of reach (1 m): raise …"; empty: none.
std::string out_of_reach_line(const OutOfReach& gone);

}  // namespace haptic
