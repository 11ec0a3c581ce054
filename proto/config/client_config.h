// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

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

/// True if this client may give all that a frame of it holds.
inline bool may_give(const ClientConfig& client, const GivenFrame& given) {
  const auto moves = std::span(client.moves).first(client.n_moves);
  const auto may_move = [&](const GivenMotion& said) {
    return std::ranges::find(moves, said.object) != moves.end();
  };
  return (given.pushes.empty() || (client.may & kMayPush) != 0) &&
         (given.planes.empty() || (client.may & kMayTouch) != 0) &&
         std::ranges::all_of(given.moves, may_move);
}

}  // namespace haptic
