// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "proto/wire/wire.h"

/// The wire structs as text: ROS 2 message definitions whose CDR encoding equals the struct in
/// memory byte for byte. They are the schemas in a recording and part of a segment's ABI hash,
/// comments included. A `[unit]` at the start of a comment is the field's unit; `[a, b]` gives the
/// units of a compound's members in order. schema.cpp checks sizes and offsets at compile time.
namespace haptic {

/// `name`: MCAP schema name; `text`: definition of the fields, without nested types.
template <typename T>
struct Schema;

template <>
struct Schema<DeviceState> {
  static constexpr std::string_view name = "haptic_msgs/msg/DeviceState";
  static constexpr std::string_view text =
      R"(int64 t_ns                # [ns] CLOCK_MONOTONIC at which the pose was true
geometry_msgs/Pose X_BH   # handle in device base
geometry_msgs/Twist V_BH  # velocity of the handle, in B
geometry_msgs/Wrench F_hand_B  # of the hand on the handle at its origin, in B; zero: not measured
float64 grip              # gripper opening, 0 closed to 1 open
uint32 buttons            # one bit a button
uint32 flags              # DeviceFlag
)";
};

template <>
struct Schema<Contact> {
  static constexpr std::string_view name = "haptic_msgs/msg/Contact";
  static constexpr std::string_view text =
      R"(geometry_msgs/Vector3 tool_point_T      # [m] on the tool
geometry_msgs/Vector3 object_point_O    # [m] on the object
geometry_msgs/Vector3 normal_O          # unit, from object to tool
geometry_msgs/Vector3 shading_normal_O  # unit, interpolated
float64 curvature                       # [1/m] mean curvature of the object there
float64 extent                          # [m] the plane holds within this radius
float64[2] texture_uv
float64 stiffness                       # [N/m] of a soft contact; 0: a plane, nothing more
uint32 object                           # index in the scene
uint32 material
uint64 feature                          # 2 bits kind (0 face, 1 edge, 2 vertex, 3 guide), the rest its index
)";
};

template <>
struct Schema<ServoFrame> {
  static constexpr std::string_view name = "haptic_msgs/msg/ServoFrame";
  static constexpr std::string_view text =
      R"(uint64 tick                       # grid point; skipped grid points leave a gap
int64 t_ns                        # [ns] deadline of the tick, CLOCK_MONOTONIC
int64 realtime_ns                 # [ns] the same instant on CLOCK_REALTIME
uint64 contact_seq                # ContactSet used
uint64 contact_tick               # ServoFrame that set answers
uint64 scene_seq                  # SceneFrame used
uint64 control_revision           # ControlFrame in force
haptic_msgs/DeviceState device    # what was measured
geometry_msgs/Pose X_WT           # tool
geometry_msgs/Twist V_WT          # its velocity, in W
geometry_msgs/Pose X_WG           # verified proxy pose, as the last ContactSet left it
geometry_msgs/Pose X_WP           # proxy pose of this tick
geometry_msgs/Twist V_WP          # its velocity, in W
geometry_msgs/Wrench F_coupling_W # on the tool at its origin, in W, before safety
geometry_msgs/Wrench F_device_B   # on the handle at its origin, in B: what the device holds
geometry_msgs/Pose X_command_B    # commanded to an admittance device; of others the measured one
geometry_msgs/Wrench[16] object_impulse_W  # [N·s, N·m·s] pushed into each object since start
geometry_msgs/Wrench[16] object_impulse_time_W  # [N·s², N·m·s²] its time integral until t_ns
geometry_msgs/Vector3 forgotten_impulse_W  # [N·s] pushed into bodies that no sim moved
int64 impulses_since_ns           # [ns] where the counters of impulses began
geometry_msgs/Vector3 held_back_W  # [m] how far friction holds the proxy back
float64 translational_stiffness   # [N/m] of the coupling in force
float64 rotational_stiffness      # [N·m/rad] likewise
float64 depth                     # [m] distance from tool to proxy
float64 fade                      # weight of the contacts, 0 to 1
int64 wake_late_ns                # [ns] wake-up after the deadline
int64 busy_ns                     # [ns] from wake-up to force sent
uint64 skipped                    # grid points skipped since start
uint32 n_contacts                 # planes that push
uint32 flags                      # ServoFlag
uint32 fault                      # Fault; latched
uint32 renderer                   # Renderer wanted of contact
)";
};

template <>
struct Schema<ToolBody> {
  static constexpr std::string_view name = "haptic_msgs/msg/ToolBody";
  static constexpr std::string_view text =
      R"(float64 mass                      # [kg] 0: the tool is a point
geometry_msgs/Vector3 inertia_T   # [kg·m²] about the axes of T through the centre of mass
geometry_msgs/Vector3 centre_T    # [m] of mass
float64 radius                    # [m] of the ball around it that holds the tool
)";
};

