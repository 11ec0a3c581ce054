// SPDX-License-Identifier: Apache-2.0
// A session of hapticd from C: its rings are watched, its parameters changed, its objects moved.
// docs/c.md shows how. Units are SI; the last letter of a name is its frame: W world, B base of the
// device, T tool, O object; X_AB is the pose of B in A. A quaternion is x y z w.
//
// - A function that can fail returns a hapticd_result; the message tells more, in one line.
// - A handle is for one thread at a time, several handles are for several threads. After fork() the
//   child makes handles of its own. No thread may be cancelled within a call.
// - A struct begins with its size, which the caller sets: `hapticd_servo it; it.size = sizeof it;`.
//   A library that knows fewer fields sets the others to zero, one that knows more leaves these
//   out.
// - The functions never end the process, whatever is NULL, and no C++ exception leaves them.
#ifndef HAPTICD_CLIENT_C_H
#define HAPTICD_CLIENT_C_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTICD_API __attribute__((visibility("default")))

typedef enum hapticd_result {
  HAPTICD_OK = 0,
  HAPTICD_NOTHING = 1,       // nothing new, nothing read yet, or the time is up; has no message
  HAPTICD_ENDED = 2,         // hapticd was told to stop
  HAPTICD_LOST = 3,          // hapticd was killed; it may come back under the same name
  HAPTICD_REFUSED = 4,       // hapticd says no
  HAPTICD_NO_SESSION = 5,    // there is no such session, or it does not answer
  HAPTICD_BAD_ARGUMENT = 6,  // a mistake of the caller
  HAPTICD_FAILED = 7         // anything else, as memory that is used up
} hapticd_result;

typedef struct hapticd_session hapticd_session;  // a running session
typedef struct hapticd_frames hapticd_frames;    // a ring of it, which is read
typedef struct hapticd_giver hapticd_giver;      // a client that moves objects of it

// The last failure of this thread, whatever it was about: what a function that makes a handle has
// to say. Valid until the next call of the thread.
HAPTICD_API const char* hapticd_message(void);
// The last failure with a handle, or "". Valid until the next call with it.
HAPTICD_API const char* hapticd_session_message(const hapticd_session* session);
HAPTICD_API const char* hapticd_frames_message(const hapticd_frames* frames);
HAPTICD_API const char* hapticd_giver_message(const hapticd_giver* giver);

// --- a session -----------------------------------------------------------------------------------

// Finds a running session; NULL or "": the only one.
HAPTICD_API hapticd_result hapticd_attach(const char* name, hapticd_session** session);
// Frames and givers that were opened stay open.
HAPTICD_API void hapticd_detach(hapticd_session* session);
HAPTICD_API const char* hapticd_name(const hapticd_session* session);

// As `hapt set`: "stiffness", "800 N/m". It ramps over 200 ms.
HAPTICD_API hapticd_result hapticd_set(hapticd_session* session, const char* key,
                                       const char* value);
HAPTICD_API hapticd_result hapticd_arm(hapticd_session* session);
HAPTICD_API hapticd_result hapticd_disarm(hapticd_session* session);
HAPTICD_API hapticd_result hapticd_pause(hapticd_session* session);
HAPTICD_API hapticd_result hapticd_resume(hapticd_session* session);
// The text is that of `hapt status --json`, valid until the next call with the session.
HAPTICD_API hapticd_result hapticd_status(hapticd_session* session, const char** json);
// Any line as `hapt` sends it, as "clear-fault" or "stop". The answer, which may be NULL, is valid
// likewise.
HAPTICD_API hapticd_result hapticd_say(hapticd_session* session, const char* line,
                                       const char** answer);

// --- the rings -----------------------------------------------------------------------------------

typedef enum hapticd_ring {
  HAPTICD_SERVO = 0,    // ServoFrames of a hand: the tool, the force; 1 kHz
  HAPTICD_CONTACT = 1,  // ContactSets of a hand: the contacts
  HAPTICD_SIM = 2,      // SceneFrames: where the objects are
  HAPTICD_CONTROL = 3   // ControlFrames: the wanted state, at each change and ten times a second
} hapticd_ring;

typedef enum hapticd_start {
  HAPTICD_FROM_NOW = 0,    // only what comes from now on
  HAPTICD_FROM_OLDEST = 1  // what the ring still holds
} hapticd_start;

