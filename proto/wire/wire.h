// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "proto/math/pose.h"
#include "proto/wire/hands.h"
#include "proto/wire/packed.h"

/// The structs all processes share: shared-memory records, log payload (CDR) and input of the
/// solvers. Their fields stand in proto/wire/records.def. SI units; the last letter of a field's
/// name is its frame: W world, B device base, H handle, T tool, O object; the pose X_AB is that of
/// B in A.
namespace haptic {

template <typename T>
inline constexpr bool kIsWire = std::is_trivially_copyable_v<T>&& std::is_standard_layout_v<T> &&
                                sizeof(T) % 8 == 0 && alignof(T) == 8;

inline constexpr uint32_t kMaxObjects = 256;       // of a scene
inline constexpr uint32_t kMaxBodies = 64;         // of them, those that a push can move
inline constexpr uint32_t kMaxJoints = 64;         // of a scene
inline constexpr uint32_t kMaxContacts = 64;       // of a ContactSet
inline constexpr uint32_t kMaxGuideRows = 40;      // beside them
inline constexpr uint32_t kMaxLocalContacts = 12;  // of them, those that may have a compliance
inline constexpr uint32_t kMostClients = 8;        // of a session, that give
inline constexpr uint32_t kMostGivenMoves = 16;    // objects that one of them moves
inline constexpr uint32_t kMostGivenPlanes = 24;   // that it gives
inline constexpr uint32_t kMostWrenches = 16;      // beside the contacts of a ContactSet
inline constexpr uint32_t kMostPiecePoints = 2048, kMostPieceLines = 512;  // of a DrawnPiece
inline constexpr uint32_t kNoObject = kMaxObjects;                         // the world itself
inline constexpr uint32_t kAbiMajor = 12;  // raise it when any struct below changes
inline constexpr uint32_t kAbiMinor =
    0;  // raise it when a field gets a new meaning that old readers may ignore

/// DeviceState::flags.
enum DeviceFlag : uint32_t {
  kDeviceFresh = 1u << 0,        // measured for this tick
  kDeviceHeld = 1u << 1,         // the previous sample, repeated (no new one from the source)
  kDeviceHomed = 1u << 2,        // position is absolute
  kDeviceSaturated = 1u << 3,    // the actuator clipped the last wrench
  kDeviceEnded = 1u << 4,        // a replay has no more samples
  kDeviceOpenLoop = 1u << 5,     // no effect of the force on the motion (replay)
  kDeviceSimulated = 1u << 6,    // no hardware behind it
  kDeviceLostTime = 1u << 7,     // a simulated hand was stalled longer than it can catch up with
  kDeviceLost = 1u << 8,         // not answering or unplugged: nothing may be rendered
  kDeviceStale = 1u << 9,        // its answers do not match the requests
  kDeviceNoisy = 1u << 10,       // its encoders reverse direction faster than a hand can
  kDeviceLed = 1u << 11,         // a simulated hand means to go where a ControlFrame leads it
  kDeviceAdmittance = 1u << 12,  // it measures the hand's wrench and is commanded a pose
};

/// ServoFrame::flags.
enum ServoFlag : uint32_t {
  kServoContact = 1u << 0,         // at least one plane pushes
  kServoNoContactSet = 1u << 1,    // no set received yet
  kServoHolding = 1u << 2,         // contacts older than expected, still at full weight
  kServoFading = 1u << 3,          // contacts stale, force fading to zero
  kServoStale = 1u << 4,           // contacts too old: none rendered
  kServoReopening = 1u << 5,       // contacts are back, force ramps up
  kServoSaturated = 1u << 6,       // force or torque was clipped to the limit
  kServoSoftStart = 1u << 7,       // soft-start gain below one
  kServoFault = 1u << 8,           // a fault is latched (Fault); zero wrench
  kServoClutched = 1u << 9,        // workspace is being re-indexed; zero wrench
  kServoPaused = 1u << 10,         // paused by the control frame; zero wrench
  kServoSolverLimit = 1u << 11,    // planes contradict each other or the solver ran out of steps
  kServoTorqueDropped = 1u << 12,  // the device has no torque actuators
  kServoStopped = 1u << 13,        // last frame: the loop has ended with a zero wrench
  kServoDisarmed = 1u << 14,       // waits for the dead-man button or `hapt arm`; zero wrench
  kServoTooFast = 1u << 15,        // handle exceeded the velocity limit, not yet slow; zero wrench
  kServoSlewing = 1u << 16,        // force rate-limited by slew and the hand's motion
  kServoThermal = 1u << 17,        // the motors' thermal budget lowers the limit
  kServoPassivity = 1u << 18,      // the passivity controller damps
  kServoWorkspaceEdge = 1u << 19,  // the soft edge of the workspace pushes
  kServoNoDevice = 1u << 20,       // the device is lost or not homed; zero wrench, then soft start
  kServoSoftened = 1u << 21,       // the coupling is softened towards a body too light for it
  kServoForced = 1u << 22,         // the coupling is far stiffer than the device holds (--force)
  kServoLate = 1u << 23,           // in the last second it skipped more than 1 % of its ticks,
  kServoContactLate = 1u << 24,    // contact was late for more than 1 % of them,
  kServoSimLate = 1u << 25,        // sim published less than 90 % of its frames
  kServoWeightEnded = 1u << 26,    // the arm ran away: its weight is not held up until a hand comes
};

/// Why the force is latched at zero.
enum class Fault : uint32_t {
  kNone = 0,
  kDeviceNotFinite = 1,    // NaN, infinity or no rotation in the device's sample
  kContactsNotFinite = 2,  // in the contacts or the poses of the objects
  kForceNotFinite = 3,     // in the wanted force or torque
  kForceHuge = 4,          // over a thousand times the limit
  kPoseJump = 5,           // farther than the hand can have moved in the measured time
  kDeviceStale = 6,        // the device's answers do not match the requests: frozen or old
  kDeviceNoisy = 7,        // an encoder reports motion no hand can make
};

/// ContactSet::flags. Bit 4 of layouts before 12: no SceneFrame had come.
enum ContactFlag : uint32_t {
  kContactReseeded = 1u << 0,        // proxy placed anew (started inside, or an object ran over it)
  kContactIterationLimit = 1u << 1,  // stopped by the iteration limit, not converged
  kContactTruncated = 1u << 2,       // more facets than a query, a leg or the set can hold
  kContactNoFreePose = 1u << 3,      // no free proxy pose found: the planes must not be rendered
  kContactNoDetector = 1u << 5,      // the session lacks the tool or the maps for this renderer
  kContactGiven = 1u << 6,           // a client's wrench or planes are in the set
};

inline constexpr uint32_t kNoResponse = 0xffff'ffff;  // SceneObject::response
inline constexpr uint32_t kMovedBySim = 0;            // SceneObject::mover
constexpr uint32_t moved_by_client(uint32_t client) {
  return 1 + client;
}

/// Why a frame of a client was not taken; the words are in proto/wire/giving.h.
enum class GiverRefusal : uint32_t {
  kNone = 0,
  kNotFinite = 1,     // NaN, infinity, or no unit quaternion
  kNotAllowed = 2,    // an object that this client may not move
  kBackInTime = 3,    // not newer than the one before, or from the future
  kUnknownTick = 4,   // a ServoFrame that has not been, or that sim does not remember any more
  kNotSymmetric = 5,  // a matrix that is not symmetric, or has a negative direction
  kTooLight = 6,      // beyond the largest mobility
  kTooStiff = 7,      // its own motion is faster than the model can follow
  kTooFast = 8,       // beyond the largest speed, acceleration or distance
  kTooStrong = 9,     // driven by more than its client's max_power
  kNoPlane = 10,      // a plane without a unit normal, or on no object
};

/// GiverState::flags.
enum GiverFlag : uint32_t {
  kGiverAttached = 1u << 0,  // its segment is mapped
  kGiverLate = 1u << 1,      // no frame was taken for longer than the hold: it fades or has faded
  kGiverSoftened =
      1u << 2,              // an object answers otherwise than it says, so its frames are held back
  kGiverCut = 1u << 3,      // it gave the hand more power than it may
  kGiverLimited = 1u << 4,  // its wrench or planes are stiffer than the session, or drive by B
};

/// GuideRow::flags.
enum GuideFlag : uint32_t {
  kGuideOneWay = 1u << 0,  // it holds like a contact: n·(tool point − object point) ≥ 0
};

/// Silence after which nobody leads a simulated hand any more [ns]: twelve commands at 60 Hz, so
/// that a busy machine may lose some, and still a fifth of a second.
inline constexpr int64_t kLeadNs = 200'000'000;

/// Ticks after which a silent servo counts as dead or hung, and its device is released.
inline constexpr int kReleaseAfterTicks = 10;

/// How a device is told zero force by a process that only holds its node.
enum class ReleaseBy : uint32_t {
  kNone = 0,       // there is no node, or no force (simulated hand, replay, tracker)
  kWrite = 1,      // the bytes are written to a serial node
  kHidReport = 2,  // they are an output report, its number first, written to a hidraw node
  kUsbBulk = 3,    // they are a bulk packet to `endpoint`, after whatever is in flight on
                   // `interface` has been discarded
};

/// What means zero force to a device: hapticd sends it if the servo cannot, several times, a few
/// milliseconds apart, since a packet may collide with one of the dying servo.
struct DeviceRelease {
  uint64_t size;       // of the bytes
  uint32_t by;         // ReleaseBy
  uint32_t interface;  // of kUsbBulk
  uint32_t endpoint;   // of kUsbBulk
  uint32_t reserved;
  std::array<char, 64> bytes;
};

enum class EventCode : uint32_t {
  kStarted = 1,       // {pid, generation, realtime bits, errno of FIFO, of locked memory}
  kFlagsChanged = 2,  // {old, new, tick, 0, 0}
  kStopped = 3,       // {ticks, skipped, 0, 0, 0}
  kRecordsLost = 4,   // by a recorder: {now, in all, generation of source, 0 frames 1 events, 0}
  kFault = 5,         // {Fault, tick, speed of the handle, wanted force, 0}
  kSessionBack = 6,   // by a recorder: hapticd was killed: {seconds without, last tick, 0, 0, 0}
};

/// Zero wrench whatever the contacts: what follows starts at the present pose.
inline constexpr uint32_t kServoClosed =
    kServoFault | kServoPaused | kServoDisarmed | kServoTooFast | kServoNoDevice;

#define RECORD(record, writer, doc) struct record {
#define FIELD(type, field, ...) type field;
#define ARRAY(type, count, field, ...) std::array<type, count> field;
#define PART(type, most, field, ...) Packed<type, most> field;
#define END(record) \
  }                 \
  ;                 \
  static_assert(kIsWire<record>);
