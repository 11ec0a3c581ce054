// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-faulty-giver SESSION CLIENT X Y Z [flood]: moves the one object of a client, which stands
// at that place and answers pushes, a hundred times a second; and lies on order, or floods from the
// beginning, with pushes and planes too. For hapt torture and hapt bench givers.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <random>
#include <string_view>

#include "clients/lab/torture/faulty/fault_order.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/give_message.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/priorities.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 10 * kMs;
constexpr int kFloodFrames = 4;        // in each millisecond: the same again within a look of sim
constexpr size_t kGarbageWords = 512;  // in each millisecond
constexpr double kMobility = 10;       // of 100 g [1/kg]

/// Makes a frame that moves an object, as an honest client does.
GivenFrame healthy_frame(uint32_t object, const Vec3& place, const ServoFrame& servo,
                         double mobility) {
  GivenFrame frame{};
  frame.t_ns = now_ns();
  GivenMotion motion{};
  motion.object = object;
  motion.X_WO.p = place;
  motion.t_ns = servo.t_ns;
  motion.ticks[0] = servo.tick;
  for (size_t i = 0; i < 3; ++i) motion.mobility[7 * i] = mobility;
  frame.moves.push_back(motion);
  return frame;
}

/// A push of no force, and planes a metre below everything.
void add_all(GivenFrame& frame, uint64_t n) {
  GivenWrench push{};
  push.wrench.X_WT.q = {0, 0, 0, 1};
  push.wrench.trust_radius = 1;
  frame.pushes.push_back(push);
  GivenPlane plane{};
  plane.object_point_O = {0, 0, -1};
  plane.normal_O = {0, 0, 1};
  plane.object = kNoObject;
  for (uint64_t i = 0; i < n % (kMostGivenPlanes + 1); ++i) {
    plane.feature = i;
    frame.planes.push_back(plane);
  }
}

/// Puts a value in place of the n-th number of a statement, and of the wrench and the first plane
/// beside it.
void spoil_number(GivenFrame& frame, size_t n, double value) {
  const auto spoil = [&](auto& record, size_t first, size_t end) {
    const size_t at = 8 * (first + n % (end - first));
    std::memcpy(reinterpret_cast<std::byte*>(&record) + at, &value, sizeof value);
  };
  spoil(frame.moves[0], offsetof(GivenMotion, X_WO) / 8, offsetof(GivenMotion, object) / 8);
  for (GivenWrench& push : frame.pushes) spoil(push, 0, offsetof(GivenWrench, hand) / 8);
  if (!frame.planes.empty()) spoil(frame.planes[0], 0, offsetof(GivenPlane, feature) / 8);
}

void tell_lie(GiverFault fault, uint64_t n, GivenFrame& frame) {
  GivenMotion& motion = frame.moves[0];
  switch (fault) {
    case GiverFault::kNaN:
      return spoil_number(frame, n, std::numeric_limits<double>::quiet_NaN());
    case GiverFault::kHuge:
      return spoil_number(frame, n, n % 2 == 0 ? 1e300 : -1e300);
    case GiverFault::kUnturned:
      motion.X_WO.q = {0, 0, 0, n % 2 == 0 ? 0 : 1 + 1e-3 * static_cast<double>(n)};
      for (GivenWrench& push : frame.pushes) push.wrench.X_WT.q = motion.X_WO.q;
      return;
    case GiverFault::kBackwards:
      frame.seq -= std::min(frame.seq, 3 * n);
      frame.t_ns -= static_cast<int64_t>(n) * kPeriodNs;
      motion.t_ns -= static_cast<int64_t>(n) * kPeriodNs;
      motion.ticks[0] -= std::min(motion.ticks[0], 11 * n);
      return;
    case GiverFault::kFlood:  // half of its frames, as the dice fall
    case GiverFault::kHealthy:
    case GiverFault::kGarbage:
      return;
  }
}

