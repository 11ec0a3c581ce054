// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "clients/library/client.h"

namespace haptic {

/// What the hands have pushed an object with between two instants, as the force that is linear in
/// time and has the same impulse and the same integral of the impulse: about the object's origin,
/// in W. An object that is integrated with it moves as it was pushed, whatever the client's rate.
struct GivenPush {
  double span = 0;  // [s]; 0: nothing is known yet
  Wrench mean_W;    // [N, N·m]
  Wrench slope_W;   // [N/s, N·m/s]

  /// t [s] after the first instant.
  Wrench at(double t) const { return mean_W + (t - 0.5 * span) * slope_W; }
  Wrench impulse_W() const { return span * mean_W; }
};

/// Counts what the objects of a session are pushed with, from one look to the next, for a client
/// that integrates them.
class PushedObjects {
 public:
  /// Before client.start().
  explicit PushedObjects(Client& client);

  /// By hands, since the last call for this object, until instant_ns(). The first call begins to
  /// count.
  GivenPush by_hands(uint32_t object);
  /// By the bodies of the session, since the last call for this object, about its origin in W [N·s,
  /// N·m·s]; the first call begins to count.
  Wrench by_bodies(uint32_t object);
  /// The instant until which the last by_hands() was told, CLOCK_MONOTONIC: that of the newest
  /// servo frame; now, where there is none.
  int64_t instant_ns() const { return instant_ns_; }

  /// How far an object's counters are used.
  struct Used {
    int64_t t_ns = 0;  // 0: they are not
    std::array<uint64_t, kMostHands> ticks{};
    std::array<int64_t, kMostHands> since_ns{};
    std::array<ObjectPush, kMostHands> pushes{};  // at t_ns
    std::optional<Wrench> by_bodies_W = {};
  };
  Used& used(uint32_t object) { return used_.at(object); }

 private:
  struct Hand {
    RingSource<&ServoChannels::frames> frames;
    ServoFrame frame{};
    bool any = false;
  };
  void look();

  std::vector<Hand> hands_;
  RingSource<&SimChannels::frames> scenes_;
  SceneFrame scene_{};
  std::vector<Used> used_;  // by object
  int64_t instant_ns_ = 0;
};

}  // namespace haptic
