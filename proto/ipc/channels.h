// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <tuple>

#include "proto/ipc/eye_file.h"
#include "proto/ipc/packed_ring.h"
#include "proto/ipc/ring.h"
#include "proto/wire/hands.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Owner of a segment; those of a hand follow. From 0x100 on are the eye files of contact
/// (eye_file.h): those of the tools, by hand, then of the objects, by index; from 0x300 on in the
/// same order those of their convex pieces, where a session has them.
enum class SegmentId : uint32_t {
  kControl = 1,
  kSim = 4,
  kEdits = 6,       // what has changed shapes
  kClient0 = 0x80,  // what clients give, by number, up to kClient0 + kMostClients − 1
  kDraw0 = 0x90,    // what they draw, likewise
  kEye0 = 0x100,
  kPieces0 = 0x300
};

/// The desired state, the servo and the contact of a hand.
inline constexpr uint32_t kIdsOfHand = 0x10;
constexpr SegmentId control_segment(uint32_t hand) {
  return SegmentId{kIdsOfHand * hand + 1};
}
constexpr SegmentId servo_segment(uint32_t hand) {
  return SegmentId{kIdsOfHand * hand + 2};
}
constexpr SegmentId contact_segment(uint32_t hand) {
  return SegmentId{kIdsOfHand * hand + 3};
}
static_assert(control_segment(kFirstHand) == SegmentId::kControl);
static_assert(contact_segment(kMostHands - 1) < SegmentId::kClient0);

/// How many eye files of a kind there can be: of each hand's tool and of each object.
inline constexpr uint32_t kMostEyes = kMostHands + kMaxObjects;

/// The number under which the eye file of an object, or of a hand's tool, is handed out.
constexpr SegmentId eye_id(uint32_t object) {
  const uint32_t place = is_eye_of_tool(object) ? kEyeOfTool - object : kMostHands + object;
  return SegmentId{static_cast<uint32_t>(SegmentId::kEye0) + place};
}

/// The number under which the eye file of its convex pieces is handed out.
constexpr SegmentId pieces_id(uint32_t object) {
  constexpr auto kBetween =
      static_cast<uint32_t>(SegmentId::kPieces0) - static_cast<uint32_t>(SegmentId::kEye0);
  return SegmentId{static_cast<uint32_t>(eye_id(object)) + kBetween};
}
static_assert(eye_id(kMaxObjects) <= SegmentId::kPieces0);

constexpr bool is_pieces(SegmentId id) {
  return id >= SegmentId::kPieces0 && id < pieces_id(kMaxObjects);
}

constexpr bool is_eye(SegmentId id) {
  return (id >= SegmentId::kEye0 && id < eye_id(kMaxObjects)) || is_pieces(id);
}

/// The object of such a number, or eye_of_tool; only where is_eye(id).
constexpr uint32_t eye_object(SegmentId id) {
  const SegmentId first = is_pieces(id) ? SegmentId::kPieces0 : SegmentId::kEye0;
  const uint32_t place = static_cast<uint32_t>(id) - static_cast<uint32_t>(first);
  return place < kMostHands ? eye_of_tool(place) : place - kMostHands;
}

constexpr bool is_contact(SegmentId id) {
  return id < SegmentId::kClient0 &&
         static_cast<uint32_t>(id) % kIdsOfHand == static_cast<uint32_t>(contact_segment(0));
}

/// True if the child that owns segment `child` may offer `id`: its own, and a contact eye files.
constexpr bool may_offer(SegmentId child, SegmentId id) {
  return id == child || (is_contact(child) && is_eye(id));
}

inline constexpr std::array<const char*, kMostClients> kClientNames{
    "client0", "client1", "client2", "client3", "client4", "client5", "client6", "client7"};

/// The rings of each process; those of a servo and a contact are alike for every hand. 4096 frames
/// of servo and contact are four seconds at 1 kHz: they survive a crash of the writer, and a
/// recorder may be that late on a busy machine. Four seconds of the servo hold 7 objects that a
/// push can move, 0.9 seconds 64. Four seconds of contact hold 7 contacts in each set; sets of 64
/// fill the ring in one. Two seconds of sim at 1 kHz hold four bodies with mass or 20 still
/// objects; 0.17 seconds hold 256.
struct ServoChannels {
  static constexpr SegmentId kId = servo_segment(kFirstHand);
  static constexpr const char* kName = servo_name(kFirstHand);
  static constexpr SegmentId id(uint32_t hand) { return servo_segment(hand); }
  static constexpr const char* name(uint32_t hand) { return servo_name(hand); }
  PackedRing<ServoFrame, 4096, 6 << 20> frames;
  Ring<Event, 256> events;
  Ring<DeviceRelease, 4> releases;
  using Rings = std::tuple<decltype(frames), decltype(events), decltype(releases)>;
};

struct ContactChannels {
  static constexpr SegmentId kId = contact_segment(kFirstHand);
  static constexpr const char* kName = contact_name(kFirstHand);
  static constexpr SegmentId id(uint32_t hand) { return contact_segment(hand); }
  static constexpr const char* name(uint32_t hand) { return contact_name(hand); }
  PackedRing<ContactSet, 4096, 10 << 20> sets;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(sets), decltype(events)>;
};

struct SimChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "sim";
  PackedRing<SceneFrame, 2048, 6 << 20> frames;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(frames), decltype(events)>;
};

/// What a client gives, by its index in the session file. 256 frames are a quarter of a second at
/// 1 kHz: sim takes the newest alone, a recorder all.
struct ClientChannels {
  static constexpr SegmentId kId = SegmentId::kClient0;
  static constexpr const char* kName = kClientNames[0];
  static constexpr SegmentId id(uint32_t client) {
    return SegmentId{static_cast<uint32_t>(SegmentId::kClient0) + client};
  }
  static constexpr const char* name(uint32_t client) { return kClientNames[client]; }
  PackedRing<GivenFrame, 256, 1 << 20> frames;
  using Rings = std::tuple<decltype(frames)>;
};

inline constexpr std::array<const char*, kMostClients> kDrawNames{
    "draw0", "draw1", "draw2", "draw3", "draw4", "draw5", "draw6", "draw7"};

/// Ring of what a client draws, for viewers alone: at five drawings of 200,000 points and 20,000
/// lines a second the pieces of two drawings are there at any time.
struct DrawChannels {
  static constexpr SegmentId kId = SegmentId::kDraw0;
  static constexpr const char* kName = kDrawNames[0];
  static constexpr SegmentId id(uint32_t client) {
    return SegmentId{static_cast<uint32_t>(SegmentId::kDraw0) + client};
  }
  static constexpr const char* name(uint32_t client) { return kDrawNames[client]; }
  PackedRing<DrawnPiece, 256, 28 << 20> pieces;
  using Rings = std::tuple<decltype(pieces)>;
};

inline constexpr std::array<const char*, kMostHands> kControlNames{"control", "control1",
                                                                   "control2", "control3"};

/// Ring of the desired state of a hand, which its servo follows; sim follows the first hand's.
struct ControlChannels {
  static constexpr SegmentId kId = control_segment(kFirstHand);
  static constexpr const char* kName = kControlNames[kFirstHand];
  static constexpr SegmentId id(uint32_t hand) { return control_segment(hand); }
  static constexpr const char* name(uint32_t hand) { return kControlNames.at(hand); }
  Ring<ControlFrame, 64> frames;
  Ring<Event, 256> events;
  using Rings = std::tuple<decltype(frames), decltype(events)>;
};

}  // namespace haptic