// `hand` counts from 0; of HAPTICD_SIM and HAPTICD_CONTROL it is 0.
HAPTICD_API hapticd_result hapticd_frames_open(hapticd_session* session, hapticd_ring ring,
                                               uint32_t hand, hapticd_start start,
                                               hapticd_frames** frames);
HAPTICD_API void hapticd_frames_close(hapticd_frames* frames);

// The next record in order. It is a copy, and stays until the next one is read.
HAPTICD_API hapticd_result hapticd_frames_next(hapticd_frames* frames);
// The newest record; HAPTICD_NOTHING: the one that was read last is still the newest.
HAPTICD_API hapticd_result hapticd_frames_latest(hapticd_frames* frames);
// Waits until there is a record to read, at most for `timeout` seconds; below 0: for ever. The
// present record stays.
HAPTICD_API hapticd_result hapticd_frames_wait(hapticd_frames* frames, double timeout);
// After HAPTICD_LOST: waits until hapticd is back, at most for `timeout` seconds; below 0: for
// ever. The ring has begun anew, and is read from its beginning.
HAPTICD_API hapticd_result hapticd_frames_reconnect(hapticd_frames* frames, double timeout);
// Records that _next could not deliver, since they were overwritten; 0 of NULL.
HAPTICD_API uint64_t hapticd_frames_lost(const hapticd_frames* frames);

// --- the present record --------------------------------------------------------------------------

typedef struct hapticd_pose {
  double p[3];  // [m]
  double q[4];  // x y z w
} hapticd_pose;

typedef struct hapticd_twist {
  double v[3];  // [m/s]
  double w[3];  // [rad/s]
} hapticd_twist;

typedef struct hapticd_wrench {
  double f[3];  // [N]
  double t[3];  // [N·m]
} hapticd_wrench;

// A record of HAPTICD_SERVO. The numbers of flags and codes are those of proto/wire/wire.h.
typedef struct hapticd_servo {
  uint32_t size;
  uint32_t flags;               // ServoFlag
  uint64_t tick;                // missed ticks leave a gap
  int64_t t_ns;                 // [ns] CLOCK_MONOTONIC
  int64_t realtime_ns;          // [ns] the same instant on CLOCK_REALTIME
  hapticd_pose X_WT;            // the tool
  hapticd_twist V_WT;           // its velocity, in W
  hapticd_pose X_WP;            // its proxy, which stays outside of the objects
  hapticd_wrench F_coupling_W;  // on the tool at its origin, in W, before safety
  hapticd_wrench F_device_B;    // on the hand, at the handle's origin, in B
  hapticd_pose X_BH;            // the handle, as measured
  hapticd_twist V_BH;           // its velocity, in B
  double depth;                 // [m] from tool to proxy
  uint32_t buttons;             // a bit each
  uint32_t device_flags;        // DeviceFlag
  uint32_t n_contacts;          // planes that push
  uint32_t fault;               // Fault
} hapticd_servo;

// A record of HAPTICD_CONTACT.
typedef struct hapticd_contact_set {
  uint32_t size;
  uint32_t flags;       // ContactFlag
  uint64_t seq;         // one higher with each set
  uint64_t tick;        // of the ServoFrame that it answers
  int64_t t_ns;         // [ns] of that frame
  hapticd_pose X_WT;    // the tool of the query; 6-DoF: the proxy's
  hapticd_pose X_WG;    // the verified proxy
  uint32_t n_contacts;  // for hapticd_frames_contact
  uint32_t n_active;    // the first ones, which push; 6-DoF: number that touch
  uint32_t n_objects;   // for hapticd_frames_object
  uint32_t reserved;
} hapticd_contact_set;

typedef struct hapticd_contact {
  uint32_t size;
  uint32_t object;           // that it is of; the vectors are in its frame
  double tool_point_T[3];    // [m]
  double object_point_O[3];  // [m]
  double normal_O[3];        // from object to tool
  double stiffness;          // [N/m] of a soft one; 0: a plane
  uint64_t feature;          // of the mesh: 2 bits kind (0 face, 1 edge, 2 vertex), then its index
} hapticd_contact;

