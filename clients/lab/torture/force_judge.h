// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "device-io/emulator/firmware.h"

namespace haptic {

/// The part of the wrench that is judged.
enum class Part { kForce, kTorque };

/// The session under test: a hand on an emulated device presses into the half space z < 0 of the
/// device's frame B, which pushes it up by its depth. A device that turns presses a tool with a
/// flat bottom, which the half space also turns upright, by its tilt. Or the hand rests and holds a
/// body, whose weight draws it down. These are the rules of one part; those of torque are in the
/// units in brackets.
struct ForceRules {
  double stiffness = 500;         // of the spring [N/m or N·m/rad]
  double max_force = 3.6;         // [N or N·m]
  double max_damping = 2;         // bound of the passivity controller [N·s/m or N·m·s/rad]
  double slew = 200;              // limit of a force that grows by itself [N/s or N·m/s]
  double soft_start = 0.1;        // [s]
  int64_t tick_ns = 1'000'000;    // of the servo
  int64_t zero_ns = 20'000'000;   // documented: time to zero after a fault that closes the force
  int64_t hold_ns = 100'000'000;  // documented: contacts are rendered in full no longer than this
  int64_t fade_ns = 50'000'000;   // documented: then fade over this
  int64_t doubt_ns = 20'000'000;  // documented: a pose is held this long if answers do not match
  Part part = Part::kForce;
  // half a milliampere in each motor, at the handle where the hand presses [N or N·m]
  double step = 5e-3;
  // by which more may be felt while contact has not settled: planes of a tool are linear in its
  // turn
  double bend = 0;
  double pressing = 2e-3;  // depth or tilt of a pressing hand [m or rad]
  // of a body that hangs from the hand, and by which the force may differ from it; above zero the
  // hand rests, and this weight takes the place of the wall [N]
  double weight = 0, sway = 0;
  size_t in_a_row = 10;  // commands that prove recovery
  const Arm* arm = &woodenhaptics_arm();
  Quat tool_on_grip{};  // orientation of the tool in the handle
};

/// An interval in which no process on this machine could run [ns].
struct Stall {
  int64_t begin_ns, end_ns;
};

/// Total time of the stalls between two instants [ns]; the stalls must not overlap.
int64_t held_up(std::span<const Stall> stalls, int64_t from_ns, int64_t to_ns);

/// Allowed effect of a fault on the force.
enum class Effect {
  kLies,     // contact sends false planes: within limits, no fast rise
  kLimits,   // only the general limits: bounded, never more than the wall, no fast rise
  kNothing,  // every command is the spring as before
  kFade,     // contacts age: hold, fade, zero until it is over; back by a ramp
  kZero,     // zero at once and until it is over, then soft start
  kSilence,  // the device is away; on its return zero first, then soft start
};

/// An injected fault. Times are CLOCK_MONOTONIC, as in the emulator's log.
struct JudgedFault {
  Effect effect = Effect::kNothing;
  int64_t begin_ns = 0;            // when it was known to have happened
  int64_t over_ns = 0;             // when its cause ended; 0: unknown, as with a dead servo
  int64_t soft_ns = 0;             // start of a new servo's soft start; 0: at the last zero
  std::vector<Stall> stalls = {};  // measured by witnesses; documented times are extended by them
  bool is_misled = false;          // the device reports false data, which takes time to detect
  int64_t from_ns = 0;             // earlier commands are context only
};

enum class ForceBreach {
  kTooStrong,    // above the largest force
  kBeyondWall,   // more than spring and damper at the deepest of the last answers
  kRise,         // faster than hand motion and slew limit allow
  kChanged,      // not the spring although nothing may change
  kLateFade,     // more than aged contacts may still give
  kLateZero,     // not zero in time, or never
  kEarlyReturn,  // force before the fault was over
  kHardStart,    // faster than the soft start
  kLostRecord,   // a gap in the emulator's log, where nothing can be checked
};
inline constexpr size_t kForceBreaches = 9;  // number of them

std::string_view name_of(ForceBreach breach);

/// The first breach of its kind: time, force and allowed force [N or N·m].
struct ForceViolation {
  ForceBreach breach;
  int64_t t_ns;
  double force;
  double allowed;
};

struct ForceVerdict {
  std::vector<ForceViolation> violations;  // at most one of each kind
  std::optional<int64_t> zero_after_ns;    // from begin_ns to the first zero; nothing: never zero
  size_t excused = 0;  // kNothing: commands not checked, because the machine had stalled
};

/// The turn from upright to a tool of this orientation that is not about z: a rotation vector
/// without z [rad].
Vec3 tilt_of(const Quat& q_BT);

/// True if a command equals the spring at the depth known to the server, within the passivity
/// controller's damping at `speed` [m/s or rad/s] and the step of the currents.
bool is_wall(const ForceRules& rules, const EmulatorRecord& command, double speed);

/// Checks the commands that the device received around one fault. The records are those of the
/// emulator, in order, from some ticks before the fault (pressing) to its end. A rise is allowed up
/// to k·(increase of the measured depth) + damping + slew·dt.
ForceVerdict judge_force(const ForceRules& rules, std::span<const EmulatorRecord> records,
                         const JudgedFault& fault);

/// Time of recovery after from_ns: the first of in_a_row consecutive commands that equal the wall
/// of a pressing hand. Nothing: not yet.
std::optional<int64_t> whole_again(const ForceRules& rules, std::span<const EmulatorRecord> records,
                                   int64_t from_ns);

/// Stalls of the emulator itself: it writes a record at least every 10 ms, and the rest of a longer
/// gap is its own delay.
std::vector<Stall> emulator_stalls(std::span<const EmulatorRecord> records);

/// The stalls that end later than `since_ns`, in order and without overlap.
std::vector<Stall> stalls_since(std::vector<Stall> stalls, int64_t since_ns);

/// The union of two lists of stalls, in order of time and without overlap.
std::vector<Stall> merge_stalls(std::span<const Stall> a, std::span<const Stall> b);

}  // namespace haptic
