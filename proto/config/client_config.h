// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/config/config_names.h"
#include "proto/wire/wire.h"

namespace haptic {

/// ClientConfig::may, beside the objects that it may move.
enum ClientRight : uint32_t {
  kMayPush = 1u << 0,   // put a wrench on a tool
  kMayTouch = 1u << 1,  // give planes that tools touch
  kMayDraw = 1u << 2,   // show points and lines to viewers
};

/// A program that gives. Its index in the session file is its number in the rings.
struct ClientConfig {
  Name name{};
  Name user{};  // who may give beside the owner of the session; empty: nobody
  // of each of its objects, and of its wrench and planes together, on a hand, in units of the scene
  double max_force = 2;    // [N]
  double max_power = 0.2;  // that the hand is given, over a second [W]
  uint32_t n_moves = 0;
  uint32_t may = 0;                               // ClientRight
  std::array<uint32_t, kMostGivenMoves> moves{};  // objects that it may move
};

}  // namespace haptic