// A record of HAPTICD_SIM.
typedef struct hapticd_scene {
  uint32_t size;
  uint32_t flags;
  uint64_t seq;        // one higher with each frame
  int64_t t_ns;        // [ns] CLOCK_MONOTONIC
  uint32_t n_objects;  // for hapticd_frames_object
  uint32_t n_hands;
} hapticd_scene;

// An object of a record of HAPTICD_SIM; one of HAPTICD_CONTACT has the pose of the query and the
// clearance alone.
typedef struct hapticd_object {
  uint32_t size;
  uint32_t mover;      // who moves it: 0 sim, 1 + k the client k
  int64_t t_ns;        // [ns] of the pose, CLOCK_MONOTONIC
  hapticd_pose X_WO;   // its pose
  hapticd_twist V_WO;  // its velocity, in W
  double clearance;    // [m] for how far it is surely free of a 6-DoF tool; 0: unknown
} hapticd_object;

// A record of HAPTICD_CONTROL.
typedef struct hapticd_control {
  uint32_t size;
  uint32_t armed;
  uint64_t revision;               // one higher with each change
  int64_t t_ns;                    // [ns] CLOCK_MONOTONIC
  double translational_stiffness;  // [N/m]
  double translational_damping;    // [N·s/m]
  double rotational_stiffness;     // [N·m/rad]
  double rotational_damping;       // [N·m·s/rad]
  double scene_time_scale;         // 1: scripted motion at its own speed
  uint32_t paused;
  uint32_t fault;     // Fault
  uint32_t renderer;  // Renderer
  uint32_t solver;    // 1 + SoftSolver; 0: as the session's file says
} hapticd_control;

HAPTICD_API hapticd_result hapticd_frames_servo(hapticd_frames* frames, hapticd_servo* servo);
HAPTICD_API hapticd_result hapticd_frames_contact_set(hapticd_frames* frames,
                                                      hapticd_contact_set* set);
HAPTICD_API hapticd_result hapticd_frames_scene(hapticd_frames* frames, hapticd_scene* scene);
HAPTICD_API hapticd_result hapticd_frames_control(hapticd_frames* frames, hapticd_control* control);

// Of the present record; 0 where there is none.
HAPTICD_API uint32_t hapticd_frames_n_contacts(const hapticd_frames* frames);
HAPTICD_API uint32_t hapticd_frames_n_objects(const hapticd_frames* frames);
HAPTICD_API hapticd_result hapticd_frames_contact(hapticd_frames* frames, uint32_t index,
                                                  hapticd_contact* contact);
HAPTICD_API hapticd_result hapticd_frames_object(hapticd_frames* frames, uint32_t index,
                                                 hapticd_object* object);

// The record as docs/wire.md lays it out, which is another with another hapticd_wire_version(): its
// bytes before the lists, and a list by its name, as "pushes". Valid until the next one is read.
HAPTICD_API uint32_t hapticd_wire_version(void);
HAPTICD_API hapticd_result hapticd_frames_record(hapticd_frames* frames, const void** bytes,
                                                 size_t* size);
HAPTICD_API hapticd_result hapticd_frames_list(hapticd_frames* frames, const char* name,
                                               const void** values, size_t* count,
                                               size_t* size_of_one);

// --- giving --------------------------------------------------------------------------------------

// What the hands have pushed an object with, as the force that is linear in time and has the same
// impulse and the same integral of it: mean + (t − span/2) · slope, about the object's origin, in
// W; forces first, then torques.
typedef struct hapticd_push {
  uint32_t size;
  uint32_t reserved;
  int64_t t_ns;     // [ns] CLOCK_MONOTONIC: until when
  double span;      // [s] since the last time; 0: nothing is known yet
  double mean[6];   // [N, N·m]
  double slope[6];  // [N/s, N·m/s]
} hapticd_push;

// How an object moves, and how it answers a push until the next frame:
// X″ = a + M⁻¹ [F − D (V − V_WO) − K (X − X_WO)]. Matrices are in W, about the object's origin, row
// by row, moving first, then turning. A body of mass m that is free to move and does not turn has
// mobility[0] = mobility[7] = mobility[14] = 1/m.
typedef struct hapticd_motion {
  uint32_t size;
  uint32_t object;               // of hapticd_giver_object
  hapticd_pose X_WO;             // at the instant of the last hapticd_giver_pushed
  hapticd_twist V_WO;            // in W
  hapticd_twist acceleration_W;  // [m/s², rad/s²] by all but hands
  double mobility[36];           // M⁻¹; zero: a push moves it not
  double stiffness[36];          // K, of its own world
  double damping[36];            // D, likewise
  double power;                  // [W] of what drives it, at most its client's max_power
} hapticd_motion;