/// Whoever maps a segment must expect this of it.
void write_garbage(SegmentWriter<ClientChannels>& segment, std::mt19937_64& random) {
  auto* words = reinterpret_cast<uint64_t*>(const_cast<SegmentHeader*>(&segment.header()));
  constexpr size_t kWords = sizeof(SegmentLayout<ClientChannels>) / 8;
  constexpr size_t kHead = 4096 / 8;  // header, counts and the first slots, where it hurts most
  for (size_t i = 0; i < kGarbageWords; ++i) {
    const size_t at = random() % (i % 2 == 0 ? kHead : kWords);
    // a small number is more often believed
    words[at] = random() >> (random() % 64);
  }
}

class FaultyGiver {
 public:
  FaultyGiver(const std::string& session, const std::string& client, const Vec3& place,
              std::string_view how)
      : place_(place),
        mobility_(how == "still" ? 0 : kMobility),
        fault_(how == "flood" ? GiverFault::kFlood : GiverFault::kHealthy),
        attachments_(connect_session(session)),
        servo_(attachments_.ring<&ServoChannels::frames>(Start::kNewest)),
        seat_(ask_to_give(session, client)),
        segment_(seat_.place.generation, seat_.place.client) {
    attachments_.start();
    offer_to_give(seat_, segment_spec<ClientChannels>(seat_.place.client), segment_.fd());
    segment_.set_state(SegmentState::kRun);
  }

  void run() {
    int64_t next_ns = now_ns();
    for (uint64_t n = 1; attachments_.is_connected(); ++n) {
      const bool is_fast = fault_ == GiverFault::kFlood || fault_ == GiverFault::kGarbage;
      sleep_until(next_ns += is_fast ? kMs : kPeriodNs);
      if (const int order = take_order(); order != 0) fault_ = static_cast<GiverFault>(order);
      if (fault_ == GiverFault::kGarbage) {
        write_garbage(segment_, random_);
        continue;  // its own ring is no ring any more
      }
      servo_.latest(servo_frame_);
      if (servo_frame_.t_ns == 0) continue;
      const int n_frames = fault_ == GiverFault::kFlood ? kFloodFrames : 1;
      for (int i = 0; i < n_frames; ++i) publish(n + static_cast<uint64_t>(i));
    }
  }

 private:
  void publish(uint64_t n) {
    GivenFrame frame =
        healthy_frame(seat_.place.moves.at(0).index, place_, servo_frame_, mobility_);
    frame.seq = ++seq_;
    add_all(frame, n);
    tell_lie(fault_, n, frame);
    if (fault_ == GiverFault::kFlood && random_() % 2 == 0) spoil_number(frame, n, 1e300);
    segment_.channels().frames.publish(frame);
    segment_.beat(seq_, now_ns());
  }

  Vec3 place_;
  double mobility_;
  GiverFault fault_;
  Attachments attachments_;
  RingSource<&ServoChannels::frames> servo_;
  ServoFrame servo_frame_{};
  GiveSeat seat_;
  SegmentWriter<ClientChannels> segment_;
  std::mt19937_64 random_{static_cast<uint64_t>(now_ns())};
  uint64_t seq_ = 0;
};

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) try {
  const std::string_view how = argc == 7 ? argv[6] : "";
  if (argc != 6 && how != "flood" && how != "still") {
    std::fputs("haptic-faulty-giver: give SESSION CLIENT X Y Z [flood|still]\n", stderr);
    return 2;
  }
  haptic::catch_orders();
  if (how == "still") {
    haptic::enter_realtime({.fifo_priority = haptic::kRecorderPriority, .lock_memory = false});
  }
  const haptic::Vec3 place{std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])};
  haptic::FaultyGiver(argv[1], argv[2], place, how).run();
} catch (const std::exception& error) {
  return std::fprintf(stderr, "haptic-faulty-giver: %s\n", error.what()), 1;
}