#include "proto/wire/records.def"

static_assert(decltype(SceneFrame::objects)::capacity() == kMaxObjects);
static_assert(decltype(SceneFrame::joints)::capacity() == kMaxJoints);
static_assert(decltype(SceneFrame::responses)::capacity() == kMaxBodies);
static_assert(decltype(SceneFrame::seen)::capacity() == kMaxBodies * kMostHands);
static_assert(decltype(SceneFrame::world_pushes)::capacity() == kMaxBodies);
static_assert(decltype(SceneFrame::givers)::capacity() == kMostClients);
static_assert(decltype(GivenFrame::moves)::capacity() == kMostGivenMoves);
static_assert(decltype(GivenFrame::pushes)::capacity() == kMostHands);
static_assert(decltype(GivenFrame::planes)::capacity() == kMostGivenPlanes);
static_assert(decltype(DrawnPiece::points)::capacity() == kMostPiecePoints);
static_assert(decltype(DrawnPiece::lines)::capacity() == kMostPieceLines);
static_assert(decltype(ServoFrame::felt)::capacity() == kMostClients);
static_assert(decltype(ContactSet::wrenches)::capacity() == kMostWrenches);
static_assert(decltype(ContactSet::givers)::capacity() == kMostClients);
static_assert(decltype(ServoFrame::pushes)::capacity() == kMaxBodies);
static_assert(decltype(ContactSet::objects)::capacity() == kMaxObjects);
static_assert(decltype(ContactSet::contacts)::capacity() == kMaxContacts);
static_assert(decltype(ContactSet::guides)::capacity() == kMaxGuideRows);
static_assert(decltype(ContactSet::compliance)::capacity() ==
              9 * kMaxLocalContacts * kMaxLocalContacts);
static_assert(kIsWire<Pose> && kIsWire<Twist> && kIsWire<Wrench> && kIsWire<DeviceRelease>);

}  // namespace haptic
