// SPDX-License-Identifier: Apache-2.0
#include "clients/library/giver.h"

#include <sys/socket.h>

#include <algorithm>

#include "proto/os/message.h"
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

std::array<double, 36> free_mobility(double mass, const Vec3& moments_W) {
  std::array<double, 36> mobility{};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<size_t>(7 * i);
    mobility[at] = 1 / mass;
    if (moments_W[i] != 0) mobility[at + 21] = 1 / moments_W[i];
  }
  return mobility;
}

std::array<double, 36> same_in_all_directions(double moving, double turning) {
  std::array<double, 36> matrix{};
  for (size_t i = 0; i < 6; ++i) matrix[7 * i] = i < 3 ? moving : turning;
  return matrix;
}

Giver::Giver(Client& client, const std::string& session, const std::string& name)
    : seat_(ask_to_give(session, name)),
      segment_(seat_.place.generation, seat_.place.client),
      scenes_(client.ring<&SimChannels::frames>(Start::kNewest)),
      used_(kMaxObjects) {
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    hands_.push_back({client.ring<&ServoChannels::frames>(Start::kNewest, hand)});
  }
  offer_to_give(seat_, segment_spec<ClientChannels>(seat_.place.client), segment_.fd());
  segment_.set_state(SegmentState::kRun);
}

Giver::~Giver() {
  // a process that has forked has copies of the socket
  shutdown(seat_.socket.get(), SHUT_RDWR);
}

uint32_t Giver::object(std::string_view name) const {
  std::vector<std::string_view> known;
  for (const GivePlace::Object& object : seat_.place.moves) {
    if (object.name == name) return object.index;
    known.push_back(object.name);
  }
  throw HandoutError("this client may not move '" + shown(name) + "'; " + suggestion(name, known));
}

void Giver::look() {
  scenes_.latest(scene_);
  instant_ns_ = 0;
  for (Hand& hand : hands_) {
    hand.any |= hand.frames.latest(hand.frame);
    if (hand.any) instant_ns_ = std::max(instant_ns_, hand.frame.t_ns);
  }
  if (instant_ns_ == 0) instant_ns_ = now_ns();
}

GivenPush Giver::pushed(uint32_t object) {
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

Wrench Giver::pushed_by_bodies(uint32_t object) {
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

void Giver::move(GivenMotion motion) {
  Used& used = used_.at(motion.object);
  if (used.t_ns == 0) pushed(motion.object);
  motion.ticks = used.ticks;
  motion.t_ns = used.t_ns;
  // sim takes what answers a push only with the tick whose pushes it has
  if (std::ranges::none_of(motion.ticks, [](uint64_t tick) { return tick != 0; })) {
    used.t_ns = 0;
    return;
  }
  const auto same = std::ranges::find(frame_.moves, motion.object, &GivenMotion::object);
  if (same != frame_.moves.end()) {
    *same = motion;
  } else if (!frame_.moves.full()) {
    frame_.moves.push_back(motion);
  }
}

void Giver::publish() {
  if (frame_.moves.empty()) return;
  ++frame_.seq;
  frame_.t_ns = now_ns();
  segment_.channels().frames.publish(frame_);
  segment_.beat(frame_.seq, frame_.t_ns);
  frame_.moves.clear();
}

}  // namespace haptic
