// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>

#include "proto/ipc/eye_file.h"
#include "proto/ipc/packed_ring.h"
#include "proto/ipc/ring.h"
#include "proto/wire/hands.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Owner of a segment; those of a hand follow. From 0x100 on are the eye files of contact
/// (eye_file.h): that of the tool, then of the objects, by index; from 0x200 on in the same order
/// those of their convex pieces, where a session has them.
enum class SegmentId : uint32_t {
  kControl = 1,
  kSim = 4,
  kEyeTool = 0x100,
  kEye0 = 0x101,
  kPiecesTool = 0x200,
  kPieces0 = 0x201
};

/// The servo and the contact of a hand.
constexpr SegmentId servo_segment(uint32_t hand) {
  return SegmentId{0x10 * hand + 2};
}
constexpr SegmentId contact_segment(uint32_t hand) {
  return SegmentId{0x10 * hand + 3};
}
static_assert(contact_segment(kMostHands - 1) < SegmentId::kEyeTool);

/// The number under which the eye file of an object, or of the tool, is handed out.
constexpr SegmentId eye_id(uint32_t object) {
  return object == kEyeOfTool ? SegmentId::kEyeTool
                              : SegmentId{static_cast<uint32_t>(SegmentId::kEye0) + object};
}

/// The number under which the eye file of its convex pieces is handed out.
constexpr SegmentId pieces_id(uint32_t object) {
  return object == kEyeOfTool ? SegmentId::kPiecesTool
                              : SegmentId{static_cast<uint32_t>(SegmentId::kPieces0) + object};
}
static_assert(eye_id(kMaxObjects) < SegmentId::kPiecesTool);

constexpr bool is_pieces(SegmentId id) {
  return id >= SegmentId::kPiecesTool && id < pieces_id(kMaxObjects);
}

constexpr bool is_eye(SegmentId id) {
  return (id >= SegmentId::kEyeTool && id < eye_id(kMaxObjects)) || is_pieces(id);
}

/// The object of such a number; only where is_eye(id).
constexpr uint32_t eye_object(SegmentId id) {
  const SegmentId tool = is_pieces(id) ? SegmentId::kPiecesTool : SegmentId::kEyeTool;
  return id == tool ? kEyeOfTool : static_cast<uint32_t>(id) - static_cast<uint32_t>(tool) - 1;
}

/// True if the child that owns segment `child` may offer `id`: its own, and contact the eye files.
constexpr bool may_offer(SegmentId child, SegmentId id) {
  return id == child || (child == contact_segment(kFirstHand) && is_eye(id));
}

/// The rings of each process. 4096 frames of servo and contact are four seconds at 1 kHz: they
/// survive a crash of the writer, and a recorder may be that late on a busy machine. Four seconds
/// of the servo hold 7 objects that a push can move, 2.7 seconds sixteen. Four seconds of contact
/// hold 7 contacts in each set; sets of 64 fill the ring in one. Two seconds of sim at 1 kHz hold
/// four bodies with mass, 0.7 seconds sixteen.
struct ServoChannels {
  static constexpr SegmentId kId = servo_segment(kFirstHand);
  static constexpr const char* kName = servo_name(kFirstHand);
  PackedRing<ServoFrame, 4096, 6 << 20> frames;
  Ring<Event, 256> events;
  Ring<DeviceRelease, 4> releases;
  using Rings = std::tuple<decltype(frames), decltype(events), decltype(releases)>;
};

struct ContactChannels {
  static constexpr SegmentId kId = contact_segment(kFirstHand);
  static constexpr const char* kName = contact_name(kFirstHand);
  PackedRing<ContactSet, 4096, 12 << 20> sets;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(sets), decltype(events)>;
};

struct SimChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "sim";
  PackedRing<SceneFrame, 2048, 8 << 20> frames;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(frames), decltype(events)>;
};

struct ControlChannels {
  static constexpr SegmentId kId = SegmentId::kControl;
  static constexpr const char* kName = "control";
  Ring<ControlFrame, 64> frames;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(frames), decltype(events)>;
};

}  // namespace haptic
