// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/library/client.h"
#include "proto/ipc/give_message.h"
#include "proto/ipc/segment.h"

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

/// M⁻¹ of a body that is free to move: 1/mass, and the inverse of its moments about the axes of W;
/// zero moments: it does not turn.
std::array<double, 36> free_mobility(double mass, const Vec3& moments_W = {});
/// K or D that is alike in all directions: [N/m, N·m/rad], [N·s/m, N·m·s/rad].
std::array<double, 36> same_in_all_directions(double moving, double turning = 0);

/// Gives to a session under a name that a [[client]] of its file has (docs/clients-that-give.md).
///
///   Client client("give");
///   Giver giver(client, "give", "ball");
///   client.start();
///   const uint32_t ball = giver.object("ball");
///   while (client.is_connected()) {
///     const GivenPush push = giver.pushed(ball);   // since the last time
///     …                                            // integrate the object over push.span
///     giver.move({.X_WO = …, .mobility = …, .object = ball});
///     giver.publish();
///     client.sleep(0.01);
///   }
class Giver {
 public:
  /// Asks for the place and offers its segment. Before client.start(). Throws HandoutError with a
  /// remedy, SegmentError.
  Giver(Client& client, const std::string& session, const std::string& name);

  /// Gives its place up: what it moves fades.
  ~Giver();
  Giver(const Giver&) = delete;

  /// Number in the scene of an object that this client may move. Throws HandoutError.
  uint32_t object(std::string_view name) const;
  const std::vector<GivePlace::Object>& objects() const { return seat_.place.moves; }
  /// Its place, for a Drawer.
  const GiveSeat& seat() const { return seat_; }

  /// What has been pushed since the last call for this object, until instant_ns(). The first call
  /// begins to count.
  GivenPush pushed(uint32_t object);
  /// What the bodies of the session have pushed this object with since the last call, about its
  /// origin in W [N·s, N·m·s]; the first call begins to count.
  Wrench pushed_by_bodies(uint32_t object);
  /// The instant until which the last pushed() was told, CLOCK_MONOTONIC: that of the newest servo
  /// frame; now, where there is none.
  int64_t instant_ns() const { return instant_ns_; }

  /// Says how an object moves at the instant until which pushed() was told of it, which is filled
  /// in with its ticks; of an object that was never asked about, now.
  void move(GivenMotion motion);
  /// Publishes what has been said since the last time.
  void publish();

 private:
  struct Hand {
    RingSource<&ServoChannels::frames> frames;
    ServoFrame frame{};
    bool any = false;
  };
  /// How far an object's counters are used.
  struct Used {
    int64_t t_ns = 0;
    std::array<uint64_t, kMostHands> ticks{};
    std::array<int64_t, kMostHands> since_ns{};
    std::array<ObjectPush, kMostHands> pushes{};  // at t_ns
    std::optional<Wrench> by_bodies_W = {};
  };
  void look();

  GiveSeat seat_;
  SegmentWriter<ClientChannels> segment_;
  std::vector<Hand> hands_;
  RingSource<&SimChannels::frames> scenes_;
  SceneFrame scene_{};
  std::vector<Used> used_;  // by object
  int64_t instant_ns_ = 0;
  GivenFrame frame_{};
};

}  // namespace haptic
