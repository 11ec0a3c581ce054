// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/library/client.h"
#include "clients/library/pushed_objects.h"
#include "proto/ipc/give_message.h"
#include "proto/ipc/segment.h"

namespace haptic {

/// M⁻¹ of a body that is free to move: 1/mass, and the inverse of its moments about the axes of W;
/// zero moments: it does not turn.
std::array<double, 36> free_mobility(double mass, const Vec3& moments_W = {});
/// K or D that is alike in all directions: [N/m, N·m/rad], [N·s/m, N·m·s/rad].
std::array<double, 36> same_in_all_directions(double moving, double turning = 0);

/// A place of a client in a session, and the segment that it gives in, until it ends.
class GivenSegment {
 public:
  /// Offers the segment. Throws HandoutError, SegmentError.
  explicit GivenSegment(GiveSeat seat);
  ~GivenSegment();
  GivenSegment(const GivenSegment&) = delete;

  const GiveSeat& seat() const { return seat_; }
  void publish(const GivenFrame& frame);

 private:
  GiveSeat seat_;
  SegmentWriter<ClientChannels> segment_;
};

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
  /// Asks for the place and offers its segment; at its end all that it gives fades. Before
  /// client.start(). Throws HandoutError with a
  /// remedy, SegmentError.
  Giver(Client& client, const std::string& session, const std::string& name);

  Giver(const Giver&) = delete;

  /// Number in the scene of an object that this client may move. Throws HandoutError.
  uint32_t object(std::string_view name) const;
  const std::vector<GivePlace::Object>& objects() const { return seat().place.moves; }
  /// Its place, for a Drawer.
  const GiveSeat& seat() const { return segment_.seat(); }

  /// What has been pushed since the last call for this object (PushedObjects).
  GivenPush pushed(uint32_t object) { return objects_.by_hands(object); }
  Wrench pushed_by_bodies(uint32_t object) { return objects_.by_bodies(object); }
  int64_t instant_ns() const { return objects_.instant_ns(); }

  /// Says how an object moves at the instant until which pushed() was told of it, which is filled
  /// in with its ticks; of an object that was never asked about, now.
  void move(GivenMotion motion);
  /// Puts a wrench on a hand's tool, which it may pull with, until the next frame: the right
  /// "push".
  void push(const GivenWrench& push);
  /// A plane that a hand's tool does not pass until the next frame: the right "touch". Throws
  /// HandoutError: a frame holds no more (kMostGivenPlanes).
  void touch(const GivenPlane& plane);
  /// Publishes all that has been said since the last time; wrenches and planes that were not said
  /// again are gone.
  void publish();

 private:
  GivenSegment segment_;
  PushedObjects objects_;
  GivenFrame frame_{};
};

}  // namespace haptic
