// SPDX-License-Identifier: Apache-2.0
#include "clients/library/giver.h"

#include <sys/socket.h>

#include <algorithm>
#include <utility>

#include "proto/os/message.h"

namespace haptic {

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

GivenSegment::GivenSegment(GiveSeat seat)
    : seat_(std::move(seat)), segment_(seat_.place.generation, seat_.place.client) {
  offer_to_give(seat_, segment_spec<ClientChannels>(seat_.place.client), segment_.fd());
  segment_.set_state(SegmentState::kRun);
}

GivenSegment::~GivenSegment() {
  // a process that has forked, as hapticd of this program, has copies of the socket
  shutdown(seat_.socket.get(), SHUT_RDWR);
}

void GivenSegment::publish(const GivenFrame& frame) {
  segment_.channels().frames.publish(frame);
  segment_.beat(frame.seq, now_ns());
}

Giver::Giver(Client& client, const std::string& session, const std::string& name)
    : segment_(ask_to_give(session, name)), objects_(client) {}

uint32_t Giver::object(std::string_view name) const {
  std::vector<std::string_view> known;
  for (const GivePlace::Object& object : seat().place.moves) {
    if (object.name == name) return object.index;
    known.push_back(object.name);
  }
  throw HandoutError("this client may not move '" + shown(name) + "'; " + suggestion(name, known));
}

void Giver::move(GivenMotion motion) {
  PushedObjects::Used& used = objects_.used(motion.object);
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

void Giver::push(const GivenWrench& push) {
  const auto same = std::ranges::find(frame_.pushes, push.hand, &GivenWrench::hand);
  if (same != frame_.pushes.end()) {
    *same = push;
  } else if (!frame_.pushes.full()) {
    frame_.pushes.push_back(push);
  }
}

void Giver::touch(const GivenPlane& plane) {
  if (frame_.planes.full()) {
    throw HandoutError("touch: more than " + std::to_string(kMostGivenPlanes) +
                       " planes before publishing; give the nearest ones");
  }
  frame_.planes.push_back(plane);
}

void Giver::publish() {
  const bool may_touch = (seat().place.may & (kMayPush | kMayTouch)) != 0;
  if (frame_.moves.empty() && !may_touch) return;
  ++frame_.seq;
  frame_.t_ns = now_ns();
  segment_.publish(frame_);
  frame_.moves.clear();
  frame_.pushes.clear();
  frame_.planes.clear();
}

}  // namespace haptic