template <>
struct Schema<ContactSet> {
  static constexpr std::string_view name = "haptic_msgs/msg/ContactSet";
  static constexpr std::string_view text =
      R"(uint64 seq
uint64 answers_tick              # tick of the ServoFrame it answers
int64 answers_t_ns               # [ns] deadline of that tick, CLOCK_MONOTONIC
uint64 scene_seq                 # SceneFrame used
uint64 reseeds                   # times the proxy was lost or placed anew
geometry_msgs/Pose X_WT          # tool pose of the query, or its proxy's
geometry_msgs/Pose[16] X_WO      # object poses of the query
geometry_msgs/Pose X_WG          # verified proxy: proven free of every object
float64[16] clearance            # [m] that a body may move from there before that object pushes it
float64 free_fraction            # of the way to the tool that was free, 0 to 1
uint32 n_contacts
uint32 n_active                  # the first n_active carry the proxy
haptic_msgs/Contact[64] contacts
geometry_msgs/Wrench F0_W        # on the tool about its origin, of all points on wrench_object
float64[36] K                    # its change with a small motion of the tool, in W
float64[36] B                    # braking, by the tool's twist relative to that object, in W
float64 trust_radius             # [m] where the linearisation holds
haptic_msgs/ToolBody tool        # what the tool is
int64 busy_ns                    # [ns]
uint32 n_objects
uint32 flags                     # ContactFlag
uint32 renderer                  # Renderer whose detector this is
uint32 wrench_object             # that F0_W, K, B are about
)";
};

template <>
struct Schema<SeenPush> {
  static constexpr std::string_view name = "haptic_msgs/msg/SeenPush";
  static constexpr std::string_view text =
      R"(geometry_msgs/Wrench impulse_W       # [N·s, N·m·s] of the hand's counter, used so far
geometry_msgs/Wrench impulse_time_W  # [N·s², N·m·s²] likewise of its time integral
geometry_msgs/Vector3 forgotten_W    # [N·s] pushed while no sim ran
)";
};

template <>
struct Schema<ObjectResponse> {
  static constexpr std::string_view name = "haptic_msgs/msg/ObjectResponse";
  static constexpr std::string_view text =
      R"(geometry_msgs/Twist acceleration_W  # [m/s², rad/s²] of the origin, by all but hands
float64[36] mobility                # change of the twist per impulse at the origin, both in W
haptic_msgs/SeenPush[2] seen        # of each hand
)";
};

template <>
struct Schema<JointState> {
  static constexpr std::string_view name = "haptic_msgs/msg/JointState";
  static constexpr std::string_view text =
      R"(float64 position  # [m] or [rad]
float64 velocity  # its derivative
)";
};

template <>
struct Schema<SceneFrame> {
  static constexpr std::string_view name = "haptic_msgs/msg/SceneFrame";
  static constexpr std::string_view text =
      R"(uint64 seq
int64 t_ns                     # [ns] instant of the poses, CLOCK_MONOTONIC
geometry_msgs/Pose[16] X_WO    # object poses
geometry_msgs/Twist[16] V_WO   # their velocities, in W
haptic_msgs/JointState[16] joints
int64[2] seen_t_ns             # [ns] of the ServoFrame of each hand that was used; 0: none yet
int64 busy_ns                  # [ns]
uint32 n_objects
uint32 flags
uint32 n_joints
uint32 n_responses             # objects from here on do not answer a push
haptic_msgs/ObjectResponse[16] responses
)";
};

template <>
struct Schema<ControlFrame> {
  static constexpr std::string_view name = "haptic_msgs/msg/ControlFrame";
  static constexpr std::string_view text =
      R"(uint64 revision
int64 t_ns                       # [ns] CLOCK_MONOTONIC
uint64 fault_clears              # a latched fault is cleared when this grows
float64 translational_stiffness  # [N/m]
float64 translational_damping    # [N·s/m]
float64 rotational_stiffness     # [N·m/rad]
float64 rotational_damping       # [N·m·s/rad]
float64 scene_time_scale         # 1: scripted motion at its own speed
uint32 renderer                  # Renderer
uint32 paused                    # zero wrench while 1
uint32 armed                     # zero wrench while 0
uint32 fault                     # Fault the last servo ended with; the next begins with it
geometry_msgs/Pose X_WT_intent   # where a simulated hand is led to, as a pose of the tool
int64 intent_t_ns                # [ns] CLOCK_MONOTONIC of the last command to lead
uint32 leading                   # 1: somebody leads
uint32 solver                    # 1 + SoftSolver; 0: as the session's file says
)";
};

template <>
struct Schema<Event> {
  static constexpr std::string_view name = "haptic_msgs/msg/Event";
  static constexpr std::string_view text =
      R"(int64 t_ns           # [ns] CLOCK_MONOTONIC
uint32 code          # EventCode
uint32 source        # SegmentId of the writer
float64[5] numbers   # meaning depends on the code
)";
};

/// One number of a message and its place in the bytes.
struct Field {
  std::string name;  // path from the message, "device.X_BH.position.x", "contacts[3].extent"
  std::string type;  // ROS 2 primitive: float64, int64, uint64, uint32, …
  size_t offset;     // from the start of the struct [bytes]
  std::string unit;  // "m", "N·s"; empty for pure numbers
};

/// Every number of the message `text` in byte order. Nested types must be those of this header or
/// geometry_msgs; throws std::runtime_error otherwise.
std::vector<Field> flatten(std::string_view text);

/// Every number of the schema of a file, without units: `definition` holds the nested types as
/// well, as full_definition() writes them. It is not trusted: throws std::runtime_error where it is
/// malformed, refers to itself, or describes more than a record can hold.
std::vector<Field> flatten_definition(std::string_view definition);

/// Bytes of a message that consists of these numbers.
size_t size_of(const std::vector<Field>& fields);
/// Bytes of one number.
size_t size_of(const Field& field);

/// A name in lower case: readers of ROS 2 demand it of fields.
std::string lower_case(std::string_view name);

/// `text` followed by the definitions of all nested types, for MCAP's `ros2msg` encoding. Field
/// names are in lower case (`x_wp`), as ROS 2 readers demand.
std::string full_definition(std::string_view text);

}  // namespace haptic