// A wrench on a hand's tool at its origin, in W, which may pull: F = F0 + K (X - X_WT) - B V. K and
// B row by row, moving first, then turning.
typedef struct hapticd_tool_wrench {
  uint32_t size;
  uint32_t hand;        // index in the session file
  hapticd_pose X_WT;    // pose of the tool that F0 is for
  hapticd_wrench F0_W;  // of a tool at rest there
  double K[36];  // its derivative by the tool's motion, symmetric; of a spring it is negative
  double B[36];  // by which the tool is braked
  double trust_radius;  // [m] from X_WT within which K is right; the wrench stays beyond
} hapticd_tool_wrench;

// A plane that a hand's tool does not pass: n·(tool point - point) >= 0.
typedef struct hapticd_plane {
  uint32_t size;
  uint32_t hand;
  uint32_t object;         // that it is on, index in the scene; HAPTICD_WORLD: none
  uint32_t reserved;       // zero
  double tool_point_T[3];  // [m] on the tool, in its frame
  double point_O[3];       // [m] on the plane, in the object's frame
  double normal_O[3];      // of length 1, towards the tool
  double extent;           // [m] radius around the point in which it holds; 0: no bound
  double stiffness;        // [N/m] where the tool may enter; 0: that of the session's contacts
  uint64_t feature;        // an id of yours
} hapticd_plane;
#define HAPTICD_WORLD 256u

// Becomes the client that a [[client]] of the session file names (docs/clients-that-give.md).
HAPTICD_API hapticd_result hapticd_give(hapticd_session* session, const char* name,
                                        hapticd_giver** giver);
// Leaves the session; all that it gives fades.
HAPTICD_API void hapticd_giver_close(hapticd_giver* giver);
// The index of an object that it may move.
HAPTICD_API hapticd_result hapticd_giver_object(hapticd_giver* giver, const char* name,
                                                uint32_t* index);
// What the hands have pushed the object with since the last time. The first call begins to count.
HAPTICD_API hapticd_result hapticd_giver_pushed(hapticd_giver* giver, uint32_t object,
                                                hapticd_push* push);
HAPTICD_API hapticd_result hapticd_giver_move(hapticd_giver* giver, const hapticd_motion* motion);
// The right "push": a wrench until the next publishing.
HAPTICD_API hapticd_result hapticd_giver_push(hapticd_giver* giver,
                                              const hapticd_tool_wrench* push);
// The right "touch": one of at most 24 planes until the next publishing.
HAPTICD_API hapticd_result hapticd_giver_touch(hapticd_giver* giver, const hapticd_plane* plane);
// Publishes what has been said since the last time; wrenches and planes not said again are gone.
HAPTICD_API hapticd_result hapticd_giver_publish(hapticd_giver* giver);

// A dot and a line that viewers draw, as `hapt view`. They come in arrays and keep their sizes.
typedef struct hapticd_point {
  double p[3];      // [m] in W
  double radius;    // [m]
  uint32_t colour;  // 0xRRGGBB
  uint32_t reserved;
} hapticd_point;

typedef struct hapticd_line {
  double from[3];  // [m] in W
  double to[3];
  uint32_t colour;  // 0xRRGGBB
  uint32_t reserved;
} hapticd_line;

// Shows these in place of what was shown last, at most 200,000 points and 20,000 lines; an array of
// none may be NULL. HAPTICD_NOTHING: nothing was drawn, for it is too soon after the last: 60
// drawings are shown in a second, 5 where one has more than 20,000 points or 2,000 lines. Viewers
// alone see it; the [[client]] has may = ["draw"]. It goes when the giver is closed.
HAPTICD_API hapticd_result hapticd_giver_draw(hapticd_giver* giver, const hapticd_point* points,
                                              size_t n_points, const hapticd_line* lines,
                                              size_t n_lines);

// Sleeps; C99 alone cannot.
HAPTICD_API void hapticd_sleep(double seconds);

#ifdef __cplusplus
}
#endif

#endif
