// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "proto/math/pose.h"
#include "proto/wire/hands.h"

/// The structs all processes share: shared-memory records, log payload (CDR) and input of the
/// solvers. SI units; the last letter of a field's name is its frame: W world, B device base, H
/// handle, T tool, O object. proto/wire/schema.h describes the same layout as text.
namespace haptic {

inline constexpr uint32_t kMaxObjects = 16;   // per scene
inline constexpr uint32_t kMaxContacts = 64;  // per ContactSet
inline constexpr uint32_t kMaxJoints = 16;    // per scene
inline constexpr uint32_t kAbiMajor = 11;     // raise it when any struct below changes
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

/// What the device measured, in its own base frame.
struct DeviceState {
  int64_t t_ns;      // CLOCK_MONOTONIC at which the pose was true
  Pose X_BH;         // handle in base
  Twist V_BH;        // velocity of the handle, in B
  Wrench F_hand_B;   // of the hand on the handle at its origin, in B; zero: not measured
  double grip;       // gripper opening [0 closed, 1 open]
  uint32_t buttons;  // one bit per button
  uint32_t flags;    // DeviceFlag
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

/// One servo tick: measurements, inputs used, and the wrench for the device.
struct ServoFrame {
  uint64_t tick;              // grid point; skipped grid points leave a gap in this number
  int64_t t_ns;               // deadline of the tick, CLOCK_MONOTONIC
  int64_t realtime_ns;        // the same instant on CLOCK_REALTIME
  uint64_t contact_seq;       // ContactSet used
  uint64_t contact_tick;      // ServoFrame that set answers
  uint64_t scene_seq;         // SceneFrame used
  uint64_t control_revision;  // ControlFrame in force
  DeviceState device;
  Pose X_WT;            // tool (haptic interface point for a 3-DoF renderer)
  Twist V_WT;           // its velocity, in W
  Pose X_WG;            // verified proxy pose, as the last ContactSet left it
  Pose X_WP;            // this tick's proxy pose
  Twist V_WP;           // its velocity, in W
  Wrench F_coupling_W;  // on the tool at its origin, in W, before safety; the proxy feels −F
  Wrench F_device_B;    // on the handle at its origin, in B; held until the next tick
  Pose X_command_B;     // pose commanded to an admittance device; of others the measured one
  std::array<Wrench, kMaxObjects>
      object_impulse_W;  // pushed into each object since start [N·s, N·m·s], about its origin
  std::array<Wrench, kMaxObjects>
      object_impulse_time_W;  // its time integral until t_ns [N·s², N·m·s²]
  Vec3 forgotten_impulse_W;   // pushed into bodies that no sim moved, in all objects [N·s]
  int64_t impulses_since_ns;  // where the counters of impulses began
  Vec3 held_back_W;           // offset of the proxy by friction; contact follows the tool plus this
  // of the coupling in force; contact compares poses by them
  double translational_stiffness;  // [N/m]
  double rotational_stiffness;     // [N·m/rad]
  double depth;                    // distance from tool to proxy [m]
  double fade;                     // weight of the contacts, 0 to 1
  int64_t wake_late_ns;            // wake-up after the deadline
  int64_t busy_ns;                 // from wake-up to force sent
  uint64_t skipped;                // grid points skipped since start
  uint32_t n_contacts;             // planes that push
  uint32_t flags;                  // ServoFlag
  uint32_t fault;                  // Fault; latched
  uint32_t renderer;               // Renderer wanted from contact
};

/// One constraint, in the frame of the object it belongs to. Penetration is n·(object − tool) > 0.
struct Contact {
  Vec3 tool_point_T;      // on the tool
  Vec3 object_point_O;    // on the object
  Vec3 normal_O;          // unit, from object to tool
  Vec3 shading_normal_O;  // unit, interpolated; equals normal_O where there is none
  double curvature;       // mean curvature of the object there [1/m]
  double extent;  // radius around object_point_O in which it holds [m]; 6-DoF: 0 means no bound
  std::array<double, 2> texture_uv;
  double stiffness;   // of a soft contact, along the normal [N/m]; 0: a plane only
  uint32_t object;    // index in the scene
  uint32_t material;  // index of the object in the config that defines the material
  // stable id: 2 bits kind (0 face, 1 edge, 2 vertex, 3 guide: a row that holds both ways,
  // proto/wire/guide.h), the rest its index
  uint64_t feature;
};

/// ContactSet::flags.
enum ContactFlag : uint32_t {
  kContactReseeded = 1u << 0,        // proxy placed anew (started inside, or an object ran over it)
  kContactIterationLimit = 1u << 1,  // stopped by the iteration limit, not converged
  kContactTruncated = 1u << 2,       // more facets than a query, a leg or the set can hold
  kContactNoFreePose = 1u << 3,      // no free proxy pose found: the planes must not be rendered
  kContactNoScene = 1u << 4,         // no SceneFrame yet: poses of the config are used
  kContactNoDetector = 1u << 5,      // the session lacks the tool or the maps for this renderer
};

/// The tool as a rigid body, axes those of T; mass 0: unknown, the tool is a point.
struct ToolBody {
  double mass;     // [kg]
  Vec3 inertia_T;  // moments about these axes through the centre of mass [kg·m²]
  Vec3 centre_T;   // centre of mass
  double radius;   // of the ball around centre_T that contains the tool [m]
};

/// Contact's answer to one ServoFrame: the active constraints first, then the nearest others, then
/// the guide rows.
struct ContactSet {
  uint64_t seq;
  uint64_t answers_tick;  // ServoFrame::tick
  int64_t answers_t_ns;   // ServoFrame::t_ns; the age of the set counts from here
  uint64_t scene_seq;
  uint64_t reseeds;  // times the proxy was lost or placed anew: force starts softly
  Pose X_WT;         // tool pose of the query; 6-DoF: the proxy's
  std::array<Pose, kMaxObjects> X_WO;  // object poses of the query
  Pose X_WG;                           // verified proxy: proven free of every object
  // of a 6-DoF tool at X_WG: distance every point of it can move relative to an object before that
  // object pushes it; 0: unknown [m]
  std::array<double, kMaxObjects> clearance;
  double free_fraction;  // free part of the way to the tool [0, 1]
  uint32_t n_contacts;
  uint32_t n_active;  // point: the first n_active are the active set; 6-DoF: number touching
  std::array<Contact, kMaxContacts> contacts;
  Wrench F0_W;               // on the tool about its origin, of all points touching wrench_object
  std::array<double, 36> K;  // derivative of F0_W by a small motion of the tool, in W
  std::array<double, 36> B;  // braking wrench per twist of the tool relative to that object, in W
  double trust_radius;       // bound of any point's motion within which F0_W, K hold [m]; 0: none
  ToolBody tool;             // mass properties, for proxies with mass
  int64_t busy_ns;
  uint32_t n_objects;
  uint32_t flags;          // ContactFlag
  uint32_t renderer;       // Renderer whose detector this is
  uint32_t wrench_object;  // object of F0_W, K, B
};

/// How far sim has used the counters of a hand for one object (ServoFrame).
struct SeenPush {
  Wrench impulse_W;       // object_impulse_W
  Wrench impulse_time_W;  // object_impulse_time_W
  Vec3 forgotten_W;       // of that impulse, what was pushed while no sim ran [N·s]
};

/// How an object moves when it is pushed, and by what it has been pushed already; proto/wire/
/// scene_pose.h places objects by it.
struct ObjectResponse {
  Twist acceleration_W;             // of its origin, by all but hands [m/s², rad/s²]
  std::array<double, 36> mobility;  // change of its twist per impulse at its origin, both in W
  std::array<SeenPush, kMostHands> seen;
};

/// A coordinate of a mechanism.
struct JointState {
  double position;  // [m] or [rad]
  double velocity;
};

struct SceneFrame {
  uint64_t seq;
  int64_t t_ns;  // instant of the poses, CLOCK_MONOTONIC
  std::array<Pose, kMaxObjects> X_WO;
  std::array<Twist, kMaxObjects> V_WO;
  std::array<JointState, kMaxJoints> joints;
  std::array<int64_t, kMostHands> seen_t_ns;  // of the ServoFrame used; 0: none yet
  int64_t busy_ns;
  uint32_t n_objects;
  uint32_t flags;
  uint32_t n_joints;
  uint32_t n_responses;  // objects from here on do not answer a push
  std::array<ObjectResponse, kMaxObjects> responses;
};

/// The complete desired state of the session, never a change of it: a reader that misses a revision
/// still ends in the right state.
struct ControlFrame {
  uint64_t revision;
  int64_t t_ns;
  uint64_t fault_clears;           // a latched fault is cleared when this grows
  double translational_stiffness;  // [N/m], scene units
  double translational_damping;    // [N·s/m]
  double rotational_stiffness;     // [N·m/rad]
  double rotational_damping;       // [N·m·s/rad]
  double scene_time_scale;         // 1: scripted motion at its own speed
  uint32_t renderer;               // Renderer
  uint32_t paused;                 // zero wrench while 1
  uint32_t armed;                  // zero wrench while 0
  uint32_t fault;                  // Fault the last servo ended with; the next one starts with it
  Pose X_WT_intent;                // where a simulated hand is led to, as a pose of the tool
  int64_t intent_t_ns;             // CLOCK_MONOTONIC of the last command to lead
  uint32_t leading;                // 1: somebody leads, until kLeadNs after intent_t_ns
  uint32_t solver;                 // 1 + SoftSolver; 0: as the session's file says
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

/// A fixed-size log record; hapticd formats it.
struct Event {
  int64_t t_ns;
  uint32_t code;    // EventCode
  uint32_t source;  // SegmentId of the writer
  std::array<double, 5> numbers;
};

template <typename T>
inline constexpr bool kIsWire = std::is_trivially_copyable_v<T>&& std::is_standard_layout_v<T> &&
                                sizeof(T) % 8 == 0 && alignof(T) == 8;

/// Zero wrench whatever the contacts: what follows starts at the present pose.
inline constexpr uint32_t kServoClosed =
    kServoFault | kServoPaused | kServoDisarmed | kServoTooFast | kServoNoDevice;

// no padding: size is the sum of the members, also checked against the text in schema.h
static_assert(kIsWire<Pose> && sizeof(Pose) == 56);
static_assert(kIsWire<Twist> && sizeof(Twist) == 48);
static_assert(kIsWire<Wrench> && sizeof(Wrench) == 48);
static_assert(kIsWire<DeviceState> && sizeof(DeviceState) == 176);
static_assert(kIsWire<Contact> && sizeof(Contact) == 152);
static_assert(kIsWire<DeviceRelease> && sizeof(DeviceRelease) == 88);
static_assert(kIsWire<ServoFrame> && sizeof(ServoFrame) == 2312);
static_assert(kIsWire<ToolBody> && sizeof(ToolBody) == 64);
static_assert(kIsWire<ContactSet> && sizeof(ContactSet) == 11640);
static_assert(kIsWire<SeenPush> && sizeof(SeenPush) == 120);
static_assert(kIsWire<ObjectResponse> && sizeof(ObjectResponse) == 576);
static_assert(kIsWire<JointState> && sizeof(JointState) == 16);
static_assert(kIsWire<SceneFrame> && sizeof(SceneFrame) == 11192);
static_assert(kIsWire<ControlFrame> && sizeof(ControlFrame) == 152);
static_assert(kIsWire<Event> && sizeof(Event) == 56);

}  // namespace haptic
