// SPDX-License-Identifier: Apache-2.0
#include "clients/library/pushed_objects.h"

#include <algorithm>

#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

/// The counters of an object at an instant: the impulse stays as it was at the frame's.
ObjectPush counted(const ServoFrame& frame, uint32_t response, int64_t t_ns) {
  if (response >= frame.pushes.size()) return {};
  ObjectPush push = frame.pushes[response];
  push.impulse_time_W = push.impulse_time_W + seconds_of(t_ns - frame.t_ns) * push.impulse_W;
  return push;
}

}  // namespace

PushedObjects::PushedObjects(Client& client)
    : scenes_(client.ring<&SimChannels::frames>(Start::kNewest)), used_(kMaxObjects) {
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    hands_.push_back({client.ring<&ServoChannels::frames>(Start::kNewest, hand)});
  }
}

void PushedObjects::look() {
  scenes_.latest(scene_);
  instant_ns_ = 0;
  for (Hand& hand : hands_) {
    hand.any |= hand.frames.latest(hand.frame);
    if (hand.any) instant_ns_ = std::max(instant_ns_, hand.frame.t_ns);
  }
  if (instant_ns_ == 0) instant_ns_ = now_ns();
}

GivenPush PushedObjects::by_hands(uint32_t object) {
  look();
  Used& used = used_.at(object);
  const uint32_t response =
      object < scene_.objects.size() ? scene_.objects[object].response : kNoResponse;
  GivenPush out;
  const double span = used.t_ns != 0 ? seconds_of(instant_ns_ - used.t_ns) : 0;
  Wrench impulse_W, lack_W;
  for (size_t h = 0; h < hands_.size(); ++h) {
    if (!hands_[h].any) continue;
    const ServoFrame& frame = hands_[h].frame;
    const ObjectPush now = counted(frame, response, instant_ns_);
    if (span > 0 && frame.impulses_since_ns == used.since_ns[h]) {
      const ObjectPush& before = used.pushes[h];
      const Wrench given_W = now.impulse_W + -before.impulse_W;
      impulse_W = impulse_W + given_W;
      // of the integral, what a constant force would lack or have too much
      lack_W = lack_W + now.impulse_time_W + -before.impulse_time_W + -span * before.impulse_W +
               -0.5 * span * given_W;
    }
    used.ticks[h] = frame.tick;
    used.since_ns[h] = frame.impulses_since_ns;
    used.pushes[h] = now;
  }
  used.t_ns = instant_ns_;
  if (!(span > 0)) return out;
  out.span = span;
  out.mean_W = 1 / span * impulse_W;
  out.slope_W = -12 / (span * span * span) * lack_W;
  return out;
}

Wrench PushedObjects::by_bodies(uint32_t object) {
  scenes_.latest(scene_);
  if (object >= scene_.objects.size()) return {};
  // those of clients are behind those of bodies
  const size_t first = scene_.responses.size() - scene_.world_pushes.size();
  const size_t place = scene_.objects[object].response - first;
  if (place >= scene_.world_pushes.size()) return {};
  const Wrench now_W = scene_.world_pushes[place].impulse_W;
  const Wrench before_W = used_.at(object).by_bodies_W.value_or(now_W);
  used_.at(object).by_bodies_W = now_W;
  return now_W + -before_W;
}

}  // namespace haptic
