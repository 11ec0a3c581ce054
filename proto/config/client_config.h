// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/config/config_names.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A program that gives: it may move objects of the scene. Its index in the session file is its
/// number in the rings.
struct ClientConfig {
  Name name{};
  Name user{};             // who may give beside the owner of the session; empty: nobody
  double max_force = 2;    // of each of its objects on the hand, in units of the scene [N]
  double max_power = 0.2;  // that the hand is given, over a second [W]
  uint32_t n_moves = 0;
  uint32_t reserved = 0;
  std::array<uint32_t, kMostGivenMoves> moves{};  // objects that it may move
};

}  // namespace haptic
